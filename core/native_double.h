// Double: as many doubles as the instruction set of this file has lanes. Only kernel files include it, as they do
// core/wide.h; min(a, b) is b < a ? b : a, and max(a, b) is a < b ? b : a, as everywhere.
#pragma once

#include "core/number.h"

#if !defined(PLUMB_ISA)
#error "core/native_double.h is for kernel files, which cmake/kernels.cmake compiles with PLUMB_ISA"
#endif

#include <immintrin.h>

namespace plumb::PLUMB_ISA {

#if defined(__AVX512F__)

struct DoubleMask {
    __mmask8 m;
    friend PLUMB_INLINE DoubleMask operator&(DoubleMask a, DoubleMask b) { return {__mmask8(a.m & b.m)}; }
    friend PLUMB_INLINE DoubleMask operator|(DoubleMask a, DoubleMask b) { return {__mmask8(a.m | b.m)}; }
    friend PLUMB_INLINE DoubleMask operator!(DoubleMask a) { return {__mmask8(~a.m)}; }
};
struct Double {
    using Native = __m512d;
    static constexpr int lanes = 8;
    Native v;
    Double() = default;
    PLUMB_INLINE Double(Native x) : v(x) {}
    PLUMB_INLINE Double(double x) : v(_mm512_set1_pd(x)) {}
};
PLUMB_INLINE Double load(const double* p) { return _mm512_load_pd(p); }
PLUMB_INLINE void save(double* p, Double a) { _mm512_store_pd(p, a.v); }
PLUMB_INLINE Double widen(const float* p) { return _mm512_cvtps_pd(_mm256_load_ps(p)); }
PLUMB_INLINE Double operator-(Double a) { return _mm512_xor_pd(a.v, _mm512_set1_pd(-0.0)); }
PLUMB_INLINE Double abs(Double a) { return _mm512_andnot_pd(_mm512_set1_pd(-0.0), a.v); }
PLUMB_INLINE Double sqrt(Double a) { return _mm512_sqrt_pd(a.v); }
PLUMB_INLINE Double min(Double a, Double b) { return _mm512_min_pd(b.v, a.v); }
PLUMB_INLINE Double max(Double a, Double b) { return _mm512_max_pd(b.v, a.v); }
PLUMB_INLINE DoubleMask operator<(Double a, Double b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ)}; }
PLUMB_INLINE DoubleMask operator<=(Double a, Double b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LE_OQ)}; }
PLUMB_INLINE DoubleMask operator==(Double a, Double b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_EQ_OQ)}; }
PLUMB_INLINE Double select(DoubleMask m, Double a, Double b) { return _mm512_mask_blend_pd(m.m, b.v, a.v); }
PLUMB_INLINE std::uint32_t bits(DoubleMask m) { return m.m; }
PLUMB_INLINE DoubleMask lanes_of(std::uint32_t bits) { return {__mmask8(bits)}; }
// 0, infinity or a power of two.
PLUMB_INLINE DoubleMask no_fraction(Double a) {
    return {_mm512_testn_epi64_mask((__m512i)a.v, _mm512_set1_epi64(0x000fffffffffffff))};
}

#elif defined(__AVX2__)

