// Shadow rays of a gather: whether shading points see pixel lights, a packet of lanes at a time.
#pragma once

#include "gi/trace_rays.h"

namespace plumb::rsm {

// How far a ray keeps off the two surfaces that it runs between, m: no less than their positions may be wrong by.
struct RayOffsets {
    float receiver = 0, texel = 0;
};

// F is float or the packet of the instruction set.
template <class F>
struct ShadowRays {
    RayTracer<F> tracer;
    RayOffsets offsets;

    ShadowRays(const RayQuery& query, RayOffsets offsets) : tracer(query), offsets(offsets) {}

    // Lanes of `wanted` whose x sees x_p, distance2 = |x_p - x|^2 apart. The ray runs from above x to above x_p, along
    // their normals, and leaves out both ends of its length, so that neither a surface that meets x's at an edge nor
    // rounding of x itself hides the light. Surfaces closer than that see each other.
    PLUMB_INLINE mask_t<F> visible(const vec3<F>& x, const vec3<F>& n, const vec3<F>& x_p, const vec3<F>& n_p,
                                   F distance2, const mask_t<F>& wanted) {
        const vec3<F> start = x + n * F(offsets.receiver), end = x_p + n_p * F(offsets.texel);
        const F inverse = F(1.0f) / sqrt(distance2);
        const F t_near = F(offsets.receiver) * inverse, t_far = F(1.0f) - F(offsets.texel) * inverse;
        const mask_t<F> open = t_near < t_far, asks = wanted & open;
        if (!any(asks)) return wanted;
        const mask_t<F> close = wanted & !open;
        return close | tracer.visible(start, end - start, t_near, t_far, asks);
    }
};

}  // namespace plumb::rsm
