// Packets of texels in memory: rows of a block are written whole, without a scatter, and halves are rounded by the
// processor's own conversions. For kernel files, as core/wide.h.
#pragma once

#include "core/wide.h"

namespace plumb::PLUMB_ISA {

// Writes a packet's texels to rows of `columns` texels, from p on, `pitch` floats apart; only those before `count`
// columns and rows. Every NaN is stored as 7fc00000. past_caches: whole packets that lie on multiples of a register go
// to memory without reading it first; who writes so ends with _mm_sfence().
template <int columns, class F>
PLUMB_INLINE void store_texels(float* p, std::ptrdiff_t pitch, const vec4<F>& value, glm::ivec2 count,
                               bool past_caches = false) {
    auto canonical = [](F x) { return select(x == x, x, F(__builtin_nanf(""))); };
    const vec4<F> v{canonical(value.x), canonical(value.y), canonical(value.z), canonical(value.w)};
    constexpr int width = number<F>::width, rows = width / columns;
    alignas(64) float partial[4 * width];
    const bool whole = count.x >= columns && count.y >= rows;
    float* out = whole ? p : partial;
    const std::ptrdiff_t out_pitch = whole ? pitch : 4 * columns;
    // Where float `at` of the packet goes: each register lies within a row.
    [[maybe_unused]] auto place = [&](int at) { return out + at / (4 * columns) * out_pitch + at % (4 * columns); };
    [[maybe_unused]] const bool streamed =
        past_caches && whole && (reinterpret_cast<std::uintptr_t>(p) | std::uintptr_t(4 * pitch)) % (4 * width) == 0;
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
    auto store = [&](int at, __m512 x) { streamed ? _mm512_stream_ps(place(at), x) : _mm512_storeu_ps(place(at), x); };
    store(0, _mm512_shuffle_f32x4(even01, even23, 0x88)), store(16, _mm512_shuffle_f32x4(odd01, odd23, 0x88));
    store(32, _mm512_shuffle_f32x4(even01, even23, 0xdd)), store(48, _mm512_shuffle_f32x4(odd01, odd23, 0xdd));
#elif defined(__AVX2__)
    const __m256 a = _mm256_unpacklo_ps(v.x.v, v.y.v), b = _mm256_unpackhi_ps(v.x.v, v.y.v);
    const __m256 c = _mm256_unpacklo_ps(v.z.v, v.w.v), d = _mm256_unpackhi_ps(v.z.v, v.w.v);
    const __m256 t0 = (__m256)_mm256_unpacklo_pd((__m256d)a, (__m256d)c);
    const __m256 t1 = (__m256)_mm256_unpackhi_pd((__m256d)a, (__m256d)c);
    const __m256 t2 = (__m256)_mm256_unpacklo_pd((__m256d)b, (__m256d)d);
    const __m256 t3 = (__m256)_mm256_unpackhi_pd((__m256d)b, (__m256d)d);
    auto store = [&](int at, __m256 x) { streamed ? _mm256_stream_ps(place(at), x) : _mm256_storeu_ps(place(at), x); };
    store(0, _mm256_permute2f128_ps(t0, t1, 0x20)), store(8, _mm256_permute2f128_ps(t2, t3, 0x20));
    store(16, _mm256_permute2f128_ps(t0, t1, 0x31)), store(24, _mm256_permute2f128_ps(t2, t3, 0x31));
#elif defined(__SSE4_2__)
    __m128 r0 = v.x.v, r1 = v.y.v, r2 = v.z.v, r3 = v.w.v;
    _MM_TRANSPOSE4_PS(r0, r1, r2, r3);
    auto store = [&](int at, __m128 x) { streamed ? _mm_stream_ps(place(at), x) : _mm_storeu_ps(place(at), x); };
    store(0, r0), store(4, r1), store(8, r2), store(12, r3);
#else
    out[0] = v.x, out[1] = v.y, out[2] = v.z, out[3] = v.w;
#endif
    if (whole) return;
    for (int row = 0; row < (count.y < rows ? count.y : rows); ++row)
        for (int i = 0; i < 4 * (count.x < columns ? count.x : columns); ++i)
            p[row * pitch + i] = partial[4 * columns * row + i];
}

// half_rounded() of core/quantise_kernel.h; both keep a NaN a NaN, whose bits store_texels() settles.
#if defined(__AVX512F__)
PLUMB_INLINE Wide half_rounded(Wide x) {
    return _mm512_cvtph_ps(_mm512_cvtps_ph(x.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
#elif defined(__AVX2__)
PLUMB_INLINE Wide half_rounded(Wide x) { return _mm256_cvtph_ps(_mm256_cvtps_ph(x.v, _MM_FROUND_TO_NEAREST_INT)); }
#endif

}  // namespace plumb::PLUMB_ISA
