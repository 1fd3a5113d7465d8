// Shadow tests against a light's depth map: the algorithm that shadow.comp mirrors line by line.
//
//     visibility = share of the k x k texels around the projection of x for which    d_p <= d_map + bias
//                                                                                              VRSM Algorithm 4
//
// A kernel of one texel is the hard test. Where the map holds nothing, and outside of it, nothing is known to stand in
// the way: lit.
//
// The bias follows the surface. Across one texel of footprint f (m, across the light's axis a) the depth of a plane with
// normal n changes by f sqrt(1 - (n.a)^2) / |n.r|, where r is the ray to the point, scaled to depth 1. Half a texel in
// both directions needs 1/sqrt(2) of that; slope_bias = 1 leaves a margin for rounding. A wider kernel reaches farther:
// the host multiplies slope_bias by the reach.
//
// differs: the printed listing has a constant bias, and compares `depth - zBias >= p.depth` with negative z, which holds
// for the samples in shadow; its text blends the count as the share that is lit (variant `published`).
#pragma once

#include "core/number.h"
#include "raster/project_kernel.h"

namespace plumb::direct {

// The twin's uniform block (std140).
struct ShadowUniforms {
    raster::Projection map;
    float eye[4];           // xyz: where the light's linear depth starts
    float forward[4];       // xyz: unit, the light's axis
    float footprint_scale;  // footprint of a texel = footprint_scale d + footprint_base, m
    float footprint_base;
    float bias;             // m
    float slope_bias;       // texels
    float max_slope;
    float perspective;      // 1: spot, point; 0: directional
    std::int32_t kernel;    // texels a side
    float samples;          // kernel^2
    std::int32_t published; // 1: Algorithm 4 as printed
    std::int32_t face;      // of a point light: this map serves the points of that face alone; -1: a map serves all
    std::int32_t width, height;
};
static_assert(sizeof(ShadowUniforms) == 144);

struct ShadowInputsView {
    ShadowUniforms u;
    const float* position;      // [height][width] rgba32f: xyz world, m
    const float* normal;        // [height][width] rgba32f: xyz unit
    const float* map_position;  // [size][size] rgba32f: w linear depth, m; 0 where nothing is
    float* visibility;          // [height][width] r32f, out: 1 lit, 0 shadowed
};

// True where this map serves x: the points of one face have no other map, so that no seam is left or counted twice.
template <class F>
PLUMB_INLINE mask_t<F> serves(const ShadowUniforms& u, const vec3<F>& x) {
    const vec3<F> from_eye{x.x - F(u.eye[0]), x.y - F(u.eye[1]), x.z - F(u.eye[2])};
    return raster::face_of<F>(from_eye) == index_t<F>(u.face);
}

template <class F, class Tap>
PLUMB_INLINE F shadow(const ShadowInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ShadowUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));       tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));         tap("n", n, "unit normal of x");
    const ivec2<I> centre = raster::project<F>(u.map, x, tap);     tap("centre", centre, "texel of the projection");

    // Measure the depth of x, and how much depth changes across a texel there.
    const vec3<F> axis{F(u.forward[0]), F(u.forward[1]), F(u.forward[2])};
    const vec3<F> from_eye{x.x - F(u.eye[0]), x.y - F(u.eye[1]), x.z - F(u.eye[2])};
    const F d_p = dot3(from_eye, axis);                            tap("d_p", d_p, "linear depth of x, m");
    const F n_a = dot3(n, axis);
    const F n_r = u.perspective > 0.0f ? dot3(n, from_eye) / max(d_p, F(u.map.least_w)) : n_a;
    const F across = sqrt(max(F(0.0f), F(1.0f) - n_a * n_a));
    const F slope = min(across / max(abs(n_r), F(1e-6f)), F(u.max_slope));
    const F footprint = F(u.footprint_scale) * d_p + F(u.footprint_base);
    const F bias = F(u.bias) + F(u.slope_bias) * footprint * slope;
    tap("bias", bias, "bias + slope_bias f sqrt(1 - (n.a)^2) / |n.r|, m");

    F count(0.0f);
    const int first = -(u.kernel / 2);
    for (int k = 0; k < u.kernel * u.kernel; ++k) {
        tap.sample(k);
        ivec2<I> texel{centre.x + I(first + k % u.kernel), centre.y + I(first + k / u.kernel)};
        if (u.face >= 0) {
            // Beyond the border lies another face; the border's texels stand in for it.
            const I last(u.map.size - 1);
            texel = {min(max(texel.x, I(0)), last), min(max(texel.y, I(0)), last)};
        }
        tap("texel", texel, "VRSM Algorithm 4: centre + (i, j), from -kernel/2");
        const mask_t<F> inside = in_range(texel.x, I(u.map.size)) & in_range(texel.y, I(u.map.size));
        tap("inside", inside, "1 if the map has that texel; if not, what follows is texel 0, and is lit");
        const F d_map = N::fetch4(in.map_position, select(inside, texel.y * I(u.map.size) + texel.x, I(0))).w;
        tap("d_map", d_map, "linear depth in the map, m; 0 where nothing is");
        if (u.published != 0) {
            const mask_t<F> counted = inside & (-d_map - F(u.bias) >= -d_p);
            count += select(counted, F(1.0f), F(0.0f));
            tap("count", count, "Algorithm 4 as printed: z_map - zBias >= z_p, z = -depth");
        } else {
            const mask_t<F> shadowed = inside & (d_map > F(0.0f)) & (d_p > d_map + bias);
            count += select(shadowed, F(0.0f), F(1.0f));
            tap("count", count, "so far, of texels with d_p <= d_map + bias");
        }
    }
    tap.sample(-1);
    const F visibility = count / F(u.samples);
    tap("visibility", visibility, "VRSM Algorithm 4: count / kernel^2");
    return visibility;
}

}  // namespace plumb::direct
