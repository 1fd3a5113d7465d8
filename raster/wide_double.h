// Doubles: as many lanes of double as Real (core/wide.h) has of float, so that lane k of one is lane k of the other.
// Edge functions and depths need them: a float does not hold an exact edge function.
//
// Only kernel files include this header. Where Real is float, Doubles is double.
#pragma once

#include "core/wide.h"

namespace plumb::PLUMB_ISA {

#ifdef PLUMB_NO_WIDE

using Doubles = double;
PLUMB_INLINE double widen(float a) { return a; }
PLUMB_INLINE double widen(std::int32_t a) { return a; }
PLUMB_INLINE float narrow(double a) { return float(a); }
PLUMB_INLINE std::int32_t round_to_index(double a) { return number<double>::round_to_index(a); }
PLUMB_INLINE bool any_negative(double a, double b, double c) { return (a < 0) | (b < 0) | (c < 0); }
PLUMB_INLINE bool any_negative(std::int32_t a, std::int32_t b, std::int32_t c) { return (a | b | c) < 0; }
PLUMB_INLINE unsigned lane_bits(bool m) { return m; }
template <class T>
PLUMB_INLINE T load_lanes(const T* p) {
    return *p;
}
template <class T>
PLUMB_INLINE void store_lanes(T* p, T a) {
    *p = a;
}
PLUMB_INLINE void store_pairs(float* p, float a, float b) { p[0] = a, p[1] = b; }
PLUMB_INLINE void store_quads(float* p, float a, float b, float c, float d) { p[0] = a, p[1] = b, p[2] = c, p[3] = d; }

#else

namespace native {

#if defined(__AVX512F__)
using Double = __m512d;
PLUMB_INLINE Double splat_double(double x) { return _mm512_set1_pd(x); }
PLUMB_INLINE Double lower_double(Real a) { return _mm512_cvtps_pd(_mm512_castps512_ps256(a)); }
PLUMB_INLINE Double upper_double(Real a) { return _mm512_cvtps_pd(_mm512_extractf32x8_ps(a, 1)); }
PLUMB_INLINE Double lower_double(Int a) { return _mm512_cvtepi32_pd(_mm512_castsi512_si256((__m512i)a)); }
PLUMB_INLINE Double upper_double(Int a) { return _mm512_cvtepi32_pd(_mm512_extracti32x8_epi32((__m512i)a, 1)); }
PLUMB_INLINE Real to_real(Double low, Double high) {
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(low)), _mm512_cvtpd_ps(high), 1);
}
PLUMB_INLINE Int to_int(Double low, Double high) {
    return (Int)_mm512_inserti32x8(_mm512_castsi256_si512(_mm512_cvtpd_epi32(low)), _mm512_cvtpd_epi32(high), 1);
}
PLUMB_INLINE Double bits_or(Double a, Double b) { return _mm512_or_pd(a, b); }
PLUMB_INLINE Mask signs(Double low, Double high) {
    return Mask(_mm512_movepi64_mask((__m512i)low) | _mm512_movepi64_mask((__m512i)high) << 8);
}
PLUMB_INLINE unsigned lane_bits(Mask m) { return m; }
PLUMB_INLINE Double select_lower(Mask m, Double a, Double b) { return _mm512_mask_blend_pd(__mmask8(m), b, a); }
PLUMB_INLINE Double select_upper(Mask m, Double a, Double b) { return _mm512_mask_blend_pd(__mmask8(m >> 8), b, a); }
PLUMB_INLINE Real load(const float* p) { return _mm512_loadu_ps(p); }
PLUMB_INLINE Int load(const std::int32_t* p) { return (Int)_mm512_loadu_si512(p); }
PLUMB_INLINE Double load(const double* p) { return _mm512_loadu_pd(p); }
PLUMB_INLINE void store(float* p, Real a) { _mm512_storeu_ps(p, a); }
PLUMB_INLINE void store(std::int32_t* p, Int a) { _mm512_storeu_si512(p, (__m512i)a); }
PLUMB_INLINE void store(double* p, Double a) { _mm512_storeu_pd(p, a); }
PLUMB_INLINE void store_pairs(float* p, Real a, Real b) {
    const Real low = _mm512_unpacklo_ps(a, b), high = _mm512_unpackhi_ps(a, b);
    const __m512i first{0, 1, 8, 9, 2, 3, 10, 11}, second{4, 5, 12, 13, 6, 7, 14, 15};
    store(p, (Real)_mm512_permutex2var_pd((__m512d)low, first, (__m512d)high));
    store(p + 16, (Real)_mm512_permutex2var_pd((__m512d)low, second, (__m512d)high));
}
PLUMB_INLINE void store_quads(float* p, const Real q[4]) {
    const Real a = _mm512_shuffle_f32x4(q[0], q[1], 0x44), b = _mm512_shuffle_f32x4(q[2], q[3], 0x44),
               c = _mm512_shuffle_f32x4(q[0], q[1], 0xee), d = _mm512_shuffle_f32x4(q[2], q[3], 0xee);
    store(p, _mm512_shuffle_f32x4(a, b, 0x88)), store(p + 16, _mm512_shuffle_f32x4(a, b, 0xdd));
    store(p + 32, _mm512_shuffle_f32x4(c, d, 0x88)), store(p + 48, _mm512_shuffle_f32x4(c, d, 0xdd));
}
PLUMB_INLINE Real low_words(Real a, Real b) { return _mm512_unpacklo_ps(a, b); }
PLUMB_INLINE Real high_words(Real a, Real b) { return _mm512_unpackhi_ps(a, b); }
PLUMB_INLINE Real low_pairs(Real a, Real b) { return (Real)_mm512_unpacklo_pd((__m512d)a, (__m512d)b); }
PLUMB_INLINE Real high_pairs(Real a, Real b) { return (Real)_mm512_unpackhi_pd((__m512d)a, (__m512d)b); }
#elif defined(__AVX2__)
using Double = __m256d;
PLUMB_INLINE Double splat_double(double x) { return _mm256_set1_pd(x); }
PLUMB_INLINE Double lower_double(Real a) { return _mm256_cvtps_pd(_mm256_castps256_ps128(a)); }
PLUMB_INLINE Double upper_double(Real a) { return _mm256_cvtps_pd(_mm256_extractf128_ps(a, 1)); }
PLUMB_INLINE Double lower_double(Int a) { return _mm256_cvtepi32_pd(_mm256_castsi256_si128((__m256i)a)); }
PLUMB_INLINE Double upper_double(Int a) { return _mm256_cvtepi32_pd(_mm256_extracti128_si256((__m256i)a, 1)); }
PLUMB_INLINE Real to_real(Double low, Double high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(low)), _mm256_cvtpd_ps(high), 1);
}
PLUMB_INLINE Int to_int(Double low, Double high) {
    return (Int)_mm256_inserti128_si256(_mm256_castsi128_si256(_mm256_cvtpd_epi32(low)), _mm256_cvtpd_epi32(high), 1);
}
PLUMB_INLINE Double bits_or(Double a, Double b) { return _mm256_or_pd(a, b); }
PLUMB_INLINE Mask signs(Double low, Double high) {
    // The upper words of all doubles, then their quarters in order.
    const __m256 words = _mm256_shuffle_ps((__m256)low, (__m256)high, 0xdd);
    return (Int)_mm256_permute4x64_epi64((__m256i)words, 0xd8) >> 31;
}
PLUMB_INLINE unsigned lane_bits(Mask m) { return unsigned(_mm256_movemask_ps((__m256)m)); }
PLUMB_INLINE Double select_lower(Mask m, Double a, Double b) {
    return _mm256_blendv_pd(b, a, (__m256d)_mm256_cvtepi32_epi64(_mm256_castsi256_si128((__m256i)m)));
}
PLUMB_INLINE Double select_upper(Mask m, Double a, Double b) {
    return _mm256_blendv_pd(b, a, (__m256d)_mm256_cvtepi32_epi64(_mm256_extracti128_si256((__m256i)m, 1)));
}
PLUMB_INLINE Real load(const float* p) { return _mm256_loadu_ps(p); }
PLUMB_INLINE Int load(const std::int32_t* p) { return (Int)_mm256_loadu_si256((const __m256i*)p); }
PLUMB_INLINE Double load(const double* p) { return _mm256_loadu_pd(p); }
PLUMB_INLINE void store(float* p, Real a) { _mm256_storeu_ps(p, a); }
PLUMB_INLINE void store(std::int32_t* p, Int a) { _mm256_storeu_si256((__m256i*)p, (__m256i)a); }
PLUMB_INLINE void store(double* p, Double a) { _mm256_storeu_pd(p, a); }
PLUMB_INLINE void store_pairs(float* p, Real a, Real b) {
    const Real low = _mm256_unpacklo_ps(a, b), high = _mm256_unpackhi_ps(a, b);
    store(p, _mm256_permute2f128_ps(low, high, 0x20));
    store(p + 8, _mm256_permute2f128_ps(low, high, 0x31));
}
PLUMB_INLINE void store_quads(float* p, const Real q[4]) {
    store(p, _mm256_permute2f128_ps(q[0], q[1], 0x20)), store(p + 8, _mm256_permute2f128_ps(q[2], q[3], 0x20));
    store(p + 16, _mm256_permute2f128_ps(q[0], q[1], 0x31)), store(p + 24, _mm256_permute2f128_ps(q[2], q[3], 0x31));
}
PLUMB_INLINE Real low_words(Real a, Real b) { return _mm256_unpacklo_ps(a, b); }
PLUMB_INLINE Real high_words(Real a, Real b) { return _mm256_unpackhi_ps(a, b); }
PLUMB_INLINE Real low_pairs(Real a, Real b) { return (Real)_mm256_unpacklo_pd((__m256d)a, (__m256d)b); }
PLUMB_INLINE Real high_pairs(Real a, Real b) { return (Real)_mm256_unpackhi_pd((__m256d)a, (__m256d)b); }
#else
using Double = __m128d;
PLUMB_INLINE Double splat_double(double x) { return _mm_set1_pd(x); }
PLUMB_INLINE Double lower_double(Real a) { return _mm_cvtps_pd(a); }
PLUMB_INLINE Double upper_double(Real a) { return _mm_cvtps_pd(_mm_movehl_ps(a, a)); }
PLUMB_INLINE Double lower_double(Int a) { return _mm_cvtepi32_pd((__m128i)a); }
PLUMB_INLINE Double upper_double(Int a) { return _mm_cvtepi32_pd(_mm_shuffle_epi32((__m128i)a, 0xee)); }
PLUMB_INLINE Real to_real(Double low, Double high) { return _mm_movelh_ps(_mm_cvtpd_ps(low), _mm_cvtpd_ps(high)); }
PLUMB_INLINE Int to_int(Double low, Double high) {
    return (Int)_mm_unpacklo_epi64(_mm_cvtpd_epi32(low), _mm_cvtpd_epi32(high));
}
PLUMB_INLINE Double bits_or(Double a, Double b) { return _mm_or_pd(a, b); }
PLUMB_INLINE Mask signs(Double low, Double high) { return (Int)_mm_shuffle_ps((__m128)low, (__m128)high, 0xdd) >> 31; }
PLUMB_INLINE unsigned lane_bits(Mask m) { return unsigned(_mm_movemask_ps((__m128)m)); }
PLUMB_INLINE Double select_lower(Mask m, Double a, Double b) {
    return _mm_blendv_pd(b, a, (__m128d)_mm_unpacklo_epi32((__m128i)m, (__m128i)m));
}
PLUMB_INLINE Double select_upper(Mask m, Double a, Double b) {
    return _mm_blendv_pd(b, a, (__m128d)_mm_unpackhi_epi32((__m128i)m, (__m128i)m));
}
PLUMB_INLINE Real load(const float* p) { return _mm_loadu_ps(p); }
PLUMB_INLINE Int load(const std::int32_t* p) { return (Int)_mm_loadu_si128((const __m128i*)p); }
PLUMB_INLINE Double load(const double* p) { return _mm_loadu_pd(p); }
PLUMB_INLINE void store(float* p, Real a) { _mm_storeu_ps(p, a); }
PLUMB_INLINE void store(std::int32_t* p, Int a) { _mm_storeu_si128((__m128i*)p, (__m128i)a); }
PLUMB_INLINE void store(double* p, Double a) { _mm_storeu_pd(p, a); }
PLUMB_INLINE void store_pairs(float* p, Real a, Real b) {
    store(p, _mm_unpacklo_ps(a, b));
    store(p + 4, _mm_unpackhi_ps(a, b));
}
PLUMB_INLINE void store_quads(float* p, const Real q[4]) {
    for (int k = 0; k < 4; ++k) store(p + 4 * k, q[k]);
}
PLUMB_INLINE Real low_words(Real a, Real b) { return _mm_unpacklo_ps(a, b); }
PLUMB_INLINE Real high_words(Real a, Real b) { return _mm_unpackhi_ps(a, b); }
PLUMB_INLINE Real low_pairs(Real a, Real b) { return (Real)_mm_unpacklo_pd((__m128d)a, (__m128d)b); }
PLUMB_INLINE Real high_pairs(Real a, Real b) { return (Real)_mm_unpackhi_pd((__m128d)a, (__m128d)b); }
#endif

