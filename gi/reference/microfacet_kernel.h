// Rough metals and coated dielectrics of glTF 2.0, appendix B: microfacets of Trowbridge and Reitz's distribution (GGX,
// Walter et al. 2007, Microfacet models for refraction through rough surfaces). README.md, "Microfacets".
//
//     f = D V F + f_ms + (1 - metalness) f_d                                                                      1/sr
//     D = alpha^2/(pi ((N.H)^2 (alpha^2 - 1) + 1)^2),  V = G/(4 N.o N.i),  F = F0 + (1 - F0)(1 - H.o)^5
//     F0 = mix(0.04, base, metalness),  alpha = max(roughness^2, 1e-4)
//
// multiple: G is Smith's for heights that correlate (Heitz 2014, (99)); f_ms is what meets several facets (Kulla and Conty
// 2017), and f_d takes what a dielectric's surface lets through, in a form that is reciprocal (Ashikhmin and Shirley 2000):
//     f_ms = (1 - E(o))(1 - E(i))/(pi (1 - E_avg)) F_ms,  F_ms = F_avg^2 E_avg/(1 - F_avg (1 - E_avg))
//     f_d = base (1 - E_d(o))(1 - E_d(i))/(pi (1 - E_d,avg))
// single, as the appendix prints it: G is the product of both directions' own, f_ms = 0, f_d = base (1 - F(0.04))/pi.
//
// The appendix prints |N.o|: a direction to the viewer that lies below the horizon of a shading normal counts as mirrored
// to above it. A NaN in a direction or a material comes out as NaN.
#pragma once

#include "gi/reference/bsdf_kernel.h"
#include "gi/reference/microfacet_layout.h"

