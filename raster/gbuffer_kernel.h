// One pixel of the G-buffer (ISR 4.2, VRSM 4.2): the algorithm that gbuffer.frag mirrors.
#pragma once

#include "raster/surface_kernel.h"

namespace plumb::raster {

struct GBufferArgs {
    SurfaceArgs surfaces;
    float eye[3], forward[3];     // m; unit
    std::int32_t width;
    const std::int32_t* triangle; // [height][width], -1: nothing
    const float* barycentrics;    // [height][width][2]
    float* position;              // [height][width] rgba32f, out
    float* normal;
    float* albedo;
    float* emission;
};

template <class F>
struct GBufferPixel {
    vec4<F> position, normal, albedo, emission;
};

template <class F, class Tap>
PLUMB_INLINE GBufferPixel<F> gbuffer(const GBufferArgs& in, index_t<F> triangle, const vec2<F>& l, Tap& tap) {
    const Surface<F> s = surface<F>(in.surfaces, triangle, l, tap);
    const F depth = linear_depth(in.eye, in.forward, s.position);    tap("depth", depth, "ISR 4.2: eye depth, m");
    return {vec4<F>(s.position, depth), vec4<F>(s.normal, F(1.0f)), vec4<F>(s.albedo, F(0.0f)),
            vec4<F>(s.emission, F(0.0f))};
}

}  // namespace plumb::raster
