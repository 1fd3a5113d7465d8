// SSE4.2: four lanes.
#pragma once

#include <immintrin.h>

#include "core/number.h"

namespace plumb::PLUMB_ISA::native {

inline constexpr int width = 4;
using Real = __m128;
typedef std::int32_t Int __attribute__((vector_size(16)));
typedef std::uint32_t UInt __attribute__((vector_size(16)));
using Mask = Int;  // all ones or all zeros a lane

PLUMB_INLINE Mask mask_and(Mask a, Mask b) { return a & b; }
PLUMB_INLINE Mask mask_or(Mask a, Mask b) { return a | b; }
PLUMB_INLINE Mask mask_not(Mask a) { return ~a; }
PLUMB_INLINE bool any(Mask a) { return _mm_movemask_ps((__m128)a) != 0; }

PLUMB_INLINE Real splat(float x) { return _mm_set1_ps(x); }
PLUMB_INLINE Int iota() { return Int{0, 1, 2, 3}; }
PLUMB_INLINE Real negate(Real a) { return _mm_xor_ps(a, _mm_set1_ps(-0.0f)); }
PLUMB_INLINE Real abs(Real a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
PLUMB_INLINE Real sqrt(Real a) { return _mm_sqrt_ps(a); }
PLUMB_INLINE Real floor(Real a) { return _mm_floor_ps(a); }
PLUMB_INLINE Real min(Real a, Real b) { return _mm_min_ps(a, b); }
PLUMB_INLINE Real max(Real a, Real b) { return _mm_max_ps(a, b); }
PLUMB_INLINE Int min(Int a, Int b) { return (Int)_mm_min_epi32((__m128i)a, (__m128i)b); }
PLUMB_INLINE Int max(Int a, Int b) { return (Int)_mm_max_epi32((__m128i)a, (__m128i)b); }
PLUMB_INLINE Mask less(Real a, Real b) { return (Mask)_mm_cmplt_ps(a, b); }
PLUMB_INLINE Mask less_equal(Real a, Real b) { return (Mask)_mm_cmple_ps(a, b); }
PLUMB_INLINE Mask equal(Real a, Real b) { return (Mask)_mm_cmpeq_ps(a, b); }
PLUMB_INLINE Mask less(Int a, Int b) { return a < b; }
PLUMB_INLINE Mask less_unsigned(Int a, Int b) { return (Mask)((UInt)a < (UInt)b); }
PLUMB_INLINE Mask equal(Int a, Int b) { return a == b; }
PLUMB_INLINE Real select(Mask m, Real a, Real b) { return _mm_blendv_ps(b, a, (__m128)m); }
PLUMB_INLINE Int select(Mask m, Int a, Int b) { return (m & a) | (~m & b); }
PLUMB_INLINE Int round_to_int(Real a) { return (Int)_mm_cvtps_epi32(a); }
PLUMB_INLINE Int truncate_to_int(Real a) { return (Int)_mm_cvttps_epi32(a); }
PLUMB_INLINE Real from_int(Int a) { return _mm_cvtepi32_ps((__m128i)a); }

PLUMB_INLINE Real gather(const float* p, Int i) { return _mm_setr_ps(p[i[0]], p[i[1]], p[i[2]], p[i[3]]); }
PLUMB_INLINE Int gather(const std::int32_t* p, Int i) { return Int{p[i[0]], p[i[1]], p[i[2]], p[i[3]]}; }

PLUMB_INLINE Real load4(const float* p) { return _mm_load_ps(p); }
// Four halves at once, as half_to_float: SSE4.2 has no conversion of its own.
PLUMB_INLINE Real load4(const Half* p) {
    const __m128i h = _mm_cvtepu16_epi32(_mm_loadl_epi64((const __m128i*)p));
    const __m128i magnitude = _mm_and_si128(h, _mm_set1_epi32(0x7fff));
    const __m128i sign = _mm_slli_epi32(_mm_and_si128(h, _mm_set1_epi32(0x8000)), 16);
    const __m128 denormal = _mm_mul_ps(_mm_cvtepi32_ps(magnitude), _mm_set1_ps(0x1p-24f));
    const __m128i normal = _mm_add_epi32(_mm_slli_epi32(magnitude, 13), _mm_set1_epi32(112 << 23));
    const __m128i special = _mm_cmpgt_epi32(magnitude, _mm_set1_epi32(0x7bff));
    const __m128i exponent = _mm_and_si128(special, _mm_set1_epi32(0x7f800000));
    const __m128 is_denormal = (__m128)_mm_cmplt_epi32(magnitude, _mm_set1_epi32(0x0400));
    const __m128 value = _mm_blendv_ps((__m128)_mm_or_si128(normal, exponent), denormal, is_denormal);
    return _mm_or_ps(value, (__m128)sign);
}

// Loads the texel at p + stride i of every lane whole, and transposes: t[c] is component c of all lanes.
template <class Component>
PLUMB_INLINE void load_texels(const Component* p, int stride, Int i, Real* t) {
    alignas(16) std::int32_t lane[4];
    std::memcpy(lane, &i, 16);
    t[0] = load4(p + stride * std::ptrdiff_t(lane[0]));
    t[1] = load4(p + stride * std::ptrdiff_t(lane[1]));
    t[2] = load4(p + stride * std::ptrdiff_t(lane[2]));
    t[3] = load4(p + stride * std::ptrdiff_t(lane[3]));
    _MM_TRANSPOSE4_PS(t[0], t[1], t[2], t[3]);
}
// The other way: t[c] is component c of all lanes; 16 bytes a lane.
PLUMB_INLINE void store_texels(float* p, Int i, const Real* t) {
    alignas(16) std::int32_t lane[4];
    std::memcpy(lane, &i, 16);
    Real r[4] = {t[0], t[1], t[2], t[3]};
    _MM_TRANSPOSE4_PS(r[0], r[1], r[2], r[3]);
    for (int k = 0; k < 4; ++k) _mm_storeu_ps(p + 4 * std::ptrdiff_t(lane[k]), r[k]);
}
// Where each lane's record lies, in bytes from the first.
struct Places {
    alignas(16) std::int64_t byte[4];
    Places() = default;
    PLUMB_INLINE Places(Int i, std::int64_t bytes) {
        typedef std::int64_t Long __attribute__((vector_size(16)));
        const Long lower = (Long)_mm_cvtepi32_epi64((__m128i)i);
        const Long upper = (Long)_mm_cvtepi32_epi64(_mm_unpackhi_epi64((__m128i)i, (__m128i)i));
        _mm_store_si128((__m128i*)byte, (__m128i)(lower * bytes));
        _mm_store_si128((__m128i*)byte + 1, (__m128i)(upper * bytes));
        asm("" : "+m"(byte));
    }
};
PLUMB_INLINE const void* at_place(const void* p, const Places& places, int k) { return (const char*)p + places.byte[k]; }

PLUMB_INLINE void load_columns(const float* p, const Places& places, Real* t) {
    t[0] = load4((const float*)at_place(p, places, 0)), t[1] = load4((const float*)at_place(p, places, 1));
    t[2] = load4((const float*)at_place(p, places, 2)), t[3] = load4((const float*)at_place(p, places, 3));
    _MM_TRANSPOSE4_PS(t[0], t[1], t[2], t[3]);
}
PLUMB_INLINE void load_records(const float* p, const Places& places, Real* t) {
    load_columns(p, places, t), load_columns(p + 4, places, t + 4), load_columns(p + 8, places, t + 8);
}
PLUMB_INLINE __m128i all_words(int x) { return _mm_set1_epi16(short(x)); }
// Eight halves, in words as far as that goes: the upper and the lower word of each float. A denormal half takes the exponent
// of 2^-14, which is then subtracted: (2^-14 + m 2^-24) - 2^-14 is exact.
PLUMB_INLINE void widen_eight(__m128i h, Real* first, Real* second) {
    const __m128i zero = _mm_setzero_si128(), magnitude = _mm_and_si128(h, all_words(0x7fff));
    const __m128i sign = _mm_and_si128(h, all_words(0x8000));
    const __m128i special = _mm_cmpgt_epi16(magnitude, all_words(0x7bff));
    const __m128i denormal = _mm_cmplt_epi16(magnitude, all_words(0x0400));
    const __m128i normal = _mm_add_epi16(_mm_srli_epi16(magnitude, 3), all_words(112 << 7));
    const __m128i upper = _mm_or_si128(_mm_add_epi16(normal, _mm_and_si128(denormal, all_words(1 << 7))),
                                       _mm_and_si128(special, all_words(0x7f80)));
    const __m128i lower = _mm_slli_epi16(magnitude, 13), excess = _mm_and_si128(denormal, all_words(113 << 7));
    *first = _mm_sub_ps((Real)_mm_unpacklo_epi16(lower, upper), (Real)_mm_unpacklo_epi16(zero, excess));
    *second = _mm_sub_ps((Real)_mm_unpackhi_epi16(lower, upper), (Real)_mm_unpackhi_epi16(zero, excess));
    *first = _mm_or_ps(*first, (Real)_mm_unpacklo_epi16(zero, sign));
    *second = _mm_or_ps(*second, (Real)_mm_unpackhi_epi16(zero, sign));
}
// 4 x 4 words: x and y of four lanes, z and w of them.
PLUMB_INLINE void widen_columns(__m128i lanes01, __m128i lanes23, Real* t) {
    widen_eight(_mm_unpacklo_epi32(lanes01, lanes23), t, t + 1);
    widen_eight(_mm_unpackhi_epi32(lanes01, lanes23), t + 2, t + 3);
}
// Words of two lanes in turns: of components a and b the lower half, the upper half, and of c.
PLUMB_INLINE void pair_lanes(const Half* p, const Places& places, int k, __m128i* words) {
    const __m128i* even = (const __m128i*)at_place(p, places, k);
    const __m128i* odd = (const __m128i*)at_place(p, places, k + 1);
    const __m128i r0 = _mm_loadu_si128(even), r1 = _mm_loadu_si128(odd);
    words[0] = _mm_unpacklo_epi16(r0, r1), words[1] = _mm_unpackhi_epi16(r0, r1);
    words[2] = _mm_unpacklo_epi16(_mm_loadl_epi64(even + 1), _mm_loadl_epi64(odd + 1));
}
// Transposed first, since of twelve components nine are asked for.
PLUMB_INLINE void load_records(const Half* p, const Places& places, Real* t) {
    __m128i first[3], second[3];
    pair_lanes(p, places, 0, first), pair_lanes(p, places, 2, second);
    widen_columns(first[0], second[0], t);
    widen_columns(first[1], second[1], t + 4);
    widen_columns(first[2], second[2], t + 8);
}

}  // namespace plumb::PLUMB_ISA::native
