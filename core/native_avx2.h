// AVX2 and F16C: eight lanes.
#pragma once

#include <immintrin.h>

#include "core/number.h"

namespace plumb::PLUMB_ISA::native {

inline constexpr int width = 8;
using Real = __m256;
typedef std::int32_t Int __attribute__((vector_size(32)));
typedef std::uint32_t UInt __attribute__((vector_size(32)));
using Mask = Int;  // all ones or all zeros a lane

PLUMB_INLINE Mask mask_and(Mask a, Mask b) { return a & b; }
PLUMB_INLINE Mask mask_or(Mask a, Mask b) { return a | b; }
PLUMB_INLINE Mask mask_not(Mask a) { return ~a; }
PLUMB_INLINE bool any(Mask a) { return _mm256_movemask_ps((__m256)a) != 0; }

PLUMB_INLINE Real splat(float x) { return _mm256_set1_ps(x); }
PLUMB_INLINE Int iota() { return Int{0, 1, 2, 3, 4, 5, 6, 7}; }
PLUMB_INLINE Real negate(Real a) { return _mm256_xor_ps(a, _mm256_set1_ps(-0.0f)); }
PLUMB_INLINE Real abs(Real a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
PLUMB_INLINE Real sqrt(Real a) { return _mm256_sqrt_ps(a); }
PLUMB_INLINE Real floor(Real a) { return _mm256_floor_ps(a); }
PLUMB_INLINE Real min(Real a, Real b) { return _mm256_min_ps(a, b); }
PLUMB_INLINE Real max(Real a, Real b) { return _mm256_max_ps(a, b); }
PLUMB_INLINE Int min(Int a, Int b) { return (Int)_mm256_min_epi32((__m256i)a, (__m256i)b); }
PLUMB_INLINE Int max(Int a, Int b) { return (Int)_mm256_max_epi32((__m256i)a, (__m256i)b); }
PLUMB_INLINE Mask less(Real a, Real b) { return (Mask)_mm256_cmp_ps(a, b, _CMP_LT_OQ); }
PLUMB_INLINE Mask less_equal(Real a, Real b) { return (Mask)_mm256_cmp_ps(a, b, _CMP_LE_OQ); }
PLUMB_INLINE Mask equal(Real a, Real b) { return (Mask)_mm256_cmp_ps(a, b, _CMP_EQ_OQ); }
PLUMB_INLINE Mask less(Int a, Int b) { return a < b; }
PLUMB_INLINE Mask less_unsigned(Int a, Int b) { return (Mask)((UInt)a < (UInt)b); }
PLUMB_INLINE Mask equal(Int a, Int b) { return a == b; }
PLUMB_INLINE Real select(Mask m, Real a, Real b) { return _mm256_blendv_ps(b, a, (__m256)m); }
PLUMB_INLINE Int select(Mask m, Int a, Int b) { return (m & a) | (~m & b); }
PLUMB_INLINE Int round_to_int(Real a) { return (Int)_mm256_cvtps_epi32(a); }
PLUMB_INLINE Int truncate_to_int(Real a) { return (Int)_mm256_cvttps_epi32(a); }
PLUMB_INLINE Real from_int(Int a) { return _mm256_cvtepi32_ps((__m256i)a); }

PLUMB_INLINE Real gather(const float* p, Int i) { return _mm256_i32gather_ps(p, (__m256i)i, 4); }
PLUMB_INLINE Int gather(const std::int32_t* p, Int i) { return (Int)_mm256_i32gather_epi32(p, (__m256i)i, 4); }

// Where each lane's texel lies, in bytes from the first. It goes through memory on purpose: a compiler that knows what
// is in it takes the lanes out of the vector one by one, on the port that the shuffles need.
struct Places {
    alignas(32) std::int64_t byte[8];
    Places() = default;
    PLUMB_INLINE Places(Int i, std::int64_t bytes) {
        typedef std::int64_t Long __attribute__((vector_size(32)));
        const Long lower = (Long)_mm256_cvtepi32_epi64(_mm256_castsi256_si128((__m256i)i));
        const Long upper = (Long)_mm256_cvtepi32_epi64(_mm256_extracti128_si256((__m256i)i, 1));
        _mm256_store_si256((__m256i*)byte, (__m256i)(lower * bytes));
        _mm256_store_si256((__m256i*)byte + 1, (__m256i)(upper * bytes));
        asm("" : "+m"(byte));
    }
};
// 16 bytes of lanes k and k + 4, from byte `at` of each one's texel.
PLUMB_INLINE Real load_pair(const void* p, std::ptrdiff_t at, const Places& i, int k) {
    const char* base = static_cast<const char*>(p) + at;
    const Real r = _mm256_castps128_ps256(_mm_loadu_ps((const float*)(base + i.byte[k])));
    return _mm256_insertf128_ps(r, _mm_loadu_ps((const float*)(base + i.byte[k + 4])), 1);
}
// Four rows of four words within each half: t[c] holds word c of each row.
PLUMB_INLINE void transpose(Real r0, Real r1, Real r2, Real r3, Real* t) {
    const Real a = _mm256_unpacklo_ps(r0, r1), b = _mm256_unpackhi_ps(r0, r1);
    const Real c = _mm256_unpacklo_ps(r2, r3), d = _mm256_unpackhi_ps(r2, r3);
    t[0] = (Real)_mm256_unpacklo_pd((__m256d)a, (__m256d)c);
    t[1] = (Real)_mm256_unpackhi_pd((__m256d)a, (__m256d)c);
    t[2] = (Real)_mm256_unpacklo_pd((__m256d)b, (__m256d)d);
    t[3] = (Real)_mm256_unpackhi_pd((__m256d)b, (__m256d)d);
}
// Loads 16 bytes a lane and transposes: t[c] holds word c of lanes 0..7.
PLUMB_INLINE void load_words(const void* p, std::ptrdiff_t at, const Places& i, Real* t) {
    transpose(load_pair(p, at, i, 0), load_pair(p, at, i, 1), load_pair(p, at, i, 2), load_pair(p, at, i, 3), t);
}
// The other way: word c of all lanes is t[c]; 16 bytes a lane.
PLUMB_INLINE void store_texels(float* p, Int i, const Real* t) {
    const Places places(i, 16);
    Real r[4];
    transpose(t[0], t[1], t[2], t[3], r);
    for (int k = 0; k < 4; ++k) {
        _mm_storeu_ps((float*)((char*)p + places.byte[k]), _mm256_castps256_ps128(r[k]));
        _mm_storeu_ps((float*)((char*)p + places.byte[k + 4]), _mm256_extractf128_ps(r[k], 1));
    }
}
// Eight 32-bit lanes of two halves each: the lower halves as floats, the upper halves as floats.
PLUMB_INLINE void widen_pairs(Real pairs, Real* lower, Real* upper) {
    const __m256i words = (__m256i)pairs;
    auto widen = [](__m256i x) {
        x = _mm256_permute4x64_epi64(_mm256_packus_epi32(x, x), 0x08);
        return _mm256_cvtph_ps(_mm256_castsi256_si128(x));
    };
    *lower = widen(_mm256_and_si256(words, _mm256_set1_epi32(0xffff)));
    *upper = widen(_mm256_srli_epi32(words, 16));
}

// Loads the texel at p + stride i of every lane whole, and transposes: t[c] is component c of all lanes.
PLUMB_INLINE void load_texels(const float* p, int stride, Int i, Real* t) {
    load_words(p, 0, Places(i, 4 * stride), t);
}
// A texel of four halves is 8 bytes: two gathers fetch its two pairs.
PLUMB_INLINE void load_texels(const Half* p, int stride, Int i, Real* t) {
    const __m256i at = (__m256i)(i * (stride / 2));
    widen_pairs((Real)_mm256_i32gather_epi32((const int*)p, at, 4), t, t + 1);
    widen_pairs((Real)_mm256_i32gather_epi32((const int*)p + 1, at, 4), t + 2, t + 3);
}
PLUMB_INLINE void load_records(const float* p, const Places& places, Real* t) {
    load_words(p, 0, places, t);
    load_words(p, 16, places, t + 4);
    load_words(p, 32, places, t + 8);
}
// A record of halves is one register: a and b of it in the lower half, c in the upper. Both halves are transposed at once,
// words of four lanes first, so that a component of all lanes is 16 bytes, which widen as they are.
PLUMB_INLINE __m256i load_halves(const Half* p, const Places& i, int k) {
    return _mm256_loadu_si256((const __m256i*)((const char*)p + i.byte[k]));
}
PLUMB_INLINE void sort_four(const Half* p, const Places& i, int k, __m256i* words) {
    const __m256i r0 = load_halves(p, i, k), r1 = load_halves(p, i, k + 1);
    const __m256i r2 = load_halves(p, i, k + 2), r3 = load_halves(p, i, k + 3);
    const __m256i a = _mm256_unpacklo_epi16(r0, r1), b = _mm256_unpackhi_epi16(r0, r1);
    const __m256i c = _mm256_unpacklo_epi16(r2, r3), d = _mm256_unpackhi_epi16(r2, r3);
    words[0] = _mm256_unpacklo_epi32(a, c), words[1] = _mm256_unpackhi_epi32(a, c);
    words[2] = _mm256_unpacklo_epi32(b, d), words[3] = _mm256_unpackhi_epi32(b, d);
}
PLUMB_INLINE Real widen_lower(__m256i words) { return _mm256_cvtph_ps(_mm256_castsi256_si128(words)); }
PLUMB_INLINE Real widen_upper(__m256i words) { return _mm256_cvtph_ps(_mm256_extracti128_si256(words, 1)); }
PLUMB_INLINE void load_records(const Half* p, const Places& places, Real* t) {
    __m256i first[4], second[4];
    sort_four(p, places, 0, first), sort_four(p, places, 4, second);
    const __m256i x = _mm256_unpacklo_epi64(first[0], second[0]), y = _mm256_unpackhi_epi64(first[0], second[0]);
    const __m256i z = _mm256_unpacklo_epi64(first[1], second[1]), w = _mm256_unpackhi_epi64(first[1], second[1]);
    t[0] = widen_lower(x), t[1] = widen_lower(y), t[2] = widen_lower(z), t[3] = widen_lower(w);
    t[4] = widen_lower(_mm256_unpacklo_epi64(first[2], second[2]));
    t[5] = widen_lower(_mm256_unpackhi_epi64(first[2], second[2]));
    t[6] = widen_lower(_mm256_unpacklo_epi64(first[3], second[3]));
    t[7] = widen_lower(_mm256_unpackhi_epi64(first[3], second[3]));
    t[8] = widen_upper(x), t[9] = widen_upper(y), t[10] = widen_upper(z), t[11] = widen_upper(w);
}

}  // namespace plumb::PLUMB_ISA::native
