// What lamps send by way of a point: diffuse and specular light (HEM 4.4, 5.3, 5.4). Shared by vertices_kernel.h and
// pixels_kernel.h; shade.glsl is the twin, line by line.
//
//     I = C_a C_m + sum over lamps of C_l C_m max(0, N . L) + C_s C_l max(0, R . V)^n          HEM (4.28)
//     R = 2 (N . L) N - L          HEM (4.22), L towards the lamp
//
// with C_l = E / pi, E the lamp's irradiance across its rays: I is radiance, and C_l that of a white surface that faces the lamp.
// Here are irradiances, W/m2: of diffuse light pi C_a + sum E max(0, N . L), and sum E max(0, R . V)^n.
//
// differs: the listings take R of L and of -L at once: gi/zbuffer/README.md, "Errata". The lobe is 0 where N . L <= 0.
#pragma once

#include "core/detmath.h"
#include "core/number.h"
#include "raster/arriving_kernel.h"
#include "raster/surface_kernel.h"

namespace plumb::zbuffer {

// What both stages ask (std140).
struct ShadeUniforms {
    std::int32_t lights;
    std::int32_t diffuse;    // 1: N . L counts
    std::int32_t specular;   // 1: the lobe does
    std::int32_t blinn;      // 1: of the half vector, 0: of the mirrored one
    std::int32_t published;  // 1: as the listings have it
    std::int32_t saturated;  // 1: colours end at 1
    std::int32_t materials, objects;  // how many there are
    float ambient[4];        // xyz: irradiance that is there without a lamp, W/m2
    float eye[4];            // xyz m
};
static_assert(sizeof(ShadeUniforms) == 64);

inline constexpr int lights_a_part = 32;

// What the listings multiply by the world matrix: rows of M M^T, for normals that were multiplied by M's inverse transpose,
// and of M.
template <class F>
struct WorldRows {
    vec3<F> normal[3], light[3];
};
template <class F>
PLUMB_INLINE WorldRows<F> fetch_world(const float* objects, index_t<F> object) {
    using N = number<F>;
    using I = index_t<F>;
    WorldRows<F> w;
    for (int k = 0; k < 3; ++k) {
        w.normal[k] = xyz<F>(N::fetch4(objects, object * I(6) + I(k)));
        w.light[k] = xyz<F>(N::fetch4(objects, object * I(6) + I(3 + k)));
    }
    return w;
}
template <class F>
PLUMB_INLINE vec3<F> turned(const vec3<F>* rows, const vec3<F>& v) {
    return raster::normalised(vec3<F>(dot3(rows[0], v), dot3(rows[1], v), dot3(rows[2], v)));
}

// The unit vector along d, whatever its length.
template <class F>
PLUMB_INLINE vec3<F> unit_along(const vec3<F>& d) {
    const F scale = F(1.0f) / max(raster::largest3(d), F(1e-37f));
    return raster::normalised(vec3<F>(d.x * scale, d.y * scale, d.z * scale));
}

// max(0, R . V)^n, of the half vector max(0, N . H)^n. n need not be a unit vector; n_l = n . l.
template <class F, class Tap>
PLUMB_INLINE F lobe_of(const ShadeUniforms& u, const vec3<F>& n, F n_l, const vec3<F>& l, const vec3<F>& v, F exponent, Tap& tap) {
    F cosine;
    if (u.blinn != 0) {
        const vec3<F> h = raster::normalised(vec3<F>(l.x + v.x, l.y + v.y, l.z + v.z));
        cosine = dot3(n, h);
    } else {
        // As printed 2 saturate(-L . N) N + L.
        const F away = select(n_l < F(0.0f), min(-n_l, F(1.0f)), F(0.0f));
        const F twice = F(2.0f) * (u.published != 0 ? away : n_l), sign(u.published != 0 ? 1.0f : -1.0f);
        const vec3<F> r = raster::normalised(vec3<F>(twice * n.x + sign * l.x, twice * n.y + sign * l.y, twice * n.z + sign * l.z));
        cosine = dot3(r, v);
    }
    cosine = clamp(cosine, F(0.0f), F(1.0f));                     tap("cosine", cosine, "R . V or N . H, 0 to 1");
    const F raised = detmath::pow(cosine, exponent);
    const mask_t<F> open = (n_l > F(0.0f)) | (F(float(u.published)) > F(0.0f));
    const F power = select(open & (cosine > F(0.0f)) & (raised > F(1e-30f)), raised, F(0.0f));
    tap("power", power, "HEM (4.24); 0 below 1e-30");
    return power;
}

template <class F>
struct Lit {
    vec3<F> diffuse, specular;  // W/m2
    template <class Each>
    void components(Each each) const {
        for (const vec3<F>& v : {diffuse, specular}) each(v.x), each(v.y), each(v.z), each(F(1.0f));
    }
};

template <class F>
PLUMB_INLINE vec3<F> added(const vec3<F>& a, const vec3<F>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

// Of all lamps, with what is there without one. They are summed in parts, so that a thousand cost no digits.
template <class F, class Tap>
PLUMB_INLINE Lit<F> lit_by(const ShadeUniforms& u, const raster::LightArgs* lights, const vec3<F>& x, const vec3<F>& n,
                           const vec3<F>& v, F exponent, const WorldRows<F>& world, Tap& tap) {
    const vec3<F> dark{F(0.0f), F(0.0f), F(0.0f)};
    Lit<F> sum{{F(u.ambient[0]), F(u.ambient[1]), F(u.ambient[2])}, dark};
    for (int first = 0; first < u.lights; first += lights_a_part) {
        Lit<F> part{dark, dark};
        for (int k = first; k < min(first + lights_a_part, u.lights); ++k) {
            tap.sample(k);
            const raster::Arriving<F> a = raster::arriving_from<F>(lights[k], x);
            vec3<F> l = a.direction;
            if (u.published != 0 && lights[k].directional > 0.0f) l = turned(world.light, l);
            tap("L", l, "towards the lamp, unit");
            const F n_l = dot3(n, l);
            const F facing = select(n_l > F(0.0f), n_l, F(0.0f));
            tap("facing", facing, "max(0, N . L), HEM (4.19)");
            if (u.diffuse != 0) {
                const vec3<F> e = a.irradiance * facing;          tap("E", e, "E max(0, N . L), W/m2");
                part.diffuse = added(part.diffuse, e);
            }
            if (u.specular != 0) {
                const vec3<F> e = a.irradiance * lobe_of<F>(u, n, n_l, l, v, exponent, tap);
                tap("E_lobe", e, "E max(0, R . V)^n, W/m2");
                part.specular = added(part.specular, e);
            }
        }
        sum = {added(sum.diffuse, part.diffuse), added(sum.specular, part.specular)};
    }
    tap.sample(-1);
    return sum;
}

// 1 over what a channel's colour exceeds 1 by; else 1. rho, k: C_m, C_s.
template <class F>
PLUMB_INLINE F saturating(F diffuse, F specular, F rho, F k) {
    const F colour = (rho * diffuse + k * specular) * F(0.318309886f);
    return F(1.0f) / max(F(1.0f), colour);
}

// The light, its specular part times C_s; where asked for, no brighter than its colour may be.
template <class F, class Tap>
PLUMB_INLINE Lit<F> coloured(const ShadeUniforms& u, const Lit<F>& lit, const vec3<F>& rho, const vec3<F>& k, Tap& tap) {
    vec3<F> scale{F(1.0f), F(1.0f), F(1.0f)};
    if (u.saturated != 0)
        scale = {saturating(lit.diffuse.x, lit.specular.x, rho.x, k.x), saturating(lit.diffuse.y, lit.specular.y, rho.y, k.y),
                 saturating(lit.diffuse.z, lit.specular.z, rho.z, k.z)};
    tap("scale", scale, "1 / max(1, colour); HDR: 1");
    const Lit<F> of{{lit.diffuse.x * scale.x, lit.diffuse.y * scale.y, lit.diffuse.z * scale.z},
                    {k.x * lit.specular.x * scale.x, k.y * lit.specular.y * scale.y, k.z * lit.specular.z * scale.z}};
    tap("diffuse", of.diffuse, "pi C_a + sum E max(0, N . L), W/m2");
    tap("specular", of.specular, "C_s sum E max(0, R . V)^n, W/m2");
    return of;
}

}  // namespace plumb::zbuffer
