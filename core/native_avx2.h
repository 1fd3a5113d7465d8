// AVX2 and F16C: eight lanes.
#pragma once

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
PLUMB_INLINE Mask equal(Int a, Int b) { return a == b; }
PLUMB_INLINE Real select(Mask m, Real a, Real b) { return _mm256_blendv_ps(b, a, (__m256)m); }
PLUMB_INLINE Int select(Mask m, Int a, Int b) { return (m & a) | (~m & b); }
PLUMB_INLINE Int round_to_int(Real a) { return (Int)_mm256_cvtps_epi32(a); }
PLUMB_INLINE Int truncate_to_int(Real a) { return (Int)_mm256_cvttps_epi32(a); }
PLUMB_INLINE Real from_int(Int a) { return _mm256_cvtepi32_ps((__m256i)a); }

PLUMB_INLINE Real gather(const float* p, Int i) { return _mm256_i32gather_ps(p, (__m256i)i, 4); }
PLUMB_INLINE Int gather(const std::int32_t* p, Int i) { return (Int)_mm256_i32gather_epi32(p, (__m256i)i, 4); }

// 16 bytes of lane k in the lower half, of lane k + 4 in the upper half.
PLUMB_INLINE __m256 load_pair(const void* lower, const void* upper) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps((const float*)lower)),
                                _mm_loadu_ps((const float*)upper), 1);
}
// Transposes 4 x 4 within each half: t[c] holds element c of lanes 0..7.
PLUMB_INLINE void transpose(Real* t) {
    const Real a = _mm256_unpacklo_ps(t[0], t[1]), b = _mm256_unpackhi_ps(t[0], t[1]);
    const Real c = _mm256_unpacklo_ps(t[2], t[3]), d = _mm256_unpackhi_ps(t[2], t[3]);
    t[0] = (Real)_mm256_unpacklo_pd((__m256d)a, (__m256d)c);
    t[1] = (Real)_mm256_unpackhi_pd((__m256d)a, (__m256d)c);
    t[2] = (Real)_mm256_unpacklo_pd((__m256d)b, (__m256d)d);
    t[3] = (Real)_mm256_unpackhi_pd((__m256d)b, (__m256d)d);
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
    for (int k = 0; k < 4; ++k)
        t[k] = load_pair(p + stride * std::ptrdiff_t(i[k]), p + stride * std::ptrdiff_t(i[k + 4]));
    transpose(t);
}
PLUMB_INLINE void load_texels(const Half* p, int stride, Int i, Real* t) {
    __m128 rows[4];
    for (int k = 0; k < 4; ++k) {
        const __m128i lower = _mm_loadl_epi64((const __m128i*)(p + stride * std::ptrdiff_t(i[k])));
        const __m128i upper = _mm_loadl_epi64((const __m128i*)(p + stride * std::ptrdiff_t(i[k + 4])));
        rows[k] = (__m128)_mm_unpacklo_epi64(lower, upper);
    }
    // rows[k]: pairs 0 and 1 of lane k, pairs 0 and 1 of lane k + 4.
    const __m128 a = _mm_unpacklo_ps(rows[0], rows[1]), b = _mm_unpackhi_ps(rows[0], rows[1]);
    const __m128 c = _mm_unpacklo_ps(rows[2], rows[3]), d = _mm_unpackhi_ps(rows[2], rows[3]);
    const __m256 first = _mm256_set_m128(_mm_movelh_ps(b, d), _mm_movelh_ps(a, c));
    const __m256 second = _mm256_set_m128(_mm_movehl_ps(d, b), _mm_movehl_ps(c, a));
    widen_pairs(first, t, t + 1);
    widen_pairs(second, t + 2, t + 3);
}
PLUMB_INLINE void load_records(const float* p, Int i, Real* t) {
    load_texels(p, record_stride, i, t);
    load_texels(p + 4, record_stride, i, t + 4);
    load_texels(p + 8, record_stride, i, t + 8);
}
PLUMB_INLINE void load_records(const Half* p, Int i, Real* t) {
    for (int part = 0; part < 2; ++part) {
        Real pairs[4];
        for (int k = 0; k < 4; ++k)
            pairs[k] = load_pair(p + 8 * part + record_stride * std::ptrdiff_t(i[k]),
                                 p + 8 * part + record_stride * std::ptrdiff_t(i[k + 4]));
        transpose(pairs);
        for (int c = 0; c < (part == 0 ? 4 : 2); ++c)
            widen_pairs(pairs[c], t + 8 * part + 2 * c, t + 8 * part + 2 * c + 1);
    }
}

}  // namespace plumb::PLUMB_ISA::native
