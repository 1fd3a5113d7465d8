// What arrives from a lamp: for stages that ask for more than its irradiance on a surface; arriving.glsl is the twin.
#pragma once

#include "raster/light_kernel.h"

namespace plumb::raster {

// Irradiance on a plane across the rays, W/m2, and the direction towards the lamp, unit.
template <class F>
struct Arriving {
    vec3<F> irradiance, direction;
};
template <class F>
PLUMB_INLINE Arriving<F> arriving_from(const LightArgs& light, const vec3<F>& x) {
    const vec3<F> axis{F(light.direction[0]), F(light.direction[1]), F(light.direction[2])};
    if (light.directional > 0.0f)
        return {{F(light.intensity[0]), F(light.intensity[1]), F(light.intensity[2])}, {-axis.x, -axis.y, -axis.z}};
    const vec3<F> d{F(light.position[0]) - x.x, F(light.position[1]) - x.y, F(light.position[2]) - x.z};
    const F d2 = dot3(d, d);
    const F inverse = F(1.0f) / sqrt(max(d2, F(1e-37f)));
    const vec3<F> w = d * inverse;
    const vec3<F> intensity = light_intensity(light, -dot3(w, axis), d2);
    return {intensity * (inverse * inverse), w};
}

}  // namespace plumb::raster
