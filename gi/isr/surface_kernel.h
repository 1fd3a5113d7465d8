// Where a coarse pixel's surface is and how much of it a sample stands for: what gather_kernel.h and ssao_kernel.h share,
// mirrored by surface.glsl.
//
// A pixel (x, y) of the receivers' grid is seen along the ray r = f_o + x f_u + y f_v, at eye depth 1 m. A surface at
// eye depth z lies at r z from the eye (ISR 4.3).
#pragma once

#include "core/number.h"

namespace plumb::isr {

// The twins' uniform block (std140) of isr.gather and isr.ssao.
struct SampleUniforms {
    glm::vec4 right, down;               // xyz f_u, f_v, m at eye depth 1; w: 0, up to rounding
    glm::vec4 of_depth, origin;          // xyz 0 and f_o; w: 1 / eye depth is of_depth.w (clip depth) + origin.w
    std::int32_t width, height;          // of the receivers, coarse pixels
    std::int32_t source_width, source_height;
    std::int32_t margin;                 // of the sources, left of and above pixel (0, 0)
    std::int32_t rings;
    std::int32_t rotations;              // a power of two
    std::uint32_t seed;
    std::int32_t far_rings;              // that every pixel has
    std::int32_t published;              // ISR (25) and (26): 1 as printed, 2 without 2 pi / N, 3 that in place of an area
    std::int32_t inverse_matrix;         // 1: surfaces hold clip depth
    std::int32_t tile;                   // side of the tile that deals out rotations, pixels; 0: a hash does
    float area;                          // m2 of the patch around a sample at eye depth 1, seen head-on; isr.ssao: over pi
    float least_cosine;
    float full_reach;                    // m: ring r beyond far_rings is for pixels with r z at most this
    float scale;                         // published: 2 pi / N, of all rings; without it 1
    float per_length;                    // 1/m, isr.ssao published: the cosine of (26) is of PX times it; 0: of PX over |PX|
    std::int32_t padding[3];
};
static_assert(sizeof(SampleUniforms) == 144);

inline constexpr float farthest = 1e15f;       // m; squares of what lies beyond would leave the range of a float
inline constexpr float least_distance2 = 1e-37f;  // m2: the floor of d^2; below it its inverse would overflow

// All 0 where no surface is.
template <class F>
struct Surface {
    vec3<F> position;  // from the eye, m
    F depth;           // of the eye, linear, m
    vec3<F> normal;    // unit
    vec3<F> ray;       // at eye depth 1 m; never 0
};

template <class F>
PLUMB_INLINE mask_t<F> is_covered(const Surface<F>& s) {
    return dot3(s.normal, s.normal) > F(0.0f);
}

// (x, y): pixel of the receivers' grid; outside 0 .. size - 1 in a guard band.
template <class F>
PLUMB_INLINE Surface<F> surface_of(const SampleUniforms& u, index_t<F> x, index_t<F> y, const vec4<F>& texel) {
    using N = number<F>;
    const F fx = N::from_index(x), fy = N::from_index(y), zero(0.0f);
    vec3<F> ray{F(u.right.x) * fx + F(u.down.x) * fy + F(u.origin.x),
                F(u.right.y) * fx + F(u.down.y) * fy + F(u.origin.y),
                F(u.right.z) * fx + F(u.down.z) * fy + F(u.origin.z)};
    F depth = texel.w;
    if (u.inverse_matrix != 0) {
        // The product of a matrix and (x, y, depth, 1); the division by w.
        ray.x = ray.x + F(u.of_depth.x) * texel.w;
        ray.y = ray.y + F(u.of_depth.y) * texel.w;
        ray.z = ray.z + F(u.of_depth.z) * texel.w;
        const F w = F(u.right.w) * fx + F(u.down.w) * fy + F(u.origin.w) + F(u.of_depth.w) * texel.w;
        depth = F(1.0f) / w;
    }
    const vec3<F> n = xyz<F>(texel);
    const mask_t<F> is = (dot3(n, n) > zero) & !((depth < zero) | (depth > F(farthest)));
    const F z = select(is, depth, zero);
    const vec3<F> none{zero, zero, zero};
    return {{ray.x * z, ray.y * z, ray.z * z}, z, select3<F>(is, n, none), ray};
}

// A_X, m2: u.area at eye depth 1 faces the camera; at depth z it is z^2 as large, and on a surface with normal n the
// pixel's pyramid cuts out 1 / |n . r| of that, since r has length 1 along the camera's axis (README).
//
// differs: ISR 4.4 bases it on depth alone (variant `published`).
template <class F>
PLUMB_INLINE F area_of(const SampleUniforms& u, const Surface<F>& s) {
    const F facing = (F(u.area) * s.depth) * s.depth;
    if (u.published != 0) return facing;
    const F least = F(u.least_cosine) * sqrt(dot3(s.ray, s.ray));
    return facing / max(abs(dot3(s.normal, s.ray)), least);
}

// A sample's offset in pixels.
template <class I>
PLUMB_INLINE ivec2<I> offset_of(I packed) {
    return {(packed << 16) >> 16, packed >> 16};
}

}  // namespace plumb::isr
