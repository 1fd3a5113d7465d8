// Indirect shadows of dynamic meshes, as spheres: the algorithm that indirect_shadow.comp mirrors line by line.
//
// A sphere of radius r whose centre lies d away, at an angle omega from the normal, hides of the cosine-weighted hemisphere
//
//     F = q cos omega                                                 q = (r / d)^2; all of it above the horizon
//     F = (psi - C s + q cos omega phi) / pi                          the horizon cuts it: s^2 = q - cos^2 omega > 0
//         C = sqrt(1 - q)    psi = atan2(s, C)    phi = atan2(s, -C cos omega)
//     F = 0                                                           all of it below
//
// (Lambert's integral over the boundary: an arc of the cone of angle 2 phi, and one of the horizon of angle 2 psi.) Within a sphere d is
// taken as r: F = (1 + n . D / r) / 2 there, continuous. Of several spheres
//
//     S  = 1 - prod_i (1 - F_i)                                       they hide independently of each other
//     E' = E (1 - S)                                                  `uniform`: light comes from everywhere alike
//     E' = max(0, E - pi S L)                                         L = sum F_i L_i / sum F_i
//     L_i = max(0, a + m b . w) - max(0, a' + m b' . w)               w towards the sphere, m = 2 (1 + C + C^2) / (3 (1 + C))
//
// with a + b . w the radiance that would arrive through the sphere, and a' + b' . w that which the object sends. m: the mean cosine of a
// whole sphere's directions with w, weighed by the cosine, for a normal along w.
//
// differs: not in IPR, whose future work this is (6.1).
#pragma once

#include "core/number.h"
#include "raster/project_kernel.h"

