#!/bin/bash
# Renders the Cornell box, with a point light beside its spot, and path traces it with exact rays, with every given
# program, by every instruction set of this machine, by 1, 2 and 3 threads, and once with AVX2 and FMA hidden from the C
# library: every picture and every input and output of a stage must be the same file. run.json alone may differ: it has
# times in it, and must name the set that ran.
# Usage: same_bits.sh [--size N] <folder to work in> <plumb>...
set -euo pipefail
size=61
[ "$1" != --size ] || { size=$2; shift 2; }
folder=$1
shift
[ $# -gt 0 ] || { echo "same_bits: no program named" >&2; exit 2; }
rm -rf "$folder"
mkdir -p "$folder"

sets=(scalar)
has() { grep -qwE "$1" /proc/cpuinfo; }
! has sse4_2 || sets+=(sse)
! has avx2 || sets+=(avx2)
! has avx512bw || sets+=(avx512)

# The scene is small, and its width no multiple of anything.
"$1" make-scene cornell -o "$folder/scene" > "$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
scene=$folder/scene/cornell.toml
sed -i "s/^size *=.*/size = [$((size * 3 / 2)), $size]/" "$scene"
grep -q "^size = \[$((size * 3 / 2)), $size\]" "$scene" || { echo "same_bits: $scene has no frame.size" >&2; exit 1; }
cat >> "$scene" << 'EOF'

[[light]]
name = "lamp"
type = "point"
position = [0.3, 0.9, 0.6]
intensity = [2, 1, 0.5]
rsm_size = 24
EOF

# sums <folder>: one line a file, its hash and its name.
sums() { (cd "$1" && find . -type f ! -name run.json | LC_ALL=C sort | xargs sha256sum); }

reference=
renders=0
render() { # render <what is said of it> <command>...: renders and holds the files against those of the first time
    local said=$1 out=$folder/out
    shift
    rm -rf "$out"
    "$@" -o "$out" > "$folder/log" 2>&1 || { echo "same_bits: $said: exit status $?"; cat "$folder/log"; exit 1; }
    sums "$out" > "$folder/sums"
    grep -q '\.exr$' "$folder/sums" || { echo "same_bits: $said: no EXR was written"; exit 1; }
    if [ -z "$reference" ]; then
        reference=$said
        cp "$folder/sums" "$folder/reference"
        grep -v /dump/ "$folder/reference"
    elif ! diff "$folder/reference" "$folder/sums" > "$folder/difference"; then
        echo "same_bits: $said differs from $reference:"
        cat "$folder/difference"
        exit 1
    fi
    renders=$((renders + 1))
}

# All that can be asked for; what was traced before is not read again.
what=(--dump --truth --spp 4 --rays exact --no-cache)
for plumb in "$@"; do
    for set in "${sets[@]}"; do
        for threads in 1 2 3; do
            render "$plumb --isa $set --threads $threads" \
                "$plumb" render "$scene" "${what[@]}" --isa "$set" --threads "$threads"
            grep -q "\"isa\": *\"$set\"" "$folder/out/run.json" ||
                { echo "same_bits: run.json does not say that $set ran"; exit 1; }
        done
    done
    render "$plumb with AVX2 and FMA hidden from the C library" \
        env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA "$plumb" render "$scene" "${what[@]}"
done
echo "same_bits: $renders renders by ${sets[*]}, the same $(wc -l < "$folder/reference") files"
