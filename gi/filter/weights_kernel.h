// How alike two pixels of a surface are: what upsample_kernel.h and blur_kernel.h share, mirrored by weights.glsl.
//
// Both weights are polynomials that reach 0: beyond that, nothing crosses an edge, not a thousandth of it. VRSM 4.5 names
// what they depend on, depth difference and normal continuity, and leaves their form open: these are ours.
#pragma once

#include "core/number.h"

namespace plumb::filter {

// What depth difference is measured by. plane: the distance of x_i from the plane through x with normal n, so that a
// slanted surface is no edge. depth: the difference of the linear depths, as VRSM 4.5 has it.
enum class Similarity : int { plane, depth };

// A pixel as the filters read it. All 0: no surface.
template <class F>
struct Texel {
    vec3<F> irradiance;  // W/m2
    F depth;             // linear, m
    vec3<F> normal;      // unit
    vec3<F> position;    // world, m; read for the plane's distance alone
};

// The pixel that others are compared with.
template <class F>
struct Centre {
    vec3<F> x;         // world, m
    F depth;           // m
    F per_sigma;       // 1/m: 1 / (sigma_depth depth)
    vec3<F> across;    // 1/m: n per_sigma
    vec3<F> scaled_n;  // n / sigma_normal
};

// normal_slope: 1 / sigma_normal.
template <class F>
PLUMB_INLINE Centre<F> centre_of(const vec3<F>& x, F depth, const vec3<F>& n, float sigma_depth, float normal_slope) {
    // Below 1e-37 m the inverse would overflow.
    const F per_sigma = F(1.0f) / max(F(sigma_depth) * depth, F(1e-37f));
    return {x, depth, per_sigma, n * per_sigma, n * F(normal_slope)};
}

// max(0, 1 - d^2), d the difference in depth in sigmas.
template <class F, class Tap>
PLUMB_INLINE F depth_weight(bool plane, const Centre<F>& c, const Texel<F>& p, Tap& tap) {
    const F d = plane ? dot3(c.across, p.position - c.x) : (p.depth - c.depth) * c.per_sigma;
    const F weight = max(F(0.0f), F(1.0f) - d * d);
    tap("depth_weight", weight, "VRSM 4.5: max(0, 1 - d^2), d of plane or depth in sigmas");
    return weight;
}

// max(0, 1 - (1 - n . n_i) / sigma_normal). offset: 1 - 1 / sigma_normal, which is at most 0, and so is the weight of a
// pixel without a normal.
template <class F, class Tap>
PLUMB_INLINE F normal_weight(const Centre<F>& c, const vec3<F>& n_i, float offset, Tap& tap) {
    const F weight = max(F(0.0f), dot3(c.scaled_n, n_i) + F(offset));
    tap("normal_weight", weight, "VRSM 4.5: max(0, 1 - (1 - n.n_i) / sigma_normal)");
    return weight;
}

}  // namespace plumb::filter