// Words become quads within 128 bits, which are then put in order.
PLUMB_INLINE void store_quads(float* p, Real a, Real b, Real c, Real d) {
    const Real ab0 = low_words(a, b), ab2 = high_words(a, b), cd0 = low_words(c, d), cd2 = high_words(c, d);
    const Real quads[4] = {low_pairs(ab0, cd0), high_pairs(ab0, cd0), low_pairs(ab2, cd2), high_pairs(ab2, cd2)};
    store_quads(p, quads);
}

}  // namespace native

struct Doubles {
    native::Double low, high;
    Doubles() = default;
    PLUMB_INLINE Doubles(native::Double l, native::Double h) : low(l), high(h) {}
    PLUMB_INLINE Doubles(double x) : low(native::splat_double(x)), high(low) {}

    friend PLUMB_INLINE Doubles operator+(Doubles a, Doubles b) { return {a.low + b.low, a.high + b.high}; }
    friend PLUMB_INLINE Doubles operator-(Doubles a, Doubles b) { return {a.low - b.low, a.high - b.high}; }
    friend PLUMB_INLINE Doubles operator*(Doubles a, Doubles b) { return {a.low * b.low, a.high * b.high}; }
    friend PLUMB_INLINE Doubles operator/(Doubles a, Doubles b) { return {a.low / b.low, a.high / b.high}; }
};

