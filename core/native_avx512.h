// AVX-512 F, DQ, BW, VL: sixteen lanes.
#pragma once

#include <immintrin.h>

#include "core/number.h"

namespace plumb::PLUMB_ISA::native {

inline constexpr int width = 16;
using Real = __m512;
typedef std::int32_t Int __attribute__((vector_size(64)));
typedef std::uint32_t UInt __attribute__((vector_size(64)));
using Mask = __mmask16;  // a bit a lane

PLUMB_INLINE Mask mask_and(Mask a, Mask b) { return Mask(a & b); }
PLUMB_INLINE Mask mask_or(Mask a, Mask b) { return Mask(a | b); }
PLUMB_INLINE Mask mask_not(Mask a) { return Mask(~a); }
PLUMB_INLINE bool any(Mask a) { return a != 0; }

PLUMB_INLINE Real splat(float x) { return _mm512_set1_ps(x); }
PLUMB_INLINE Int iota() { return Int{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}; }
PLUMB_INLINE Real negate(Real a) { return _mm512_xor_ps(a, _mm512_set1_ps(-0.0f)); }
PLUMB_INLINE Real abs(Real a) { return _mm512_andnot_ps(_mm512_set1_ps(-0.0f), a); }
PLUMB_INLINE Real sqrt(Real a) { return _mm512_sqrt_ps(a); }
PLUMB_INLINE Real floor(Real a) { return _mm512_roundscale_ps(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC); }
PLUMB_INLINE Real min(Real a, Real b) { return _mm512_min_ps(a, b); }
PLUMB_INLINE Real max(Real a, Real b) { return _mm512_max_ps(a, b); }
PLUMB_INLINE Int min(Int a, Int b) { return (Int)_mm512_min_epi32((__m512i)a, (__m512i)b); }
PLUMB_INLINE Int max(Int a, Int b) { return (Int)_mm512_max_epi32((__m512i)a, (__m512i)b); }
PLUMB_INLINE Mask less(Real a, Real b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
PLUMB_INLINE Mask less_equal(Real a, Real b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
PLUMB_INLINE Mask equal(Real a, Real b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
PLUMB_INLINE Mask less(Int a, Int b) { return _mm512_cmplt_epi32_mask((__m512i)a, (__m512i)b); }
PLUMB_INLINE Mask less_unsigned(Int a, Int b) { return _mm512_cmplt_epu32_mask((__m512i)a, (__m512i)b); }
PLUMB_INLINE Mask equal(Int a, Int b) { return _mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b); }
PLUMB_INLINE Real select(Mask m, Real a, Real b) { return _mm512_mask_blend_ps(m, b, a); }
PLUMB_INLINE Int select(Mask m, Int a, Int b) { return (Int)_mm512_mask_blend_epi32(m, (__m512i)b, (__m512i)a); }
PLUMB_INLINE Int round_to_int(Real a) { return (Int)_mm512_cvtps_epi32(a); }
PLUMB_INLINE Int truncate_to_int(Real a) { return (Int)_mm512_cvttps_epi32(a); }
PLUMB_INLINE Real from_int(Int a) { return _mm512_cvtepi32_ps((__m512i)a); }

PLUMB_INLINE Real gather(const float* p, Int i) { return _mm512_i32gather_ps((__m512i)i, p, 4); }
PLUMB_INLINE Int gather(const std::int32_t* p, Int i) { return (Int)_mm512_i32gather_epi32((__m512i)i, p, 4); }

// Where each lane's texel lies, in bytes from the first. It goes through memory on purpose: a compiler that knows what
// is in it takes the lanes out of the vector one by one, on the port that the shuffles need.
struct Places {
    alignas(64) std::int64_t byte[16];
    Places() = default;
    PLUMB_INLINE Places(Int i, std::int64_t bytes) {
        typedef std::int64_t Long __attribute__((vector_size(64)));
        const Long lower = (Long)_mm512_cvtepi32_epi64(_mm512_castsi512_si256((__m512i)i));
        const Long upper = (Long)_mm512_cvtepi32_epi64(_mm512_extracti64x4_epi64((__m512i)i, 1));
        _mm512_store_si512(byte, (__m512i)(lower * bytes));
        _mm512_store_si512(byte + 8, (__m512i)(upper * bytes));
        asm("" : "+m"(byte));
    }
};
// 16 bytes of lanes k, k + 4, k + 8, k + 12, from byte `at` of each one's texel.
PLUMB_INLINE Real load_quad(const void* p, std::ptrdiff_t at, const Places& i, int k) {
    const char* base = static_cast<const char*>(p) + at;
    Real r = _mm512_castps128_ps512(_mm_loadu_ps((const float*)(base + i.byte[k])));
    r = _mm512_insertf32x4(r, _mm_loadu_ps((const float*)(base + i.byte[k + 4])), 1);
    r = _mm512_insertf32x4(r, _mm_loadu_ps((const float*)(base + i.byte[k + 8])), 2);
    return _mm512_insertf32x4(r, _mm_loadu_ps((const float*)(base + i.byte[k + 12])), 3);
}
// Four rows of four words within each quarter: t[c] holds word c of each row.
PLUMB_INLINE void transpose(Real r0, Real r1, Real r2, Real r3, Real* t) {
    const Real a = _mm512_unpacklo_ps(r0, r1), b = _mm512_unpackhi_ps(r0, r1);
    const Real c = _mm512_unpacklo_ps(r2, r3), d = _mm512_unpackhi_ps(r2, r3);
    t[0] = (Real)_mm512_unpacklo_pd((__m512d)a, (__m512d)c);
    t[1] = (Real)_mm512_unpackhi_pd((__m512d)a, (__m512d)c);
    t[2] = (Real)_mm512_unpacklo_pd((__m512d)b, (__m512d)d);
    t[3] = (Real)_mm512_unpackhi_pd((__m512d)b, (__m512d)d);
}
// Loads 16 bytes a lane and transposes: t[c] holds word c of lanes 0..15.
PLUMB_INLINE void load_words(const void* p, std::ptrdiff_t at, const Places& i, Real* t) {
    transpose(load_quad(p, at, i, 0), load_quad(p, at, i, 1), load_quad(p, at, i, 2), load_quad(p, at, i, 3), t);
}
// The other way: word c of all lanes is t[c]; 16 bytes a lane.
PLUMB_INLINE void store_quad(float* p, const Places& i, int k, Real r) {
    char* base = (char*)p;
    _mm_storeu_ps((float*)(base + i.byte[k]), _mm512_castps512_ps128(r));
    _mm_storeu_ps((float*)(base + i.byte[k + 4]), _mm512_extractf32x4_ps(r, 1));
    _mm_storeu_ps((float*)(base + i.byte[k + 8]), _mm512_extractf32x4_ps(r, 2));
    _mm_storeu_ps((float*)(base + i.byte[k + 12]), _mm512_extractf32x4_ps(r, 3));
}
PLUMB_INLINE void store_texels(float* p, Int i, const Real* t) {
    const Places places(i, 16);
    Real r[4];
    transpose(t[0], t[1], t[2], t[3], r);
    for (int k = 0; k < 4; ++k) store_quad(p, places, k, r[k]);
}
// Sixteen 32-bit lanes of two halves each: the lower halves as floats, the upper halves as floats. One permutation of
// words sorts both, where narrowing each would take two more.
PLUMB_INLINE void widen_pairs(Real pairs, Real* lower, Real* upper) {
    typedef std::int16_t Words __attribute__((vector_size(64)));
    const Words even_then_odd{0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30,
                              1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31};
    const __m512i sorted = _mm512_permutexvar_epi16((__m512i)even_then_odd, (__m512i)pairs);
    *lower = _mm512_cvtph_ps(_mm512_castsi512_si256(sorted));
    *upper = _mm512_cvtph_ps(_mm512_extracti64x4_epi64(sorted, 1));
}

// Loads the texel at p + stride i of every lane whole, and transposes: t[c] is component c of all lanes.
PLUMB_INLINE void load_texels(const float* p, int stride, Int i, Real* t) {
    load_words(p, 0, Places(i, 4 * stride), t);
}
// A texel of four halves is 8 bytes: two gathers fetch its two pairs.
PLUMB_INLINE void load_texels(const Half* p, int stride, Int i, Real* t) {
    const __m512i at = (__m512i)(i * (stride / 2));
    widen_pairs((Real)_mm512_i32gather_epi32(at, (const int*)p, 4), t, t + 1);
    widen_pairs((Real)_mm512_i32gather_epi32(at, (const int*)p + 1, 4), t + 2, t + 3);
}
PLUMB_INLINE void load_records(const float* p, const Places& places, Real* t) {
    load_words(p, 0, places, t);
    load_words(p, 16, places, t + 4);
    load_words(p, 32, places, t + 8);
}
// 32 bytes of lanes k and k + 4.
PLUMB_INLINE Real load_halves(const Half* p, const Places& i, int k) {
    const char* base = (const char*)p;
    const __m512d r = _mm512_castpd256_pd512(_mm256_loadu_pd((const double*)(base + i.byte[k])));
    return (Real)_mm512_insertf64x4(r, _mm256_loadu_pd((const double*)(base + i.byte[k + 4])), 1);
}
// Words 0 to 3 and 4 to 7 of four pairs of records: t[c] holds word c of lanes 0 to 3, word c + 4 of these, and so of 4 to 7.
PLUMB_INLINE void load_eight(const Half* p, const Places& i, int k, Real* t) {
    transpose(load_halves(p, i, k), load_halves(p, i, k + 1), load_halves(p, i, k + 2), load_halves(p, i, k + 3), t);
}
PLUMB_INLINE void load_records(const Half* p, const Places& places, Real* t) {
    Real a[4], b[4];
    load_eight(p, places, 0, a);
    load_eight(p, places, 8, b);
    widen_pairs(_mm512_shuffle_f32x4(a[0], b[0], 0x88), t, t + 1);
    widen_pairs(_mm512_shuffle_f32x4(a[1], b[1], 0x88), t + 2, t + 3);
    widen_pairs(_mm512_shuffle_f32x4(a[2], b[2], 0x88), t + 4, t + 5);
    widen_pairs(_mm512_shuffle_f32x4(a[3], b[3], 0x88), t + 6, t + 7);
    widen_pairs(_mm512_shuffle_f32x4(a[0], b[0], 0xdd), t + 8, t + 9);
    widen_pairs(_mm512_shuffle_f32x4(a[1], b[1], 0xdd), t + 10, t + 11);
}

}  // namespace plumb::PLUMB_ISA::native
