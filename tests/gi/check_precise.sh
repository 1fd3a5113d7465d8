#!/bin/bash
# check_precise.sh <folder of .spv>: every floating-point operation of a twin (core, raster, gi and their tests) is
# decorated NoContraction (`precise` in GLSL), so that a driver may neither fuse nor reorder it. Prints each that is not,
# and fails.
set -euo pipefail
shopt -s nullglob
modules=("$1"/{raster,gi,tests.core}.*.spv)
[ ${#modules[@]} -gt 0 ] || { echo "no SPIR-V in $1"; exit 1; }
status=0
for module in "${modules[@]}"; do
    spirv-dis --raw-id "$module" | awk -v name="${module##*/}" '
        $1 == "OpDecorate" && $3 == "NoContraction" { precise[$2] = 1 }
        $3 ~ /^Op(FAdd|FSub|FMul|FDiv|FNegate|VectorTimesScalar|MatrixTimesVector|VectorTimesMatrix|MatrixTimesMatrix|Dot)$/ {
            ++operations
            if ($3 != "OpFNegate" && !precise[$1]) { print name ": not precise: " $0; bad = 1 }
        }
        END { printf "%s: %d operations\n", name, operations; exit bad }' || status=1
done
exit $status
