// The lightmap of the run time, a strip of levels of detail, and its bilinear lookup, mirrored by lightmap_levels.glsl.
//
// Level k of an atlas of T x T texels has T_k = ceil(T / 2^k) texels a side. The levels lie below each other in one image T wide, two
// empty rows apart: level k in rows [first_k, first_k + T_k), columns [0, T_k), first_{k+1} = first_k + T_k + 2. Its texel (x, y)
// shows the receiver at texel (x 2^k, y 2^k) of level 0 (IPR 4.2.3), and so stands at the centre of that one:
//
//     (u, v) is texel ((u T - 1/2) / 2^k, (v T - 1/2) / 2^k) of level k, held within its own texels        centres are whole
//
// differs: a mip level's lookup, u T_k - 1/2, takes texels for the means of 2^k x 2^k; of every 2^k-th receiver it would show the
// light (1 - 2^-k) / 2 texels of that level off. Weights are floats; a GPU's filter has 8 bits.
#pragma once

#include "raster/project_kernel.h"

namespace plumb::probes {

inline constexpr int most_levels = 4;

// What a kernel is given of the strip.
struct LightmapArgs {
    const float* texels;  // [rows][side][4]
    std::int32_t side;    // T
    std::int32_t levels;  // 1 to most_levels
};

// Of one level: its first row in the strip, its texels a side, and 2^-k.
template <class F>
struct LightmapLevel {
    index_t<F> first, side;
    F scale;
};

template <class F>
PLUMB_INLINE LightmapLevel<F> lightmap_level(int side, int levels, index_t<F> level) {
    using I = index_t<F>;
    LightmapLevel<F> of{I(0), I(side), F(1.0f)};
    int first = 0, texels = side;
    float scale = 1;
    for (int k = 1; k < levels; ++k) {
        first = first + texels + 2;
        texels = (texels + 1) >> 1;
        scale = scale * 0.5f;
        const mask_t<F> coarser = level >= I(k);
        of = {select(coarser, I(first), of.first), select(coarser, I(texels), of.side), select(coarser, F(scale), of.scale)};
    }
    return of;
}
// The strip's rows.
constexpr int lightmap_rows(int side, int levels) {
    int rows = side;
    for (int k = 1; k < levels; ++k) side = (side + 1) / 2, rows += side + 2;
    return rows;
}

// (1 - share) a + share b: a itself for share 0, and what all have where all are equal.
template <class F>
PLUMB_INLINE vec3<F> mixed(const vec3<F>& a, const vec3<F>& b, F share) {
    return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.z + share * (b.z - a.z)};
}

// Bilinear, x then y: xyz of the four texels around `uv` of a level in 0 .. levels - 1; of another the nearest of these.
template <class F, class Tap>
PLUMB_INLINE vec3<F> lightmap_at(const LightmapArgs& in, const vec2<F>& uv, index_t<F> level, Tap& tap) {
    using raster::chosen;
    using N = number<F>;
    using I = index_t<F>;
    const LightmapLevel<F> k = lightmap_level<F>(in.side, in.levels, level);
    tap("lightmap_first", k.first, "row of the strip that the level begins in");
    const I last = k.side - I(1);
    const F most = N::from_index(last), side(float(in.side));
    const vec2<F> place{clamp((uv.x * side - F(0.5f)) * k.scale, F(0.0f), most),
                        clamp((uv.y * side - F(0.5f)) * k.scale, F(0.0f), most)};
    tap("lightmap_place", place, "where uv lies on the level, texels; centres are whole");
    const I px = chosen(place.x), py = chosen(place.y);
    const I x = max(I(0), min(px, last)), y = max(I(0), min(py, last));
    const I right = min(x + I(1), last), below = min(y + I(1), last);
    const vec2<F> share{place.x - N::from_index(x), place.y - N::from_index(y)};
    tap("lightmap_share", share, "weight of the right and of the lower texels");
    const I row = (k.first + y) * I(in.side), next = (k.first + below) * I(in.side);
    const vec3<F> upper = mixed<F>(xyz<F>(N::fetch4(in.texels, row + x)), xyz<F>(N::fetch4(in.texels, row + right)), share.x);
    const vec3<F> lower = mixed<F>(xyz<F>(N::fetch4(in.texels, next + x)), xyz<F>(N::fetch4(in.texels, next + right)), share.x);
    const vec3<F> value = mixed<F>(upper, lower, share.y);
    tap("looked_up", value, "the lightmap there");
    return value;
}

}  // namespace plumb::probes
