// Choosing a light and a point or direction on it; the rows of lights.h.
#pragma once

#include "gi/reference/environment_kernel.h"
#include "gi/reference/warp_kernel.h"
#include "raster/light_kernel.h"
#include "raster/surface_kernel.h"

namespace plumb::reference {

// A row of 16 floats, by kind:
//     triangle     corner m, index of the triangle (its bits); edge m, 0; edge m, kind
//     lamp         position m, cosine of the outer angle; direction, scale of the falloff; intensity W/sr, kind;
//                  1 / radius^2 of a lamp that ends there, ISR (16), whose intensity is W/m2; else 0
//     directional  0; direction, 0; irradiance W/m2, kind
//     environment  0; 0; 0, kind
enum class LightKind : int { triangle, lamp, directional, environment };

struct LightArgs {
    std::int32_t count;
    std::int32_t steps;           // of the search: 2^steps >= count
    const float* rows;
    const float* cdf;             // [count + 1], multiples of 2^-24
    const float* triangle_pdf;    // [triangle]: 1/m2
    float environment_probability;
    std::int32_t any_radius = 0;  // 1: some lamp ends at its radius
};

template <class F>
struct ChosenLight {
    index_t<F> light;
    F probability;
    F rest;  // what u leaves for the choice of a point, in [0, 1)
};

// The light whose share of [0, 1) holds u: a binary search for the last entry of the table that is at most u. Its
// multiples of 2^-24 are what u is made of, so the probability is exact. A share of a few steps only leaves too little
// of u for anything else: another number, `fresh`, is passed on then.
template <class F>
PLUMB_INLINE ChosenLight<F> choose_light(const LightArgs& in, F u, F fresh) {
    using N = number<F>;
    using I = index_t<F>;
    I low(0), high(in.count);
    for (int step = 0; step < in.steps; ++step) {
        const I middle = shift_right(low + high, 1);
        const mask_t<F> above = N::fetch(in.cdf, middle) <= u;
        low = select(above, middle, low);
        high = select(above, high, middle);
    }
    const F first = N::fetch(in.cdf, low), probability = N::fetch(in.cdf, low + I(1)) - first;
    return {low, probability, select(probability > F(0x1p-8f), (u - first) / probability, fresh)};
}

// Where a shadow ray goes and what comes back along it when nothing is in between.
template <class F>
struct LightSample {
    vec3<F> target;      // m, a little off the light's own surface; or a direction where it is infinitely far
    mask_t<F> infinite;
    vec3<F> direction;   // unit, from x
    vec3<F> radiance;    // times the inverse of the density of points: W/m2 on a surface across the direction
    F pdf;               // 1/sr, with the probability of the light; 0 where no other ray can meet it
};

// Distance by which a ray starts off a surface whose triangle's corners have coordinates up to `extent`: 32 times the
// rounding of such a coordinate. README.md, "Where a ray starts".
template <class F>
PLUMB_INLINE F ray_offset(F extent) {
    return extent * F(0x1p-19f);
}

// Radiant exitance over pi of an emitting triangle's point: W/(m2 sr).
template <class F>
PLUMB_INLINE vec3<F> triangle_radiance(const raster::SurfaceArgs& in, index_t<F> triangle, const vec2<F>& l) {
    using N = number<F>;
    using I = index_t<F>;
    const raster::MaterialRow<F> m = raster::fetch_material<F>(in, N::fetch(in.material, triangle));
    vec3<F> exitance = xyz<F>(m.emission_cutoff);
    if (any((m.emission > I(0)) | (m.emission_cutoff.w > F(0.0f)))) {
        const raster::Corners<F> c = raster::fetch_corners<F>(in, triangle);
        const vec2<F> uv = raster::interpolate_uv<F>({c.a.p.w, c.a.n.w}, {c.b.p.w, c.b.n.w}, {c.c.p.w, c.c.n.w}, l);
        NoTap quiet;
        exitance = raster::times3(exitance, raster::sample<F>(in.textures, m.emission, uv, F(0.0f), false, quiet));
        const F solid = select(raster::passes_alpha<F>(in, triangle, l), F(1.0f), F(0.0f));
        exitance = exitance * solid;
    }
    return exitance * F(float(1 / 3.14159265358979323846));
}

// The part of a lamp's intensity that falls along `direction`, unit, towards the lamp, from the squared distance d2, 1/m2:
// smoothstep between its cones, and 1/d2 or, of a lamp that ends at its radius, 1 - (d/r)^2 (there it has no unit).
template <class F>
PLUMB_INLINE F lamp_falloff(const LightArgs& in, const Record<F>& row, index_t<F> light, const vec3<F>& direction, F d2, F inverse2) {
    using N = number<F>;
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f);
    const F t = clamp((-dot3(direction, xyz<F>(row.b)) - row.a.w) * row.b.w, zero, one);
    F attenuation = inverse2;
    if (in.any_radius) {
        const F inverse_radius2 = N::fetch(in.rows, light * I(16) + I(12));
        attenuation = select(inverse_radius2 > zero, max(zero, one - d2 * inverse_radius2), inverse2);
    }
    return t * t * (F(3.0f) - F(2.0f) * t) * attenuation;
}