PLUMB_INLINE Doubles widen(Wide a) { return {native::lower_double(a.v), native::upper_double(a.v)}; }
PLUMB_INLINE Doubles widen(WideIndex a) { return {native::lower_double(a.v), native::upper_double(a.v)}; }
PLUMB_INLINE Wide narrow(Doubles a) { return native::to_real(a.low, a.high); }
PLUMB_INLINE WideIndex round_to_index(Doubles a) { return native::to_int(a.low, a.high); }  // to nearest even

// Where one of three is negative. Of doubles the sign bits decide: differences of whole numbers are never -0.
PLUMB_INLINE WideMask any_negative(Doubles a, Doubles b, Doubles c) {
    return {native::signs(native::bits_or(native::bits_or(a.low, b.low), c.low),
                          native::bits_or(native::bits_or(a.high, b.high), c.high))};
}
PLUMB_INLINE WideMask any_negative(WideIndex a, WideIndex b, WideIndex c) { return (a | b | c) < WideIndex(0); }

PLUMB_INLINE Doubles select(WideMask m, Doubles a, Doubles b) {
    return {native::select_lower(m.m, a.low, b.low), native::select_upper(m.m, a.high, b.high)};
}

// Bit k is set where lane k is.
PLUMB_INLINE unsigned lane_bits(WideMask m) { return native::lane_bits(m.m); }

