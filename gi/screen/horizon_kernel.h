// Horizon-based ambient occlusion: the algorithm that horizon.comp mirrors line by line.
//
// Jimenez, Wu, Pesce and Jarabo 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion" (GTAO). Planes
// through the view vector v cut the hemisphere into slices. In each, image steps to both sides find the highest point
// within the radius; between the horizons h_1 <= 0 <= h_2, angles from v, the cosine-weighted share is closed:
//
//     A = 1/N sum over slices of |n'| (a(h_1) + a(h_2)),    a(h) = (cos g - cos(2 h - g) + 2 h sin g) / 4
//
// n': n projected to the slice, g its angle from v. Where every horizon is seen, A is what rays of that length find.
//
// differs: slices are uniform about v, not in the image, and steps follow the projection's derivative: away from the image's
// middle the two are not the same. What lies on the plane of p is no horizon: texels beside the slice would be, seen at
// grazing angles. Nothing fades out towards the radius, and no thickness is guessed.
#pragma once

#include "core/detmath.h"
#include "gi/screen/view_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct HorizonUniforms {
    float anchor[4];       // xyz world, m: the eye as a float; w: the least depth, m
    float forward[4];      // linear depth = forward . (v, 1), v from the anchor
    float right[4];        // xyz unit, along which the image's x grows, m; w: pixels of 1 m at depth 1 m
    float down[4];         // the same of y
    float radius;          // m
    float bias;            // m
    std::int32_t slices, steps;
    std::int32_t width, height;
    std::int32_t padding[2];
};
static_assert(sizeof(HorizonUniforms) == 96);

struct HorizonInputsView {
    HorizonUniforms u;
    const float* position;  // [height][width] rgba32f: xyz world, m; w linear depth, m
    const float* normal;    // [height][width] rgba32f: xyz unit; all 0: no surface
    const float* turns;     // [16][slices][2]: cosine and sine of each slice's angle about v
    const float* shares;    // [steps]: of the radius
    float* summed;          // out: as SsaoInputsView has it
};

// A slice: the plane of v and t.
template <class F>
struct Slice {
    vec3<F> t;             // unit, orthogonal to v
    F across, down;        // pixels a metre along t
};

// The directions about v in which slices are turned.
template <class F>
struct Eye {
    vec3<F> p, v;               // world, m; unit, to the eye
    vec3<F> tangent, bitangent;
    F depth;                    // m
    F tan_x, tan_y;             // of the ray to p
};

template <class F>
PLUMB_INLINE vec3<F> vector_of(const float* m) {
    return {F(m[0]), F(m[1]), F(m[2])};
}

template <class F, class Tap>
PLUMB_INLINE Eye<F> eye_of(const HorizonInputsView& in, const vec4<F>& at, Tap& tap) {
    const HorizonUniforms& u = in.u;
    const F least(1e-37f);
    const vec3<F> p = xyz<F>(at);                                 tap("p", p, "world, m");
    const vec3<F> w{p.x - F(u.anchor[0]), p.y - F(u.anchor[1]), p.z - F(u.anchor[2])};
    const F inverse = F(-1.0f) / sqrt(max(dot3(w, w), least));
    const vec3<F> v{w.x * inverse, w.y * inverse, w.z * inverse}; tap("v", v, "unit, to the eye");
    const vec3<F> right = vector_of<F>(u.right), down = vector_of<F>(u.down);
    const F along = dot3(right, v);
    const vec3<F> t{right.x - v.x * along, right.y - v.y * along, right.z - v.z * along};
    const F scale = F(1.0f) / sqrt(max(dot3(t, t), least));
    const vec3<F> tangent{t.x * scale, t.y * scale, t.z * scale};
    const vec3<F> bitangent{v.y * tangent.z - v.z * tangent.y, v.z * tangent.x - v.x * tangent.z,
                            v.x * tangent.y - v.y * tangent.x};
    const F depth = max(row_of(u.forward, w), F(u.anchor[3]));
    return {p, v, tangent, bitangent, depth, dot3(right, w) / depth, dot3(down, w) / depth};
}

template <class F, class Tap>
PLUMB_INLINE Slice<F> slice_of(const HorizonInputsView& in, const Eye<F>& e, index_t<F> turn, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const HorizonUniforms& u = in.u;
    const F x = N::fetch(in.turns, turn + turn), y = N::fetch(in.turns, turn + turn + I(1));
    const vec3<F> t{e.tangent.x * x + e.bitangent.x * y, e.tangent.y * x + e.bitangent.y * y,
                    e.tangent.z * x + e.bitangent.z * y};
    tap("t", t, "unit, in the slice, orthogonal to v");
    // How (right . p) / depth and (down . p) / depth change along t.
    const F forward = dot3(vector_of<F>(u.forward), t);
    const F across = F(u.right[3]) * (dot3(vector_of<F>(u.right), t) - forward * e.tan_x) / e.depth;
    const F down = F(u.down[3]) * (dot3(vector_of<F>(u.down), t) - forward * e.tan_y) / e.depth;
    tap("pixels", vec2<F>{across, down}, "of 1 m along t");
    return {t, across, down};
}