// A point of the chosen light as x sees it.
template <class F>
PLUMB_INLINE LightSample<F> sample_light(const LightArgs& in, const raster::SurfaceArgs& surfaces,
                                         const EnvironmentArgs& environment, const ChosenLight<F>& chosen, F v,
                                         const vec3<F>& x) {
    using N = number<F>;
    using I = index_t<F>;
    const Record<F> row = N::fetch_record(in.rows, chosen.light);
    const F zero(0.0f), one(1.0f), kind = row.c.w;
    const mask_t<F> triangle = kind == F(0.0f), lamp = kind == F(1.0f), directional = kind == F(2.0f),
                    sky = kind == F(3.0f);
    LightSample<F> s;
    s.infinite = directional | sky;

    // A lamp: all of its light comes from one point.
    const vec3<F> axis = xyz<F>(row.b);
    vec3<F> y = xyz<F>(row.a);
    vec3<F> d = raster::minus3(y, x);
    const F d2 = dot3(d, d), inverse2 = one / max(d2, F(1e-37f));
    s.direction = d * sqrt(inverse2);
    const F falloff = lamp_falloff<F>(in, row, chosen.light, s.direction, d2, inverse2);
    s.radiance = xyz<F>(row.c) * (select(lamp, falloff, one) / chosen.probability);
    s.pdf = zero;

    // A triangle: the density per area, turned into one per solid angle.
    if (any(triangle)) {
        const vec2<F> l = uniform_triangle<F>(chosen.rest, v);
        const vec3<F> e1 = axis, e2 = xyz<F>(row.c), corner = xyz<F>(row.a);
        y = select3<F>(triangle, raster::interpolate3(corner, e1, e2, l), y);
        d = raster::minus3(y, x);
        const F distance2 = max(dot3(d, d), F(1e-37f));
        const vec3<F> w = d * (one / sqrt(distance2));
        const vec3<F> face = raster::face_normal(e1, e2);
        const vec3<F> n = face * (one / max(sqrt(dot3(face, face)), F(1e-30f)));
        const F cosine = abs(dot3(n, w));
        const I index = select(triangle, N::bits(row.a.w), I(0));
        const F pdf = N::fetch(in.triangle_pdf, index) * distance2 / max(cosine, F(1e-20f));
        const mask_t<F> seen = triangle & (cosine > zero);
        const vec3<F> radiance = triangle_radiance<F>(surfaces, index, l) * (one / max(pdf, F(1e-37f)));
        s.direction = select3<F>(triangle, w, s.direction);
        s.radiance = select3<F>(triangle, radiance * select(seen, one, zero), s.radiance);
        s.pdf = select(triangle, pdf, s.pdf);
        // The target lies on the side of the triangle that x sees.
        const F extent = max(raster::largest3(corner), max(raster::largest3(vec3<F>(corner + e1)),
                                                           raster::largest3(vec3<F>(corner + e2))));
        const F step = -raster::side_of(dot3(n, w)) * ray_offset(extent);
        y = select3<F>(triangle, vec3<F>(y + n * step), y);
    }
    s.direction = select3<F>(directional, vec3<F>(-axis.x, -axis.y, -axis.z), s.direction);
    if (any(sky)) {
        const EnvironmentSample<F> e = sample_environment<F>(environment, chosen.rest, v);
        const F pdf = e.pdf * chosen.probability;
        s.direction = select3<F>(sky, e.direction, s.direction);
        s.radiance = select3<F>(sky, e.radiance * (one / max(pdf, F(1e-37f))), s.radiance);
        s.pdf = select(sky, pdf, s.pdf);
    }
    s.target = select3<F>(s.infinite, s.direction, y);
    return s;
}

}  // namespace plumb::reference
