// Hard shadow test against a light's depth map: the algorithm that shadow.comp mirrors line by line.
//
//     lit  <=>  d_p <= d_map + bias                                            VRSM Algorithm 4 with a kernel of one texel
//
// differs: the printed comparison counts `d_map - bias >= d_p` with negative z; depths here are positive and linear, in
// metres. Outside the map nothing is known to stand in the way: lit.
//
// The bias follows the surface. Across one texel of footprint f (m, across the light's axis a) the depth of a plane with
// normal n changes by f sqrt(1 - (n.a)^2) / |n.r|, where r is the ray to the point, scaled to depth 1. Half a texel in
// both directions needs 1/sqrt(2) of that; slope_bias = 1 leaves a margin for rounding.
#pragma once

#include "core/number.h"

namespace plumb::direct {

// The twin's uniform block (std140).
struct ShadowUniforms {
    float to_texel_x[4];   // rows of world -> texel, as in gi/rsm/gather_kernel.h
    float to_texel_y[4];
    float to_texel_w[4];
    float eye[4];          // xyz: where the light's linear depth starts
    float forward[4];      // xyz: unit, the light's axis
    float least_w;         // m
    float footprint_scale; // footprint of a texel = footprint_scale d + footprint_base, m
    float footprint_base;
    float bias;            // m
    float slope_bias;      // texels
    float max_slope;
    float perspective;     // 1: spot, 0: directional
    std::int32_t size;     // texels a side of the map
    std::int32_t width, height;
    std::int32_t padding[2];
};
static_assert(sizeof(ShadowUniforms) == 128);

struct ShadowInputsView {
    ShadowUniforms u;
    const float* position;      // [height][width] rgba32f: xyz world, m
    const float* normal;        // [height][width] rgba32f: xyz unit
    const float* map_position;  // [size][size] rgba32f: w linear depth, m; 0 where nothing is
    float* visibility;          // [height][width] r32f, out: 1 lit, 0 shadowed
};

template <class F, class Tap>
PLUMB_INLINE F shadow(const ShadowInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ShadowUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));       tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));         tap("n", n, "unit normal of x");

    // Project x to the map.
    auto row = [&](const float* m) { return F(m[0]) * x.x + F(m[1]) * x.y + F(m[2]) * x.z + F(m[3]); };
    const F w = max(F(u.least_w), row(u.to_texel_w)), far(1048576.0f);
    const vec2<F> projection{clamp(row(u.to_texel_x) / w, -far, far), clamp(row(u.to_texel_y) / w, -far, far)};
    const ivec2<I> texel{N::truncate_to_index(floor(projection.x)), N::truncate_to_index(floor(projection.y))};
    const mask_t<F> inside = in_range(texel.x, I(u.size)) & in_range(texel.y, I(u.size));
    tap("projection", projection, "x projected to the map, texels");

    // Measure the depth of x, and how much depth changes across a texel there.
    const vec3<F> axis{F(u.forward[0]), F(u.forward[1]), F(u.forward[2])};
    const vec3<F> from_eye{x.x - F(u.eye[0]), x.y - F(u.eye[1]), x.z - F(u.eye[2])};
    const F d_p = dot3(from_eye, axis);                            tap("d_p", d_p, "linear depth of x, m");
    const F n_a = dot3(n, axis);
    const F n_r = u.perspective > 0.0f ? dot3(n, from_eye) / max(d_p, F(u.least_w)) : n_a;
    const F across = sqrt(max(F(0.0f), F(1.0f) - n_a * n_a));
    const F slope = min(across / max(abs(n_r), F(1e-6f)), F(u.max_slope));
    const F footprint = F(u.footprint_scale) * d_p + F(u.footprint_base);
    const F bias = F(u.bias) + F(u.slope_bias) * footprint * slope;
    tap("bias", bias, "bias + slope_bias f sqrt(1 - (n.a)^2) / |n.r|, m");

    const F d_map = N::fetch4(in.map_position, select(inside, texel.y * I(u.size) + texel.x, I(0))).w;
    tap("d_map", d_map, "linear depth in the map, m; 0 where nothing is");
    const mask_t<F> shadowed = inside & (d_map > F(0.0f)) & (d_p > d_map + bias);
    const F visibility = select(shadowed, F(0.0f), F(1.0f));
    tap("visibility", visibility, "VRSM Algorithm 4: lit if d_p <= d_map + bias");
    return visibility;
}

}  // namespace plumb::direct
