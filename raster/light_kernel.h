// What a light sends out, as raster/rsm_kernel.h and gi/direct read it; light.glsl is the twin.
#pragma once

#include "core/number.h"

namespace plumb::raster {

// A light for kernels (std140: four vec4; see light.glsl). Filled by light_args(), light_view.h.
struct LightArgs {
    float position[3];    // m; not used by a directional light
    float cos_outer;      // cosine of the outer half angle; a point light: -2, so that it shines everywhere
    float direction[3];   // unit: the way the light travels
    float falloff_scale;  // 1 / (cos_inner - cos_outer); a large number where the two are equal
    float intensity[3];   // spot, point: W/sr; directional, or of a radius: irradiance on a plane across the light, W/m2
    float directional;    // 1: directional, 0: spot or point
    float inverse_radius2;  // 1/m2: the light ends at its radius, ISR (16); 0: it falls off as 1/d^2 and ends nowhere
    float radius2;          // m2
    float padding[2];
};
static_assert(sizeof(LightArgs) == 64);

// Share of the intensity that is left at the angle whose cosine to the axis is `cosine`:
// smoothstep(cos_outer, cos_inner, cosine), spelled out because drivers differ in theirs.
template <class F>
PLUMB_INLINE F spot_falloff(const LightArgs& light, F cosine) {
    const F t = clamp((cosine - F(light.cos_outer)) * F(light.falloff_scale), F(0.0f), F(1.0f));
    return t * t * (F(3.0f) - F(2.0f) * t);
}

// Radiant intensity of a spot or point light in that direction, W/sr; of one with a radius what would send, by 1/d^2, as
// much to the squared distance d2 (m2) as ISR (16) does:
//
//     I max(0, 1 - d^2 / r^2) d^2 = I (1 - s) s r^2,     s = min(d^2 / r^2, 1)
//
// Both are finite for every distance.
template <class F>
PLUMB_INLINE vec3<F> light_intensity(const LightArgs& light, F cosine, F d2) {
    F falloff = spot_falloff(light, cosine);
    if (light.inverse_radius2 > 0.0f) {
        const F s = min(d2 * F(light.inverse_radius2), F(1.0f));
        falloff = falloff * ((F(1.0f) - s) * s * F(light.radius2));
    }
    return {F(light.intensity[0]) * falloff, F(light.intensity[1]) * falloff, F(light.intensity[2]) * falloff};
}

}  // namespace plumb::raster
