// Irradiance of receivers into the levels of the lightmap, borders extended: the algorithm that lightmap_write.comp mirrors line
// by line.
//
//     a receiver's texel     its irradiance
//     ring 1                 the mean of the receivers among its 8 neighbours, added in the order of rows
//     ring 2                 the mean of the ring-1 texels among its 8 neighbours
//     any other              0
//
// `cover` says which a texel is (run_data.h). Levels lie two empty rows apart, so that none's neighbours are another's.
//
// differs: IPR 3.3.1.3 lets a receiver write its border texels along rows and columns; here they gather (receivers.h), in one
// pass: ring 2 asks the neighbours of its neighbours.
#pragma once

#include "core/number.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct LightmapUniforms {
    std::int32_t width, height;  // of the strip of levels
    std::int32_t places;
    std::int32_t padding;
};
static_assert(sizeof(LightmapUniforms) == 16);

struct LightmapView {
    LightmapUniforms u;
    const std::int32_t* cover;  // [height][width]: place of the receiver; -2 ring 1, -3 ring 2, else nothing
    const float* irradiance;    // [places][4]: xyz W/m2
    float* lightmap;            // out: [height][width][4]
};

// -1 beyond the strip.
template <class F>
PLUMB_INLINE index_t<F> cover_at(const LightmapView& in, index_t<F> x, index_t<F> y) {
    using I = index_t<F>;
    const mask_t<F> inside = in_range(x, I(in.u.width)) & in_range(y, I(in.u.height));
    return select(inside, number<F>::fetch(in.cover, select(inside, y * I(in.u.width) + x, I(0))), I(-1));
}

// 0 where it is no place.
template <class F>
PLUMB_INLINE vec3<F> irradiance_at(const LightmapView& in, index_t<F> place) {
    using I = index_t<F>;
    const mask_t<F> there = in_range(place, I(in.u.places));
    const vec3<F> e = xyz<F>(number<F>::fetch4(in.irradiance, select(there, place, I(0))));
    return select3<F>(there, e, {F(0.0f), F(0.0f), F(0.0f)});
}

template <class F>
struct NeighbourMean {
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    F count{0.0f};

    PLUMB_INLINE void add(const mask_t<F>& counts, const vec3<F>& value) {
        sum = select3<F>(counts, {sum.x + value.x, sum.y + value.y, sum.z + value.z}, sum);
        count = select(counts, count + F(1.0f), count);
    }
    PLUMB_INLINE vec3<F> mean() const {
        const F n = max(count, F(1.0f));
        return {sum.x / n, sum.y / n, sum.z / n};
    }
};

template <class F>
PLUMB_INLINE vec3<F> mean_of_receivers(const LightmapView& in, index_t<F> x, index_t<F> y) {
    using I = index_t<F>;
    NeighbourMean<F> all;
    for (int k = 0; k < 9; ++k) {
        const I cover = cover_at<F>(in, x + I(k % 3 - 1), y + I(k / 3 - 1));
        const mask_t<F> counts = in_range(cover, I(in.u.places));
        if (any(counts)) all.add(counts, irradiance_at<F>(in, cover));
    }
    return all.mean();
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> lightmap(const LightmapView& in, index_t<F> x, index_t<F> y, Tap& tap) {
    using I = index_t<F>;
    const I cover = cover_at<F>(in, x, y);                        tap("cover", cover, "place of the receiver; -2 ring 1, -3 ring 2");
    vec3<F> value = irradiance_at<F>(in, cover);                  tap("irradiance", value, "of the receiver, W/m2");
    const mask_t<F> ring_1 = cover == I(-2), ring_2 = cover == I(-3);
    if (any(ring_1)) {
        const vec3<F> mean = mean_of_receivers<F>(in, x, y);      tap("ring_1", mean, "mean of the receivers beside it, W/m2");
        value = select3<F>(ring_1, mean, value);
    }
    if (any(ring_2)) {
        NeighbourMean<F> all;
        for (int k = 0; k < 9; ++k) {
            const I nx = x + I(k % 3 - 1), ny = y + I(k / 3 - 1);
            const mask_t<F> counts = cover_at<F>(in, nx, ny) == I(-2);
            if (any(counts)) all.add(counts, mean_of_receivers<F>(in, nx, ny));
        }
        const vec3<F> mean = all.mean();                          tap("ring_2", mean, "mean of the ring-1 texels beside it, W/m2");
        value = select3<F>(ring_2, mean, value);
    }
    tap("lightmap", value, "what the texel holds, W/m2");
    const mask_t<F> covered = in_range(cover, I(in.u.places)) | ring_1 | ring_2;
    return vec4<F>(value, select(covered, F(1.0f), F(0.0f)));
}

struct LightmapKernel {
    using View = LightmapView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> x, index_t<F> y, Tap& tap) {
        return lightmap<F>(in, x, y, tap);
    }
    static float* out(const View& in) { return in.lightmap; }
    static constexpr int band = 32;
    // Three rows of receivers, three of ring 1, and a texel on either side.
    static std::size_t scratch(const View& in, int) { return 6 * 4 * (std::size_t(in.u.width) + 2); }
};

}  // namespace plumb::probes
