// Reflections in what a view sees, the camera's G-buffer or a light's map (LRA 4.2.4, 6.2.4; 4.3.1, 6.3.1): the algorithm
// that reflect.comp mirrors line by line.
//
// The mirrored ray leaves the surface point p. Steps of one length follow it until it passes behind what the view sees,
// and halved steps then go back and forth to where it does:
//
//     x_i = p + i s r,    b_i = d(x_i) - d(q_i)       q_i: what the view sees where x_i falls            Algorithm 1
//     hit:  b_{i-1} < 0 <= b_i <= thickness
//
// d: linear depth in the view. A view that comes later is asked where the camera's found nothing; of the lights' maps the
// nearest hit stands.
//
// differs: Algorithm 1 never moves on, and its bisection moves the difference and not the point. The listings mirror the
// camera's position in place of v, take world z for depth, and ask neither whether the ray was before the surface a step
// ago nor whether it left the receiver (`published`, of the camera alone).
#pragma once

#include "gi/screen/mirrored_ray_kernel.h"
#include "gi/screen/sheet_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct ReflectUniforms {
    SeenFrom view;
    float eye[4];             // xyz world, m: of the camera that sees the mirrors
    float step;               // s, m
    float thickness;          // m
    float bias;               // m
    std::int32_t steps, bisections;
    std::int32_t number;      // of the view: 1 the camera's, then its layers, then the lights' maps
    std::int32_t published;
    std::int32_t width, height;
    std::int32_t columns, rows;  // of a picture, where items are pixels of a sheet with drawn rays; 0: mirrored rays, one picture
    std::int32_t padding;
};
static_assert(sizeof(ReflectUniforms) == 144);

struct ReflectInputsView {
    ReflectUniforms u;
    const float* position;      // [height][width], or [rows][columns] rgba32f: xyz world, m
    const float* normal;        // as large, rgba32f: xyz unit; all 0: no surface
    const float* mirror;        // as large, rgba32f: xyz reflectance; w 0: no mirror
    const float* map_position;  // [view.height][view.width] rgba32f: xyz world, m; w linear depth, m; 0: nothing
    const float* map_normal;    // [view.height][view.width] rgba32f: xyz unit, towards the view
    const float* before;        // [height][width] rgba32f: what earlier views found; null: nothing
    const float* rays;          // [height][width] rgba32f: as screen.lobe writes them, where rows > 0
    float* hit;                 // out: [height][width] rgba32f: xy texel, z distance along the ray, m; w the view's number; 0: none
};

// The ray's point at a distance, and what the view sees there.
template <class F>
struct Passed {
    ivec2<index_t<F>> texel;  // of the view
    index_t<F> at;            // the same row by row; 0 outside
    F behind;                 // b, m
    mask_t<F> inside, known;  // the view has that texel, and a surface there
};

template <class F, class Tap>
PLUMB_INLINE Passed<F> passed_at(const ReflectInputsView& in, const MirroredRay<F>& ray, F t, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ReflectUniforms& u = in.u;
    const vec3<F> o = ray.from_anchor, r = ray.r;
    const Place<F> place = place_of<F>(u.view, {o.x + r.x * t, o.y + r.y * t, o.z + r.z * t}, tap);
    const I at = select(place.inside, place.texel.y * I(u.view.width) + place.texel.x, I(0)), first = at * I(4);
    const F depth = N::fetch(in.map_position, first + I(3));
    F behind = place.depth - depth;
    if (u.published != 0) behind = N::fetch(in.map_position, first + I(2)) - (ray.p.z + r.z * t);
    tap("behind", behind, "b = d(x) - d(q), m; as printed z(q) - z(x)");
    const mask_t<F> known = place.inside & (depth > F(0.0f));
    return {place.texel, at, behind, place.inside, known};
}

template <class F, class Tap>
PLUMB_INLINE mask_t<F> met_at(const ReflectInputsView& in, const MirroredRay<F>& ray, const Passed<F>& x, float bias, Tap& tap) {
    using N = number<F>;
    return may_be_met<F>(ray, xyz<F>(N::fetch4(in.map_position, x.at)), xyz<F>(N::fetch4(in.map_normal, x.at)), bias, tap);
}

