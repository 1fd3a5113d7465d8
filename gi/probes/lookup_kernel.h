// Indirect light of a pixel: the lightmap where the pixel lies on it (IPR 3.3.1.4, 4.2.4), the algorithm that lookup.comp mirrors
// line by line.
//
//     I = (1 - b) lightmap(uv, l) + b lightmap(uv, l + 1)        l + b: the pixel's level of detail, b from 0 to 1
//
// A pixel is blended from its level towards the next coarser one, never towards a finer one: what is computed at level l is
// computed at all coarser levels.
#pragma once

#include "gi/probes/lightmap_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct LookupUniforms {
    std::int32_t width, height;
    std::int32_t side;    // texels of the lightmap's finest level
    std::int32_t levels;
};
static_assert(sizeof(LookupUniforms) == 16);

struct LookupView {
    LookupUniforms u;
    const float* uv;        // [height][width][4]: xy on the lightmap, z level of detail, w 1; or w 0: it has no place there
    const float* lightmap;  // the strip (lightmap_kernel.h)
    float* irradiance;      // out: [height][width][4]
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> lookup(const LookupView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const LookupUniforms& u = in.u;
    const vec4<F> at = N::fetch4(in.uv, py * I(u.width) + px);
    tap("uv", xyz<F>(at), "on the lightmap; level of detail");
    const mask_t<F> has = at.w > F(0.0f);
    const LightmapArgs map{in.lightmap, u.side, u.levels};
    const F z = max(F(0.0f), min(at.z, F(float(u.levels - 1))));
    const I level = raster::chosen(z);
    const F share = z - N::from_index(level);                     tap("share", share, "b, of the next coarser level");
    const vec2<F> uv{at.x, at.y};
    const vec3<F> fine = lightmap_at<F>(map, uv, level, tap);     tap("fine", fine, "of level l, W/m2");
    const vec3<F> coarse = lightmap_at<F>(map, uv, level + I(1), tap);
    tap("coarse", coarse, "of level l + 1, W/m2");
    const vec3<F> mean = mixed<F>(fine, coarse, share);
    const vec4<F> irradiance{select(has, mean.x, F(0.0f)), select(has, mean.y, F(0.0f)), select(has, mean.z, F(0.0f)), F(0.0f)};
    tap("irradiance", xyz<F>(irradiance), "(1 - b) fine + b coarse, W/m2; 0 without a place");
    return irradiance;
}

struct LookupKernel {
    using View = LookupView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return lookup<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.irradiance; }
};

}  // namespace plumb::probes