// The largest cosine to v of what lies within the radius to that side of p, above its plane; -1: nothing does.
template <class F, class Tap>
PLUMB_INLINE F horizon_of(const HorizonInputsView& in, const Eye<F>& e, const vec3<F>& n, const Slice<F>& slice,
                          index_t<F> px, index_t<F> py, float side, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const HorizonUniforms& u = in.u;
    // What is nearer to the eye spans more pixels.
    const F radius(u.radius), reach = F(side) * radius * e.depth / max(e.depth - radius, F(0.5f) * e.depth);
    const F low(-65536.0f), high(65536.0f), centre(0.5f);
    F highest(-1.0f);
    for (int k = 0; k < u.steps; ++k) {
        tap.sample(k);
        const F length = F(in.shares[k]) * reach;
        const F x = N::from_index(px) + centre + slice.across * length;
        const F y = N::from_index(py) + centre + slice.down * length;
        const ivec2<I> texel{raster::chosen(clamp(x, low, high)), raster::chosen(clamp(y, low, high))};
        tap("texel", texel, "of the image");
        const mask_t<F> inside = in_range(texel.x, I(u.width)) & in_range(texel.y, I(u.height));
        const vec4<F> q = N::fetch4(in.position, select(inside, texel.y * I(u.width) + texel.x, I(0)));
        const vec3<F> d{q.x - e.p.x, q.y - e.p.y, q.z - e.p.z};
        const F d2 = dot3(d, d);                                  tap("d2", d2, "|q - p|^2, m2");
        const F rise = dot3(d, n);                                tap("rise", rise, "n.(q - p), m");
        const mask_t<F> within = inside & (q.w > F(0.0f)) & (rise > F(u.bias)) & (d2 <= radius * radius);
        tap("within", within, "1 if something is there, within the radius, that rises by more than the bias");
        const F cosine = dot3(d, e.v) / sqrt(max(d2, F(1e-37f)));
        highest = select(within, max(highest, cosine), highest);
        tap("highest", highest, "cosine of the horizon so far");
    }
    tap.sample(-1);
    return highest;
}

// a(h) of the horizon with that cosine to v, on one side (1 or -1). It is held above the plane of p, where 2 h - g is
// g + pi or g - pi; else cos(2 h - g) follows from the cosine of h.
template <class F, class Tap>
PLUMB_INLINE F arc(F highest, float side, F g, F cos_g, F sin_g, Tap& tap) {
    const F zero(0.0f), one(1.0f), cosine = clamp(highest, -one, one);
    const F angle = F(side) * detmath::acos(cosine), limit = g + F(side) * F(1.57079637f);
    const mask_t<F> below = side > 0 ? angle > limit : angle < limit;
    const F sine = F(side) * sqrt(max(zero, one - cosine * cosine));
    const F cos_2h = (cosine + cosine) * cosine - one, sin_2h = (cosine + cosine) * sine;
    const F turned = select(below, -cos_g, cos_2h * cos_g + sin_2h * sin_g);
    const F h = select(below, limit, angle);                      tap("h", h, "the horizon's angle from v");
    return F(0.25f) * (cos_g - turned + (h + h) * sin_g);
}

template <class F, class Tap>
PLUMB_INLINE F open_share(const HorizonInputsView& in, const Eye<F>& e, const vec3<F>& n, index_t<F> turn, index_t<F> px,
                          index_t<F> py, Tap& tap) {
    const F zero(0.0f), one(1.0f);
    const Slice<F> slice = slice_of<F>(in, e, turn, tap);
    const F ahead = horizon_of<F>(in, e, n, slice, px, py, 1.0f, tap);
    const F behind = horizon_of<F>(in, e, n, slice, px, py, -1.0f, tap);
    const F n_v = dot3(n, e.v), n_t = dot3(n, slice.t);
    const F length = sqrt(max(n_v * n_v + n_t * n_t, F(1e-37f))); tap("length", length, "|n'|");
    const F cos_g = clamp(n_v / length, -one, one), sin_g = clamp(n_t / length, -one, one);
    const F angle = detmath::acos(cos_g), g = select(n_t < zero, -angle, angle);
    tap("g", g, "angle of n' from v");
    const F second = arc(ahead, 1.0f, g, cos_g, sin_g, tap), first = arc(behind, -1.0f, g, cos_g, sin_g, tap);
    const F share = length * (first + second);
    tap("share", share, "|n'| (a(h_1) + a(h_2))");
    return share;
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> horizon(const HorizonInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const HorizonUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    const I pixel = py * I(u.width) + px;
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of p");
    const Eye<F> e = eye_of<F>(in, N::fetch4(in.position, pixel), tap);
    const mask_t<F> covered = dot3(n, n) > zero;
    const I turn = rotation_of<F>(px, py);
    F sum(0.0f);
    for (int i = 0; any(covered) && i < u.slices; ++i)
        sum += open_share<F>(in, e, n, turn * I(u.slices) + I(i), px, py, tap);
    const F open = clamp(sum / F(float(u.slices)), zero, one);    tap("open", open, "A");
    return {select(covered, open, zero), select(covered, one, zero), select(covered, open, zero),
            select(covered, one, zero)};
}

struct HorizonKernel {
    using View = HorizonInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return horizon<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.summed; }
};

}  // namespace plumb::screen