// Algorithm 1, its outer loop.
template <class F, class Tap>
PLUMB_INLINE Crossing<F> march(const ReflectInputsView& in, const MirroredRay<F>& ray, mask_t<F> looking, Tap& tap) {
    const ReflectUniforms& u = in.u;
    const F zero(0.0f), thickness(u.thickness);
    const mask_t<F> nowhere = looking & !looking;
    Crossing<F> c{zero, {zero, zero}, zero, nowhere};
    mask_t<F> in_front = looking, entered = nowhere;  // the last point lay before what is seen; some point lay in the view
    for (int i = 1; any(looking) && i <= u.steps; ++i) {
        tap.sample(i);
        const F t = F(float(i)) * F(u.step);                      tap("t", t, "i s, m");
        const Passed<F> x = passed_at(in, ray, t, tap);
        const mask_t<F> behind = x.known & (x.behind >= zero);
        mask_t<F> crossed = looking & behind & in_front & (x.behind <= thickness);
        if (u.published != 0)
            crossed = looking & behind & (ray.r.z * F(u.step) + x.behind < thickness);
        else if (any(crossed))
            crossed = crossed & met_at(in, ray, x, u.bias, tap);
        tap("crossed", crossed, "b_{i-1} < 0 <= b_i <= thickness, and it may be met");
        take<F>(crossed, t, x.texel, x.behind, c);
        c.found = c.found | crossed;
        // A ray that has left the view does not come back.
        looking = looking & !crossed & (x.inside | !entered);
        entered = entered | x.inside;
        in_front = !behind;
    }
    tap.sample(-1);
    return c;
}

// Algorithm 1, its inner loop: the last point that lay behind what may be met, at any height above the mirror once a step
// has met it. Without asking again, rays that leave p beside what they meet would be halved back to the mirror itself.
template <class F, class Tap>
PLUMB_INLINE Crossing<F> bisected(const ReflectInputsView& in, const MirroredRay<F>& ray, Crossing<F> c, Tap& tap) {
    const ReflectUniforms& u = in.u;
    F t = c.t, length(u.step);
    mask_t<F> behind = c.found;
    for (int k = 0; any(c.found) && k < u.bisections; ++k) {
        tap.sample(u.steps + 1 + k);
        length = length * F(0.5f);
        t = select(behind, t - length, t + length);               tap("t", t, "m");
        const Passed<F> x = passed_at(in, ray, t, tap);
        behind = x.known & (x.behind >= F(0.0f));
        if (u.published == 0 && any(behind)) behind = behind & met_at(in, ray, x, 0.0f, tap);
        const mask_t<F> taken = u.published != 0 ? c.found : c.found & behind;
        take<F>(taken, t, x.texel, x.behind, c);
    }
    tap.sample(-1);
    return c;
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> reflect(const ReflectInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ReflectUniforms& u = in.u;
    const F zero(0.0f);
    const I item = py * I(u.width) + px, pixel = pixel_in_sheet<F>(px, py, u.columns, u.rows, u.width);
    const vec3<F> p = xyz<F>(N::fetch4(in.position, pixel));      tap("p", p, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of p");
    const vec3<F> eye{F(u.eye[0]), F(u.eye[1]), F(u.eye[2])}, to_p = from(u.eye, p);
    MirroredRay<F> ray = mirrored_ray<F>(p, n, u.published != 0 ? eye : to_p, u.view.anchor, tap);
    const vec4<F> none{zero, zero, zero, zero}, before = in.before ? N::fetch4(in.before, item) : none;
    const mask_t<F> leaves = u.published != 0 ? dot3(n, n) > zero : ray.cosine < zero;
    const mask_t<F> open = !(before.w == F(1.0f));
    mask_t<F> starts = leaves & (N::fetch4(in.mirror, pixel).w > zero);
    if (u.rows > 0) starts = take_drawn(in.rays ? N::fetch4(in.rays, item) : none, ray, tap);
    Crossing<F> c = bisected(in, ray, march<F>(in, ray, starts & open, tap), tap);
    if (u.published == 0) c.found = c.found & (c.behind <= F(u.thickness));
    return nearer_hit(before, c, u.number, tap);
}

struct ReflectKernel {
    using View = ReflectInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return reflect<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.hit; }
};

}  // namespace plumb::screen
