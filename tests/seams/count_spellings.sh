#!/bin/bash
# Counts how often the product spells a stage's name outside the stage's own folder, and how often it branches on one: each
# is an edit that a new stage would need.
# Usage: count_spellings.sh <root> <plumb> [<most spellings> <most branches>]
# Prints every file with its count; exit status 1 where there are more than allowed, 2 if it could not look.
set -uo pipefail
root=${1:?usage: count_spellings.sh <root> <plumb> [<most spellings> <most branches>]}
plumb=${2:?}
cd "$root" || exit 2
names=$("$plumb" stages | grep -oE '^[a-z_]+(\.[a-z_]+)?$' | sort -u)
[ -n "$names" ] || { echo "count_spellings: $plumb stages names no stage" >&2; exit 2; }

# Names that are also something else, which the product may spell: a method or a section of a scene file (rsm, direct,
# shadow, compose, tonemap, reference), a layer of a picture or a parameter's name.
others='^(rsm|direct|shadow|compose|tonemap|reference)$'

# What is counted: the product but for experiments, which are about methods, and gi/methods.cpp, which lists them.
files=$(find core raster gi io tools -name '*.cpp' -o -name '*.h' -o -name '*.js' | grep -v '^tools/experiments/' | sort)
# A stage's own folder.
folder_of() {
    case $1 in
        gbuffer* | hemicube | texture_space) echo raster ;;
        shadow.*) echo gi/direct ;;
        *) echo "gi/${1%%.*}" ;;
    esac
}
spellings=0 branches=0
for name in $(grep -vE "$others" <<< "$names"); do
    elsewhere=$(grep -vE "^$(folder_of "$name")/" <<< "$files")
    literal="\"${name//./\\.}\""
    found=$(xargs grep -cE "$literal" <<< "$elsewhere" | grep -v ':0$')
    [ -n "$found" ] || continue
    while IFS=: read -r file _; do
        n=$(grep -oE "$literal" "$file" | wc -l)
        b=$(grep -oE "[=!]= *$literal|$literal *[=!]=" "$file" | wc -l)
        printf '%s %s %s\n' "$file" "$n" "$b"
    done <<< "$found"
done | awk '{ n[$1] += $2; b[$1] += $3 } END { for (f in n) print f, n[f], b[f] }' | sort > "${TMPDIR:-/tmp}/spellings.$$"
while read -r file n b; do
    echo "$file: $n spellings, $b branches"
    spellings=$((spellings + n)) branches=$((branches + b))
done < "${TMPDIR:-/tmp}/spellings.$$"
count=$(wc -l < "${TMPDIR:-/tmp}/spellings.$$")
rm -f "${TMPDIR:-/tmp}/spellings.$$"
echo "count_spellings: $spellings spellings in $count files, $branches branches"
[ $# -lt 4 ] && exit 0
[ "$spellings" -le "$3" ] && [ "$branches" -le "$4" ]
