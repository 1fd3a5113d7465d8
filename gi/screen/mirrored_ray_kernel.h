// The ray of which a mirror makes the ray to the eye, and where it was found to meet what a view sees: mirrored by
// mirrored_ray.glsl.
//
//     r = v - 2 (n.v) n        v: unit, from the eye to p                                                    LRA 6.2.4
//
// What rises above the plane of p by no more than the bias cannot be met by a ray that leaves it; what turns its back to
// the ray is not what the ray meets.
#pragma once

#include "gi/screen/view_kernel.h"

namespace plumb::screen {

template <class F>
struct MirroredRay {
    vec3<F> p, n;         // world, m; unit
    vec3<F> r;            // unit
    vec3<F> from_anchor;  // p from the view's anchor, m
    F cosine;             // n.v: below 0 where the surface is seen from its front
};

template <class F>
PLUMB_INLINE vec3<F> from(const float* origin, const vec3<F>& p) {
    return {p.x - F(origin[0]), p.y - F(origin[1]), p.z - F(origin[2])};
}

// w: from the eye to p, of any length.
template <class F, class Tap>
PLUMB_INLINE MirroredRay<F> mirrored_ray(const vec3<F>& p, const vec3<F>& n, const vec3<F>& w, const float* anchor, Tap& tap) {
    const F inverse = F(1.0f) / sqrt(max(dot3(w, w), F(1e-37f)));
    const vec3<F> v{w.x * inverse, w.y * inverse, w.z * inverse}; tap("v", v, "unit, from the eye to p");
    const F cosine = dot3(n, v), twice = cosine + cosine;         tap("cosine", cosine, "n.v");
    const vec3<F> r{v.x - n.x * twice, v.y - n.y * twice, v.z - n.z * twice};
    tap("r", r, "v - 2 (n.v) n, LRA 6.2.4");
    return {p, n, r, from(anchor, p), cosine};
}

// Takes the ray that screen.lobe has drawn in place of the mirrored one. Returns whether there is one.
template <class F, class Tap>
PLUMB_INLINE mask_t<F> take_drawn(const vec4<F>& drawn, MirroredRay<F>& ray, Tap& tap) {
    ray.r = xyz<F>(drawn);                                        tap("drawn", ray.r, "w_i, as screen.lobe has drawn it");
    return drawn.w > F(0.0f);
}

// Whether the ray may meet the surface point q: it lies above the plane of p, and turns its front to the ray.
template <class F, class Tap>
PLUMB_INLINE mask_t<F> may_be_met(const MirroredRay<F>& ray, const vec3<F>& q, const vec3<F>& n_q, float bias, Tap& tap) {
    const F rise = dot3(vec3<F>{q.x - ray.p.x, q.y - ray.p.y, q.z - ray.p.z}, ray.n);
    tap("rise", rise, "n.(q - p), m");
    const F facing = dot3(n_q, ray.r);                            tap("facing", facing, "n_q.r");
    return (rise > F(bias)) & (facing < F(0.0f));
}

// Where the ray was found behind what the view sees.
template <class F>
struct Crossing {
    F t;               // along the ray, m
    vec2<F> texel;     // of the view, whole numbers
    F behind;          // in depth, m
    mask_t<F> found;
};

template <class F>
PLUMB_INLINE void take(const mask_t<F>& where, F t, const ivec2<index_t<F>>& texel, F behind, Crossing<F>& c) {
    using N = number<F>;
    c.t = select(where, t, c.t);
    c.texel = {select(where, N::from_index(texel.x), c.texel.x), select(where, N::from_index(texel.y), c.texel.y)};
    c.behind = select(where, behind, c.behind);
}

// The hit that stands: what was found before, unless it lies farther. The camera's is not asked about again.
template <class F, class Tap>
PLUMB_INLINE vec4<F> nearer_hit(const vec4<F>& before, const Crossing<F>& c, std::int32_t number, Tap& tap) {
    tap("error", c.behind, "of the hit, in depth, m");
    const mask_t<F> found = c.found & ((before.w == F(0.0f)) | (c.t < before.z));
    const vec4<F> hit{select(found, c.texel.x, before.x), select(found, c.texel.y, before.y), select(found, c.t, before.z),
                      select(found, F(float(number)), before.w)};
    tap("hit", vec3<F>{hit.x, hit.y, hit.z}, "texel; distance along the ray, m");
    tap("view", hit.w, "in which it was found: 1 the camera's, then its layers and the lights' maps; 0: none");
    return hit;
}

}  // namespace plumb::screen
