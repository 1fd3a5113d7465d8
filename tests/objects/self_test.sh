#!/bin/bash
# Shows that check_objects.sh can fail: it passes a clean set of objects, and rejects each planted fault by its name.
# Usage: self_test.sh <compiler>
set -euo pipefail
compiler=${1:?usage: self_test.sh <compiler>}
here=$(cd "$(dirname "$0")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

compile() { # compile <object> <flags> <source text>
    # shellcheck disable=SC2086  # flags are words
    "$compiler" -std=c++20 -O2 -ffp-contract=off $2 -x c++ -c -o "$1" - <<< "$3"
}
lists() { # lists <object to plant> <list that it goes into>
    for list in scalar sse avx2 avx512 host io; do echo "$scratch/clean_$list.o" > "$list.list"; done
    [ $# -eq 0 ] || echo "$scratch/$1" >> "$2.list"
}
rejects() { # rejects <list> <flags> <expected words> <source text>: the fault is found, and nothing else is
    compile planted.o "$2" "$4"
    lists planted.o "$1"
    if "$here/check_objects.sh" "$scratch" > output; then
        echo "not rejected: $4"; exit 1
    fi
    if ! grep -qE "^$3" output || grep -vE "^$3|^check_objects: " output; then
        echo "rejected for another reason: $4"; cat output; exit 1
    fi
    echo "rejected: $(grep -m 1 -E "^$3" output)"
}

for set in scalar sse avx2 avx512 host io; do
    compile "clean_$set.o" "" "namespace plumb::$set { float twice(float x) { return x + x; } }"
done
lists
"$here/check_objects.sh" "$scratch"

kernel='namespace plumb::avx2 { float f(float a, float b, float c) { return'
rejects avx2 "-mfma -ffp-contract=fast" "avx2: forbidden instruction: planted.o .* vfmadd" "$kernel a * b + c; } }"
rejects host "-mfma -ffp-contract=fast" "host: forbidden instruction: planted.o .* vfmsub" "$kernel a * b - c; } }"
rejects sse "-msse4.2" "sse: forbidden instruction: planted.o .* rsqrtss" \
    "#include <immintrin.h>
    __m128 f(__m128 x) { return _mm_rsqrt_ss(x); }"
rejects avx512 "-mavx512f" "avx512: forbidden instruction: planted.o .* vrcp14ps" \
    "#include <immintrin.h>
    __m512 f(__m512 x) { return _mm512_rcp14_ps(x); }"
rejects scalar "" "scalar: x87 arithmetic: planted.o .* fmul" \
    "void f(double* x, long double y) { *x = double(y * y); }"
rejects avx2 "-mavx2" "avx2: call of libm: planted.o expf" "#include <cmath>
    float f(float x) { return std::exp(x); }"
rejects host "-fno-builtin" "host: call of libm: planted.o pow" "#include <cmath>
    double f(double x) { return std::pow(x, 2.5); }"
rejects io "" "io: call of libm: planted.o (sin|cos|sincos)" "#include <cmath>
    double f(double x) { return std::sin(x); }"
rejects avx512 "" "avx512: weak symbol without the name" "template <class T> __attribute__((noinline)) T f(T x) { return x; }
    template float f(float);"

# A symbol that two sets share is found on both sides.
shared='namespace plumb { template <class T> T half_of(T x) { return x / 2; } template float half_of(float); }'
compile shared_host.o "" "$shared"
compile shared_avx2.o "-mavx2" "$shared"
lists shared_host.o host
echo "$scratch/shared_avx2.o" >> avx2.list
if "$here/check_objects.sh" "$scratch" > output || ! grep "^weak symbol of avx2 and host: float plumb::half_of" output; then
    echo "a shared weak symbol was not rejected"; cat output; exit 1
fi

# What cannot be read is a failure, not a pass.
lists nowhere.o avx2
! "$here/check_objects.sh" "$scratch" 2> /dev/null || { echo "a missing object was not rejected"; exit 1; }
lists
: > avx2.list
! "$here/check_objects.sh" "$scratch" 2> /dev/null || { echo "an empty list was not rejected"; exit 1; }