struct DoubleMask {
    __m256d m;
    friend PLUMB_INLINE DoubleMask operator&(DoubleMask a, DoubleMask b) { return {_mm256_and_pd(a.m, b.m)}; }
    friend PLUMB_INLINE DoubleMask operator|(DoubleMask a, DoubleMask b) { return {_mm256_or_pd(a.m, b.m)}; }
    friend PLUMB_INLINE DoubleMask operator!(DoubleMask a) {
        return {_mm256_xor_pd(a.m, (__m256d)_mm256_set1_epi64x(-1))};
    }
};
struct Double {
    using Native = __m256d;
    static constexpr int lanes = 4;
    Native v;
    Double() = default;
    PLUMB_INLINE Double(Native x) : v(x) {}
    PLUMB_INLINE Double(double x) : v(_mm256_set1_pd(x)) {}
};
PLUMB_INLINE Double load(const double* p) { return _mm256_load_pd(p); }
PLUMB_INLINE void save(double* p, Double a) { _mm256_store_pd(p, a.v); }
PLUMB_INLINE Double widen(const float* p) { return _mm256_cvtps_pd(_mm_load_ps(p)); }
PLUMB_INLINE Double operator-(Double a) { return _mm256_xor_pd(a.v, _mm256_set1_pd(-0.0)); }
PLUMB_INLINE Double abs(Double a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a.v); }
PLUMB_INLINE Double sqrt(Double a) { return _mm256_sqrt_pd(a.v); }
PLUMB_INLINE Double min(Double a, Double b) { return _mm256_min_pd(b.v, a.v); }
PLUMB_INLINE Double max(Double a, Double b) { return _mm256_max_pd(b.v, a.v); }
PLUMB_INLINE DoubleMask operator<(Double a, Double b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)}; }
PLUMB_INLINE DoubleMask operator<=(Double a, Double b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)}; }
PLUMB_INLINE DoubleMask operator==(Double a, Double b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_EQ_OQ)}; }
PLUMB_INLINE Double select(DoubleMask m, Double a, Double b) { return _mm256_blendv_pd(b.v, a.v, m.m); }
PLUMB_INLINE std::uint32_t bits(DoubleMask m) { return std::uint32_t(_mm256_movemask_pd(m.m)); }
PLUMB_INLINE DoubleMask lanes_of(std::uint32_t bits) {
    const __m256i lane = _mm256_set_epi64x(8, 4, 2, 1);
    return {(__m256d)_mm256_cmpeq_epi64(_mm256_and_si256(_mm256_set1_epi64x(bits), lane), lane)};
}
PLUMB_INLINE DoubleMask no_fraction(Double a) {
    const __m256i fraction = _mm256_and_si256((__m256i)a.v, _mm256_set1_epi64x(0x000fffffffffffff));
    return {(__m256d)_mm256_cmpeq_epi64(fraction, _mm256_setzero_si256())};
}

#elif defined(__SSE4_2__)

struct DoubleMask {
    __m128d m;
    friend PLUMB_INLINE DoubleMask operator&(DoubleMask a, DoubleMask b) { return {_mm_and_pd(a.m, b.m)}; }
    friend PLUMB_INLINE DoubleMask operator|(DoubleMask a, DoubleMask b) { return {_mm_or_pd(a.m, b.m)}; }
    friend PLUMB_INLINE DoubleMask operator!(DoubleMask a) { return {_mm_xor_pd(a.m, (__m128d)_mm_set1_epi64x(-1))}; }
};
struct Double {
    using Native = __m128d;
    static constexpr int lanes = 2;
    Native v;
    Double() = default;
    PLUMB_INLINE Double(Native x) : v(x) {}
    PLUMB_INLINE Double(double x) : v(_mm_set1_pd(x)) {}
};
PLUMB_INLINE Double load(const double* p) { return _mm_load_pd(p); }
PLUMB_INLINE void save(double* p, Double a) { _mm_store_pd(p, a.v); }
PLUMB_INLINE Double widen(const float* p) { return _mm_set_pd(p[1], p[0]); }
PLUMB_INLINE Double operator-(Double a) { return _mm_xor_pd(a.v, _mm_set1_pd(-0.0)); }
PLUMB_INLINE Double abs(Double a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a.v); }
PLUMB_INLINE Double sqrt(Double a) { return _mm_sqrt_pd(a.v); }
PLUMB_INLINE Double min(Double a, Double b) { return _mm_min_pd(b.v, a.v); }
PLUMB_INLINE Double max(Double a, Double b) { return _mm_max_pd(b.v, a.v); }
PLUMB_INLINE DoubleMask operator<(Double a, Double b) { return {_mm_cmplt_pd(a.v, b.v)}; }
PLUMB_INLINE DoubleMask operator<=(Double a, Double b) { return {_mm_cmple_pd(a.v, b.v)}; }
PLUMB_INLINE DoubleMask operator==(Double a, Double b) { return {_mm_cmpeq_pd(a.v, b.v)}; }
PLUMB_INLINE Double select(DoubleMask m, Double a, Double b) { return _mm_blendv_pd(b.v, a.v, m.m); }
PLUMB_INLINE std::uint32_t bits(DoubleMask m) { return std::uint32_t(_mm_movemask_pd(m.m)); }
PLUMB_INLINE DoubleMask lanes_of(std::uint32_t bits) {
    const __m128i lane = _mm_set_epi64x(2, 1);
    return {(__m128d)_mm_cmpeq_epi64(_mm_and_si128(_mm_set1_epi64x(bits), lane), lane)};
}
PLUMB_INLINE DoubleMask no_fraction(Double a) {
    const __m128i fraction = _mm_and_si128((__m128i)a.v, _mm_set1_epi64x(0x000fffffffffffff));
    return {(__m128d)_mm_cmpeq_epi64(fraction, _mm_setzero_si128())};
}

