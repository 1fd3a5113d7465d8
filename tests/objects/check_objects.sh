#!/bin/bash
# Reads the object code for what would break the promise of equal bits:
#   - instructions that round otherwise than their parts (fma), that only estimate (rcp, rsqrt), or x87 arithmetic;
#   - calls of libm functions whose result depends on the libm;
#   - symbols that a linker could take from an instruction set that the processor may lack.
# Usage: check_objects.sh <folder>, with in the folder the lists of paths
#   scalar.list sse.list avx2.list avx512.list   kernel objects; the last three hold instructions of their set
#   host.list                                    the other objects of core, raster, gi
#   io.list                                      objects of io and the tools: only libm calls are looked for
# Prints every finding; exit status 1 if there is any, 2 if it could not look.
set -uo pipefail
export LC_ALL=C
folder=${1:?usage: check_objects.sh <folder>}
cd "$folder" || exit 2
scratch=$(mktemp -d) || exit 2
trap 'rm -rf "$scratch"' EXIT
: > "$scratch/findings"
sets=(scalar sse avx2 avx512)

fail() { echo "check_objects: $*" >&2; exit 2; }
report() { # report <what>: one finding a line of standard input
    sort -u | sed "s/^/$1: /" | tee -a "$scratch/findings"
}

for list in "${sets[@]/%/.list}" host.list io.list; do
    [ -f "$list" ] || fail "there is no $folder/$list"
    grep -v '^$' "$list" > "$scratch/$list"
    while read -r path; do [ -f "$path" ] || fail "$list: there is no $path"; done < "$scratch/$list"
done
for list in "${sets[@]/%/.list}" host.list; do [ -s "$scratch/$list" ] || fail "$list is empty"; done

# Every instruction of an object is one line "<object> <function> <mnemonic>".
instructions() {
    xargs objdump -d --no-show-raw-insn | awk '
        / file format /      { object = $1; sub(/:$/, "", object); sub(/.*\//, "", object) }
        /^[0-9a-f]+ <.*>:$/  { name = $2 }
        /^ +[0-9a-f]+:\t/    { split($0, field, "\t"); split(field[2], word, " "); print object, name, word[1] }'
}
for list in "${sets[@]/%/.list}" host.list; do
    instructions < "$scratch/$list" > "$scratch/instructions" || fail "objdump could not read $list"
    [ -s "$scratch/instructions" ] || fail "objdump found no instruction in $list"
    awk '$3 ~ /^vfn?m(add|sub)|^v?r(cp|sqrt)(14|28)?[ps][sdh]$|^vexp2p/' "$scratch/instructions" |
        report "${list%.list}: forbidden instruction"
    awk '$3 ~ /^f(i?(add|sub|mul|div)r?p?|sqrt|sin|cos|sincos|p?tan|patan|2xm1|yl2x|yl2xp1|rndint|prem1?|scale|ld[sl]|ild)/' \
        "$scratch/instructions" | report "${list%.list}: x87 arithmetic"
done

# What libm returns for these differs between its versions and between processors; the exact ones (floor, sqrt, ldexp,
# fmod, ...) do not.
inexact='(exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|sin|cos|sincos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh'
inexact+='|atanh|cbrt|hypot|erf|erfc|tgamma|lgamma|fma)'
for list in "${sets[@]/%/.list}" host.list io.list; do
    [ -s "$scratch/$list" ] || continue
    xargs nm -A --undefined-only < "$scratch/$list" > "$scratch/symbols" || fail "nm could not read $list"
    sed -nE "s/^(.*\/)?([^/]*):[^:]* U (__)?(${inexact}[fl]?(_finite)?)(@.*)?$/\2 \4/p" "$scratch/symbols" |
        report "${list%.list}: call of libm"
done

# A linker takes a weak symbol from any object that defines it, also from one that is not ours. So a wide set shares none
# with the others, and each of its own carries the name of the set (4avx2), or its number (Isa::avx2).
weak_symbols() { # "<object> <symbol>"; not the pointers to the personality routine, which are data
    xargs nm -A --defined-only | sed -nE 's/^(.*\/)?([^/]*):[0-9a-f]* [WVu] (.*)$/\2 \3/p' | grep -v ' DW\.ref\.'
}
for list in "${sets[@]/%/.list}" host.list; do
    weak_symbols < "$scratch/$list" | sort -u > "$scratch/${list%.list}.weak"
    cut -d ' ' -f 2 "$scratch/${list%.list}.weak" | sort -u > "$scratch/${list%.list}.names"
done
number=0
for set in sse avx2 avx512; do
    number=$((number + 1))
    for other in "${sets[@]}" host; do
        [ "$set" = "$other" ] && continue
        comm -12 "$scratch/$set.names" "$scratch/$other.names" | c++filt | report "weak symbol of $set and $other"
    done
    grep -vE " .*(${#set}${set}|3IsaE${number}E)" "$scratch/$set.weak" | c++filt |
        report "$set: weak symbol without the name of the set"
done

if [ -s "$scratch/findings" ]; then
    echo "check_objects: $(wc -l < "$scratch/findings") findings"
    exit 1
fi
echo "check_objects: nothing in $(cat "$scratch"/*.list | wc -l) objects"
