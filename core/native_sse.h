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
template <class Component>
PLUMB_INLINE void load_records(const Component* p, Int i, Real* t) {
    load_texels(p, record_stride, i, t);
    load_texels(p + 4, record_stride, i, t + 4);
    load_texels(p + 8, record_stride, i, t + 8);
}

}  // namespace plumb::PLUMB_ISA::native