// Consecutive values, at any address. (Copies through memcpy() go by way of the stack, in halves: the load that follows
// waits for every store before it.)
PLUMB_INLINE Wide load_lanes(const float* p) { return native::load(p); }
PLUMB_INLINE WideIndex load_lanes(const std::int32_t* p) { return native::load(p); }
PLUMB_INLINE Doubles load_lanes(const double* p) {
    return {native::load(p), native::load(p + number<Wide>::width / 2)};
}
PLUMB_INLINE void store_lanes(float* p, Wide a) { native::store(p, a.v); }
PLUMB_INLINE void store_lanes(std::int32_t* p, WideIndex a) { native::store(p, a.v); }
PLUMB_INLINE void store_lanes(double* p, Doubles a) {
    native::store(p, a.low);
    native::store(p + number<Wide>::width / 2, a.high);
}

// Stores a[0], b[0], a[1], b[1], ...
PLUMB_INLINE void store_pairs(float* p, Wide a, Wide b) { native::store_pairs(p, a.v, b.v); }

// Stores a[0], b[0], c[0], d[0], a[1], ...
PLUMB_INLINE void store_quads(float* p, Wide a, Wide b, Wide c, Wide d) {
    native::store_quads(p, a.v, b.v, c.v, d.v);
}

#endif

PLUMB_INLINE Doubles widen(Doubles a) { return a; }

}  // namespace plumb::PLUMB_ISA