namespace plumb::reference {

struct MicrofacetArgs {
    const float* materials;  // [material][4]: metalness, roughness, row of `textures` (0: none), 1 where it has microfacets
    const float* cells;      // MicrofacetTables
    const float* rows;
    std::int32_t multiple;   // 1: light that meets several facets counts
};

// S and T at a cosine; microfacet_layout.h.
template <class F>
struct Losses {
    F lost, dark;
};

// A surface, seen along w_o.
template <class F>
struct Facets {
    mask_t<F> present;    // the rest is of no meaning where it is not
    vec3<F> base;
    F metalness, alpha;
    Basis<F> basis;
    vec3<F> w_o;          // in it, z >= 0
    F root_o;             // sqrt(alpha^2 + (1 - alpha^2) N.o^2)
    index_t<F> cell;      // first of the table's row below alpha
    F beyond;             // and how far to the next row, 0..1
    Losses<F> losses;     // at w_o
    vec3<F> f0, again;    // again: F_ms/alpha^2
    F share;              // of the samples, by visible normals; the rest by the cosine
};

template <class F>
PLUMB_INLINE F schlick_weight(F cosine) {
    const F u = max(1.0f - cosine, F(0.0f)), u2 = u * u;
    return u2 * u2 * u;
}

// Smith's function: 1/(1 + Lambda) = 2 cosine/(cosine + smith_root).
template <class F>
PLUMB_INLINE F smith_root(F alpha2, F cosine) {
    return sqrt(alpha2 + (1.0f - alpha2) * (cosine * cosine));
}

// F_ms of the file's head, for the mean F0 + (1 - F0)/21 of Schlick's function.
template <class F>
PLUMB_INLINE F fresnel_again(F f0, F e_avg) {
    const F mean = f0 + (1.0f - f0) * (1.0f / 21.0f);
    return mean * mean * e_avg / (1.0f - mean * (1.0f - e_avg));
}

// Linear between four corners; beyond the last column, to which rounding leads, it goes on.
template <class F>
PLUMB_INLINE Losses<F> losses_at(const MicrofacetArgs& in, index_t<F> cell, F beyond, F cosine) {
    using N = number<F>;
    using I = index_t<F>;
    const F x = sqrt(sqrt(cosine)) * F(float(microfacet_columns - 1));
    // A NaN's index is any: it stays in the fraction.
    const I column = min(max(N::truncate_to_index(x), I(0)), I(microfacet_columns - 2));
    const F t = x - N::from_index(column);
    const vec4<F> a = N::fetch4(in.cells, cell + column), b = N::fetch4(in.cells, cell + column + I(microfacet_columns));
    const F lost_a = a.x + (a.z - a.x) * t, lost_b = b.x + (b.z - b.x) * t;
    const F dark_a = a.y + (a.w - a.y) * t, dark_b = b.y + (b.w - b.y) * t;
    return {lost_a + (lost_b - lost_a) * beyond, dark_a + (dark_b - dark_a) * beyond};
}

template <class F>
PLUMB_INLINE Facets<F> facets_of(const MicrofacetArgs& in, const mask_t<F>& present, const vec3<F>& base, F metalness,
                                 F roughness, const vec3<F>& n, const vec3<F>& w_o) {
    using N = number<F>;
    using I = index_t<F>;
    const F one(1.0f), zero(0.0f);
    Facets<F> s;
    s.present = present, s.base = base, s.metalness = metalness;
    s.alpha = max(roughness * roughness, F(least_alpha));
    s.basis = basis_of<F>(n);
    s.w_o = {dot3(s.basis.tangent, w_o), dot3(s.basis.bitangent, w_o), abs(dot3(n, w_o))};
    const F alpha2 = s.alpha * s.alpha, dielectric = one - metalness;
    s.root_o = smith_root(alpha2, s.w_o.z);

    // The table's row.
    const F y = (sqrt(sqrt(s.alpha)) - first_row_root) * F((microfacet_rows - 1) / (1 - first_row_root));
    const I row = min(max(N::truncate_to_index(y), I(0)), I(microfacet_rows - 2));
    s.cell = row * I(microfacet_columns);
    s.beyond = y - N::from_index(row);
    const vec4<F> scales = N::fetch4(in.rows, row);
    const F a = scales.x + (scales.z - scales.x) * s.beyond, b = scales.y + (scales.w - scales.y) * s.beyond;
    s.losses = losses_at<F>(in, s.cell, s.beyond, s.w_o.z);

    const F e_avg = one - alpha2 * (a * a) * one_over_pi, coat = dielectric * fresnel_again(F(dielectric_f0), e_avg);
    const vec3<F> again{coat + metalness * fresnel_again(base.x, e_avg), coat + metalness * fresnel_again(base.y, e_avg),
                        coat + metalness * fresnel_again(base.z, e_avg)};
    s.again = again * (one / alpha2);
    const F floor = dielectric * dielectric_f0;
    s.f0 = {floor + metalness * base.x, floor + metalness * base.y, floor + metalness * base.z};

    // What each way of sampling is to find, about.
    const F lost = s.losses.lost * a, f0 = largest(s.f0), below = dielectric * largest(base);
    const F facing = max((f0 + (one - f0) * schlick_weight(s.w_o.z)) * (one - lost), F(1e-3f));
    const F rest = in.multiple ? below * (s.losses.dark * b) + largest(again) * lost : below;
    s.share = facing / (facing + max(rest, zero));
    return s;
}

// As scatter() of bsdf_kernel.h.
template <class F>
PLUMB_INLINE Scattering<F> scatter_facets(const MicrofacetArgs& in, const Facets<F>& s, const vec3<F>& w_i) {
    const F zero(0.0f), one(1.0f), alpha2 = s.alpha * s.alpha;
    const vec3<F> i{dot3(s.basis.tangent, w_i), dot3(s.basis.bitangent, w_i), dot3(s.basis.normal, w_i)};
    const F mu_o = s.w_o.z, mu_i = max(i.z, zero);

    // |o + i| is 2 H.o. Of a narrow lobe N.H is too near to 1 for a float: so x and y say how far off N it is.
    const vec3<F> sum{s.w_o.x + i.x, s.w_o.y + i.y, s.w_o.z + i.z};
    const F length2 = max(dot3(sum, sum), F(1e-30f)), length = sqrt(length2);
    const F off = (sum.x * sum.x + sum.y * sum.y) / length2, up = sum.z * sum.z / length2;
    const F bulge = max(off + alpha2 * up, 0.5f * alpha2);
    const F d = alpha2 * one_over_pi / (bulge * bulge);
    const F w = schlick_weight(0.5f * length);

    const F root_i = smith_root(alpha2, mu_i);
    const F density = d / (2.0f * (mu_o + s.root_o));
    const F pdf = s.share * select(sum.z > zero, density, sum.z * zero) + (one - s.share) * (mu_i * one_over_pi);
    F visible, below;
    if (in.multiple) {
        visible = 0.5f / max(mu_o * root_i + mu_i * s.root_o, F(1e-30f));
        const Losses<F> l = losses_at<F>(in, s.cell, s.beyond, mu_i);
        const F again = s.losses.lost * l.lost;
        below = (one - s.metalness) * (s.losses.dark * l.dark);
        const F facing = d * visible;
        const vec3<F> f{facing * (s.f0.x + (one - s.f0.x) * w) + s.again.x * again + s.base.x * below,
                        facing * (s.f0.y + (one - s.f0.y) * w) + s.again.y * again + s.base.y * below,
                        facing * (s.f0.z + (one - s.f0.z) * w) + s.again.z * again + s.base.z * below};
        return {f * mu_i, pdf};
    }
    visible = one / ((mu_o + s.root_o) * (mu_i + root_i));
    below = (one - s.metalness) * ((one - (dielectric_f0 + (one - dielectric_f0) * w)) * one_over_pi);
    const F facing = d * visible;
    const vec3<F> f{facing * (s.f0.x + (one - s.f0.x) * w) + s.base.x * below,
                    facing * (s.f0.y + (one - s.f0.y) * w) + s.base.y * below,
                    facing * (s.f0.z + (one - s.f0.z) * w) + s.base.z * below};
    return {f * mu_i, pdf};
}

// A normal that w_o sees, in the basis: Heitz 2018, Sampling the GGX distribution of visible normals.
template <class F>
PLUMB_INLINE vec3<F> visible_normal(const vec3<F>& w_o, F alpha, F u1, F u2) {
    const F zero(0.0f), one(1.0f);
    // The ellipsoid becomes a hemisphere.
    const vec3<F> v = normalize3<F>(vec3<F>{alpha * w_o.x, alpha * w_o.y, w_o.z});
    const F across2 = v.x * v.x + v.y * v.y;
    const mask_t<F> upright = across2 <= F(1e-30f);
    const F inverse = one / sqrt(max(across2, F(1e-30f)));
    const vec3<F> t1{select(upright, one, -v.y * inverse), select(upright, zero, v.x * inverse), zero};
    const vec3<F> t2{-v.z * t1.y, v.z * t1.x, v.x * t1.y - v.y * t1.x};
    // A disc, of which what lies behind the terminator is squeezed.
    const vec2<F> p = on_circle<F>(u2) * sqrt(u1);
    const F lift = 0.5f * (one + v.z);
    const F y = (one - lift) * sqrt(max(one - p.x * p.x, zero)) + lift * p.y;
    const F z = sqrt(max(one - p.x * p.x - y * y, zero));
    const vec3<F> h = t1 * p.x + t2 * y + v * z;
    return normalize3<F>(vec3<F>{alpha * h.x, alpha * h.y, max(h.z, zero)});
}

// As sample() of bsdf_kernel.h.
template <class F>
PLUMB_INLINE BsdfSample<F> sample_facets(const MicrofacetArgs& in, const Facets<F>& s, F u_lobe, F u1, F u2) {
    const F zero(0.0f);
    const mask_t<F> facing = u_lobe < s.share;
    const vec3<F> h = visible_normal<F>(s.w_o, s.alpha, u1, u2);
    const vec3<F> local = select3<F>(facing, h * (2.0f * dot3(h, s.w_o)) - s.w_o, cosine_hemisphere(u1, u2));
    const vec3<F> direction = normalize3<F>(to_world<F>(s.basis, local));
    const Scattering<F> found = scatter_facets<F>(in, s, direction);
    const mask_t<F> lost = (dot3(s.basis.normal, direction) <= zero) | (found.pdf == zero);
    return {direction, select3<F>(lost, vec3<F>{zero, zero, zero}, found.value / found.pdf), found.pdf, zero < zero};
}

}  // namespace plumb::reference