#else

struct DoubleMask {
    bool m;
    friend PLUMB_INLINE DoubleMask operator&(DoubleMask a, DoubleMask b) { return {a.m && b.m}; }
    friend PLUMB_INLINE DoubleMask operator|(DoubleMask a, DoubleMask b) { return {a.m || b.m}; }
    friend PLUMB_INLINE DoubleMask operator!(DoubleMask a) { return {!a.m}; }
};
struct Double {
    using Native = double;
    static constexpr int lanes = 1;
    Native v;
    Double() = default;
    PLUMB_INLINE Double(double x) : v(x) {}
};
PLUMB_INLINE Double load(const double* p) { return *p; }
PLUMB_INLINE void save(double* p, Double a) { *p = a.v; }
PLUMB_INLINE Double widen(const float* p) { return double(*p); }
PLUMB_INLINE Double operator-(Double a) { return -a.v; }
PLUMB_INLINE Double abs(Double a) { return plumb::abs(a.v); }
PLUMB_INLINE Double sqrt(Double a) { return plumb::sqrt(a.v); }
PLUMB_INLINE Double min(Double a, Double b) { return plumb::min(a.v, b.v); }
PLUMB_INLINE Double max(Double a, Double b) { return plumb::max(a.v, b.v); }
PLUMB_INLINE DoubleMask operator<(Double a, Double b) { return {a.v < b.v}; }
PLUMB_INLINE DoubleMask operator<=(Double a, Double b) { return {a.v <= b.v}; }
PLUMB_INLINE DoubleMask operator==(Double a, Double b) { return {a.v == b.v}; }
PLUMB_INLINE Double select(DoubleMask m, Double a, Double b) { return m.m ? a : b; }
PLUMB_INLINE std::uint32_t bits(DoubleMask m) { return m.m; }
PLUMB_INLINE DoubleMask lanes_of(std::uint32_t bits) { return {(bits & 1) != 0}; }
PLUMB_INLINE DoubleMask no_fraction(Double a) {
    std::uint64_t bits;
    std::memcpy(&bits, &a.v, 8);
    return {(bits << 12) == 0};
}

#endif

PLUMB_INLINE Double operator+(Double a, Double b) { return a.v + b.v; }
PLUMB_INLINE Double operator-(Double a, Double b) { return a.v - b.v; }
PLUMB_INLINE Double operator*(Double a, Double b) { return a.v * b.v; }
PLUMB_INLINE Double operator/(Double a, Double b) { return a.v / b.v; }
PLUMB_INLINE bool any(DoubleMask m) { return bits(m) != 0; }

}  // namespace plumb::PLUMB_ISA
