#include "core/shade_rows.h"
// After core/wide.h, so that the kernel sees its number.
#include "gi/radiosity/gather_kernel.h"

namespace plumb::radiosity {
namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

constexpr int registers = row_lanes / N::width;  // that hold sixteen sums of one colour

PLUMB_INLINE F load_halves(const Half* p) {
#if defined(__AVX512F__)
    return F(_mm512_cvtph_ps(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))));
#elif defined(__AVX2__)
    return F(_mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
#elif defined(__SSE4_2__)
    return F(PLUMB_ISA::native::load4(p));
#else
    return half_to_float(*p);
#endif
}

struct Sums {
    F r[registers], g[registers], b[registers];

    template <class Load, class Counts>
    PLUMB_INLINE void add(const float* red, const float* green, const float* blue, Load load, Counts counts) {
#pragma GCC unroll 16
        for (int k = 0; k < registers; ++k) {
            const int at = k * N::width;
            const F f = load(at);
            const mask_t<F> there = counts(at);
            r[k] = select(there, r[k] + f * N::load(red + at), r[k]);
            g[k] = select(there, g[k] + f * N::load(green + at), g[k]);
            b[k] = select(there, b[k] + f * N::load(blue + at), b[k]);
        }
    }
    static float total(const F (&sums)[registers]) {
        alignas(64) float lane[row_lanes];
        for (int k = 0; k < registers; ++k) N::save(lane + k * N::width, sums[k]);
        for (int half = row_lanes / 2; half > 0; half /= 2)
            for (int k = 0; k < half; ++k) lane[k] = lane[k] + lane[k + half];
        return lane[0];
    }
};

// Sixteen numbers of a run at a time; of the last ones, those that there are.
void gather_row(const GatherView& in, int i) {
    const std::int32_t* row = in.rows + 4 * std::ptrdiff_t(i);
    const std::ptrdiff_t stride = in.u.elements + row_lanes;
    Sums sums;
    for (int k = 0; k < registers; ++k) sums.r[k] = sums.g[k] = sums.b[k] = F(0.0f);
    const Half* weight = in.half_weights + row[2];
    for (int r = 0; r < row[1]; ++r) {
        const std::int32_t* run = in.runs + 2 * (std::ptrdiff_t(row[0]) + r);
        const float *red = in.planes + run[0], *green = red + stride, *blue = green + stride;
        int k = 0;
        for (; k + row_lanes <= run[1]; k += row_lanes)
            sums.add(red + k, green + k, blue + k, [&](int at) { return load_halves(weight + k + at); },
                     [](int) { return !(I(1) < I(0)); });
        if (k < run[1])
            sums.add(red + k, green + k, blue + k, [&](int at) { return load_halves(weight + k + at); },
                     [&](int at) { return N::iota(k + at) < I(run[1]); });
        weight += run[1];
    }
    const float scale = in.scale[i], *own = in.own + 4 * std::ptrdiff_t(i);
    const vec4<float> h{own[0] + scale * Sums::total(sums.r), own[1] + scale * Sums::total(sums.g), own[2] + scale * Sums::total(sums.b), 0};
    number<float>::store4(in.irradiance, i, h, true);
}

}  // namespace
}  // namespace plumb::radiosity

namespace plumb {

using namespace radiosity;

template <>
void Rows<GatherKernel, Isa::PLUMB_ISA>::run(const GatherView& in, int first, int last, const Tiles& tiles, float*) {
    if (in.half_weights && in.planes) {
        for (int i = first * in.u.width; i < min(last * in.u.width, in.u.count); ++i) gather_row(in, i);
        return;
    }
    each_packet<F>(in.u.width, first, last, tiles, [&](int, I px, int y, NoTap& tap) { return gathered<F>(in, px, I(y), tap); },
                   [&](I at, const vec4<F>& value, mask_t<F> active) { N::store4(in.irradiance, at, value, active); },
                   [&](I px, int y) { return GatherKernel::writes<F>(in, px, I(y)); });
}

}  // namespace plumb
