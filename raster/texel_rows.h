// Rows of packets in memory: consecutive pixels are read and written whole, without a gather or a scatter, and halves
// are rounded by the processor's own conversions. For kernel files, as core/wide.h.
#pragma once

#include <cstring>

#include "core/wide.h"

namespace plumb::PLUMB_ISA {

// Consecutive numbers, from p on.
template <class F>
PLUMB_INLINE index_t<F> load_row(const std::int32_t* p) {
    index_t<F> i;
    std::memcpy(&i, p, sizeof i);
    return i;
}
template <class F>
PLUMB_INLINE F load_row(const float* p) {
    F x;
    std::memcpy(&x, p, sizeof x);
    return x;
}

// Consecutive pairs: the first of each, the second of each.
template <class F>
PLUMB_INLINE vec2<F> load_pairs(const float* p) {
#if defined(__AVX512F__)
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512 a = _mm512_loadu_ps(p), b = _mm512_loadu_ps(p + 16);
    return {F(_mm512_permutex2var_ps(a, even, b)),
            F(_mm512_permutex2var_ps(a, _mm512_or_si512(even, _mm512_set1_epi32(1)), b))};
#elif defined(__AVX2__)
    const __m256 a = _mm256_loadu_ps(p), b = _mm256_loadu_ps(p + 8);
    auto in_order = [](__m256 x) { return (__m256)_mm256_permute4x64_epi64((__m256i)x, 0xd8); };
    return {F(in_order(_mm256_shuffle_ps(a, b, 0x88))), F(in_order(_mm256_shuffle_ps(a, b, 0xdd)))};
#elif defined(__SSE4_2__)
    const __m128 a = _mm_loadu_ps(p), b = _mm_loadu_ps(p + 4);
    return {F(_mm_shuffle_ps(a, b, 0x88)), F(_mm_shuffle_ps(a, b, 0xdd))};
#else
    return {F(p[0]), F(p[1])};
#endif
}

// Writes the first `count` of a packet's texels to consecutive texels from p on. Every NaN is stored as 7fc00000.
// past_caches: whole packets that lie on multiples of a register go to memory without reading it first; who
// writes so ends with _mm_sfence().
template <class F>
PLUMB_INLINE void store_row4(float* p, const vec4<F>& value, int count, bool past_caches = false) {
    auto canonical = [](F x) { return select(x == x, x, F(__builtin_nanf(""))); };
    const vec4<F> v{canonical(value.x), canonical(value.y), canonical(value.z), canonical(value.w)};
    constexpr int width = number<F>::width;
    alignas(64) float partial[4 * width];
    float* out = count < width ? partial : p;
    [[maybe_unused]] const bool streamed =
        past_caches && count == width && reinterpret_cast<std::uintptr_t>(p) % (4 * width) == 0;
#if defined(__AVX512F__)
    // 4 x 4 within each quarter, as load_words() of native_avx512.h; then the quarters among the four.
    const __m512 a = _mm512_unpacklo_ps(v.x.v, v.y.v), b = _mm512_unpackhi_ps(v.x.v, v.y.v);
    const __m512 c = _mm512_unpacklo_ps(v.z.v, v.w.v), d = _mm512_unpackhi_ps(v.z.v, v.w.v);
    const __m512 t0 = (__m512)_mm512_unpacklo_pd((__m512d)a, (__m512d)c);
    const __m512 t1 = (__m512)_mm512_unpackhi_pd((__m512d)a, (__m512d)c);
    const __m512 t2 = (__m512)_mm512_unpacklo_pd((__m512d)b, (__m512d)d);
    const __m512 t3 = (__m512)_mm512_unpackhi_pd((__m512d)b, (__m512d)d);
    const __m512 even01 = _mm512_shuffle_f32x4(t0, t1, 0x88), odd01 = _mm512_shuffle_f32x4(t0, t1, 0xdd);
    const __m512 even23 = _mm512_shuffle_f32x4(t2, t3, 0x88), odd23 = _mm512_shuffle_f32x4(t2, t3, 0xdd);
    auto store = [&](int at, __m512 x) { streamed ? _mm512_stream_ps(out + at, x) : _mm512_storeu_ps(out + at, x); };
    store(0, _mm512_shuffle_f32x4(even01, even23, 0x88)), store(16, _mm512_shuffle_f32x4(odd01, odd23, 0x88));
    store(32, _mm512_shuffle_f32x4(even01, even23, 0xdd)), store(48, _mm512_shuffle_f32x4(odd01, odd23, 0xdd));
#elif defined(__AVX2__)
    const __m256 a = _mm256_unpacklo_ps(v.x.v, v.y.v), b = _mm256_unpackhi_ps(v.x.v, v.y.v);
    const __m256 c = _mm256_unpacklo_ps(v.z.v, v.w.v), d = _mm256_unpackhi_ps(v.z.v, v.w.v);
    const __m256 t0 = (__m256)_mm256_unpacklo_pd((__m256d)a, (__m256d)c);
    const __m256 t1 = (__m256)_mm256_unpackhi_pd((__m256d)a, (__m256d)c);
    const __m256 t2 = (__m256)_mm256_unpacklo_pd((__m256d)b, (__m256d)d);
    const __m256 t3 = (__m256)_mm256_unpackhi_pd((__m256d)b, (__m256d)d);
    auto store = [&](int at, __m256 x) { streamed ? _mm256_stream_ps(out + at, x) : _mm256_storeu_ps(out + at, x); };
    store(0, _mm256_permute2f128_ps(t0, t1, 0x20)), store(8, _mm256_permute2f128_ps(t2, t3, 0x20));
    store(16, _mm256_permute2f128_ps(t0, t1, 0x31)), store(24, _mm256_permute2f128_ps(t2, t3, 0x31));
#elif defined(__SSE4_2__)
    __m128 r0 = v.x.v, r1 = v.y.v, r2 = v.z.v, r3 = v.w.v;
    _MM_TRANSPOSE4_PS(r0, r1, r2, r3);
    auto store = [&](int at, __m128 x) { streamed ? _mm_stream_ps(out + at, x) : _mm_storeu_ps(out + at, x); };
    store(0, r0), store(4, r1), store(8, r2), store(12, r3);
#else
    out[0] = v.x, out[1] = v.y, out[2] = v.z, out[3] = v.w;
#endif
    if (count < width)
        for (int i = 0; i < 4 * count; ++i) p[i] = partial[i];
}

// half_rounded() of core/quantise_kernel.h; both keep a NaN a NaN, whose bits store_row4() settles.
#if defined(__AVX512F__)
PLUMB_INLINE Wide half_rounded(Wide x) {
    return _mm512_cvtph_ps(_mm512_cvtps_ph(x.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
#elif defined(__AVX2__)
PLUMB_INLINE Wide half_rounded(Wide x) { return _mm256_cvtph_ps(_mm256_cvtps_ph(x.v, _MM_FROUND_TO_NEAREST_INT)); }
#endif

}  // namespace plumb::PLUMB_ISA