namespace plumb::probes {

inline constexpr int shadow_rows = 7;  // of a sphere

// The twin's uniform block (std140).
struct IndirectShadowUniforms {
    std::int32_t width, height;
    std::int32_t spheres;
    std::int32_t directional;  // 0: light comes from everywhere alike
};
static_assert(sizeof(IndirectShadowUniforms) == 16);

struct IndirectShadowView {
    IndirectShadowUniforms u;
    const float* position;        // [height][width][4]: xyz m
    const float* normal;          // [height][width][4]: xyz unit; w 1: a point
    const float* irradiance;      // [height][width][4]: E, W/m2
    const std::int32_t* id;       // [height][width][2]: object, triangle; -1, -1: nothing
    const std::int32_t* owner;    // [spheres][2]: first and last of the objects that the sphere stands for; it does not shade these
    const float* spheres;         // [spheres][7][4]: centre, radius, m; b and a of red, green, blue; b' and a' of the same, W/(m2 sr)
    float* shaded;                // out: [height][width][4]: E', W/m2; w as of E
};

// atan2(y, x), y >= 0: acos by Abramowitz and Stegun 4.4.46, to 2e-8, whose sqrt(1 - c) is taken as s / sqrt(1 + c).
template <class F>
PLUMB_INLINE F angle_of(F x, F y) {
    const F length = max(sqrt(x * x + y * y), F(1e-18f));
    const F c = min(abs(x) / length, F(1.0f)), s = y / length;
    F p = F(-0.0012624911f) * c + F(0.0066700901f);
    p = p * c + F(-0.0170881256f);
    p = p * c + F(0.0308918810f);
    p = p * c + F(-0.0501743046f);
    p = p * c + F(0.0889789874f);
    p = p * c + F(-0.2145988016f);
    p = p * c + F(1.5707963050f);
    const F angle = s / sqrt(F(1.0f) + c) * p;
    return select(x < F(0.0f), F(3.14159265f) - angle, angle);
}

// What a sphere hides, and where it is seen.
template <class F>
struct HiddenShare {
    F share;       // F, 0 to 1
    F cosine;      // C
    vec3<F> w;     // unit towards the centre; of length d / r within the sphere
};
template <class F, class Tap>
PLUMB_INLINE HiddenShare<F> hidden_share(const vec3<F>& x, const vec3<F>& n, const vec4<F>& sphere, Tap& tap) {
    const vec3<F> to{sphere.x - x.x, sphere.y - x.y, sphere.z - x.z};
    const F r2 = sphere.w * sphere.w, d2 = max(max(dot3(to, to), r2), F(1e-30f)), d = sqrt(d2);
    tap("d", d, "m, at least r");
    const vec3<F> w{to.x / d, to.y / d, to.z / d};
    const F q = r2 / d2;                                          tap("q", q, "(r / d)^2");
    const F cosine = dot3(n, w);                                  tap("cos_omega", cosine, "n . w");
    const F open = sqrt(max(F(1.0f) - q, F(0.0f)));               tap("C", open, "sqrt(1 - q)");
    const F whole = q * cosine, s2 = q - cosine * cosine;
    const mask_t<F> cut = s2 > F(0.0f);                           tap("cut", cut, "whether the horizon cuts it");
    F share = whole;
    if (any(cut)) {
        const F s = sqrt(select(cut, s2, F(0.0f)));               tap("s", s, "sqrt(q - cos^2 omega)");
        const F psi = angle_of<F>(open, s), phi = angle_of<F>(-(open * cosine), s);
        tap("psi", psi, "half of the horizon's arc, rad"), tap("phi", phi, "half of the cone's arc, rad");
        share = select(cut, (psi - open * s + whole * phi) * F(0.318309886f), whole);
    }
    return {clamp(share, F(0.0f), F(1.0f)), open, w};
}

// max(0, a + m b . w), the row b, a.
template <class F>
PLUMB_INLINE F radiance_along(const float* spheres, index_t<F> row, const vec3<F>& w, F m) {
    const vec4<F> l = number<F>::fetch4(spheres, row);
    const F sum = l.w + m * (l.x * w.x + l.y * w.y + l.z * w.z);
    return max(sum, F(0.0f));
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> indirect_shadow(const IndirectShadowView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const IndirectShadowUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec4<F> normal = N::fetch4(in.normal, pixel);
    const vec3<F> n = xyz<F>(normal);                             tap("n", n, "unit normal");
    const mask_t<F> point = normal.w > F(0.0f);
    const vec4<F> lit = N::fetch4(in.irradiance, pixel);
    const vec3<F> e = xyz<F>(lit);                                tap("E", e, "W/m2, without shadows of what moves");
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const I object = N::fetch(in.id, pixel * I(2));               tap("object", object, "-1: nothing is seen");
    F hidden(0.0f), total(0.0f);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int i = 0; i < u.spheres; ++i) {
        tap.sample(i);
        const I first = I(i * shadow_rows);
        const HiddenShare<F> h = hidden_share<F>(x, n, N::fetch4(in.spheres, first), tap);
        const mask_t<F> outside = (object < N::fetch(in.owner, I(2 * i))) | (N::fetch(in.owner, I(2 * i + 1)) < object), own = !outside;
        tap("own", own, "whether the surface is of what the sphere stands for");
        const F share = select(point & !own, h.share, F(0.0f));   tap("F", share, "hidden share of the hemisphere; 0 of a surface of its own");
        const mask_t<F> hides = share > F(0.0f);
        if (!any(hides)) continue;
        hidden = hidden + share * (F(1.0f) - hidden);
        if (u.directional == 0) continue;
        total = total + share;
        const F m = F(0.666666667f) * (F(1.0f) + h.cosine + h.cosine * h.cosine) / (F(1.0f) + h.cosine);
        tap("m", m, "mean cosine of the sphere's directions with w");
        const vec3<F> l{radiance_along<F>(in.spheres, first + I(1), h.w, m) - radiance_along<F>(in.spheres, first + I(4), h.w, m),
                        radiance_along<F>(in.spheres, first + I(2), h.w, m) - radiance_along<F>(in.spheres, first + I(5), h.w, m),
                        radiance_along<F>(in.spheres, first + I(3), h.w, m) - radiance_along<F>(in.spheres, first + I(6), h.w, m)};
        tap("L", l, "that it hides less what it sends, W/(m2 sr)");
        sum = {sum.x + share * l.x, sum.y + share * l.y, sum.z + share * l.z};
    }
    tap.sample(-1);
    tap("S", hidden, "1 - prod (1 - F)");
    vec3<F> left{e.x - e.x * hidden, e.y - e.y * hidden, e.z - e.z * hidden};
    if (u.directional != 0) {
        const F scale = F(3.14159265f) * hidden / select(total > F(0.0f), total, F(1.0f));
        tap("scale", scale, "pi S / sum F");
        left = {max(e.x - scale * sum.x, F(0.0f)), max(e.y - scale * sum.y, F(0.0f)), max(e.z - scale * sum.z, F(0.0f))};
    }
    const mask_t<F> changed = hidden > F(0.0f);
    const vec3<F> shaded = select3<F>(changed, left, e);
    tap("shaded", shaded, "E', W/m2");
    return vec4<F>(shaded, lit.w);
}

struct IndirectShadowKernel {
    using View = IndirectShadowView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return indirect_shadow<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.shaded; }
};

}  // namespace plumb::probes
