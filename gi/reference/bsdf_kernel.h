// How a surface scatters: a diffuse part, Phong's lobe and a perfect mirror.
//
//     f(w_o, w_i) = diffuse / pi + specular (n + 2)/(2 pi) max(0, r . w_i)^n      1/sr, Lafortune and Willems 1994, (4)
//
// and the mirror's delta, where r is w_o mirrored at the normal and all directions point away from the surface. f is
// reciprocal, because r . w_i = 2 (N.w_o)(N.w_i) - w_o.w_i is.
//
// Energy: of what arrives along w_o the lobe reflects `specular` at normal incidence, exactly, and less at all others,
// as N.w_i falls towards grazing (for large n it reflects specular N.w_o) and as that part of the lobe is lost
// which lies below the surface. Nothing is added to make up for it: diffuse + specular + mirror <= 1 conserves energy.
//
// A NaN in a direction or a reflectance comes out as NaN.
#pragma once

#include "gi/reference/warp_kernel.h"

namespace plumb::reference {

template <class F>
struct Bsdf {
    vec3<F> diffuse, specular;  // reflectances
    F exponent;                 // n of the lobe, 0..1e6
    vec3<F> mirror;             // reflectance
};

// The lobes' shares of the samples: in proportion to the largest channel of each one's reflectance. A black surface is
// sampled as a diffuse one.
template <class F>
struct LobeShares {
    F diffuse, specular, mirror;
};

// What a path needs for a direction that something else chose: f N.w_i, 1/sr, and the density with which sample() would
// have chosen it, 1/sr.
template <class F>
struct Scattering {
    vec3<F> value;
    F pdf;
};

template <class F>
struct BsdfSample {
    vec3<F> direction;  // unit, world
    vec3<F> weight;     // f N.w_i / pdf; of the mirror: its reflectance / share
    F pdf;              // 1/sr; of the mirror: 0
    mask_t<F> mirror;
};

template <class F>
PLUMB_INLINE F largest(const vec3<F>& v) {
    return max(max(v.x, v.y), v.z);
}
template <class F>
PLUMB_INLINE vec3<F> mirrored(const vec3<F>& n, const vec3<F>& w) {
    return n * (2.0f * dot3(n, w)) - w;
}

template <class F>
PLUMB_INLINE LobeShares<F> lobe_shares(const Bsdf<F>& bsdf) {
    const F diffuse = largest(bsdf.diffuse), specular = largest(bsdf.specular), mirror = largest(bsdf.mirror);
    const F sum = diffuse + specular + mirror;
    const mask_t<F> black = sum == F(0.0f);
    const F whole = select(black, F(1.0f), sum);
    return {select(black, F(1.0f), diffuse / whole), specular / whole, mirror / whole};
}

// max(0, a . b)^n of unit vectors. With n = 1e6 the lobe is 1e-3 wide, and there a . b is 1e-6 from 1, of which a float
// keeps one digit: so 1 - a . b is taken as |a - b|^2 / 2, which keeps three more, and the logarithm of the rest
// carries what a float cannot hold. Below 2^-100 it is 0: denormal numbers would cost a hundred cycles each.
template <class F>
PLUMB_INLINE F phong_lobe(const vec3<F>& a, const vec3<F>& b, F exponent) {
    const vec3<F> d = a - b;
    const F versine = 0.5f * dot3(d, d);
    mask_t<F> vanishes = versine >= F(1.0f);
    F power;
    if constexpr (std::is_same_v<F, double>) {
        power = detmath::pow(max(1.0 - versine, 0.0), exponent);
    } else {
        const detmath::FloatFloat<F> cosine = detmath::sum_ordered(F(1.0f), -versine);
        const detmath::FloatFloat<F> log2 = detmath::log2_of(cosine.hi);
        const F log2_lo = log2.lo + 1.44269502f * cosine.lo / cosine.hi;
        const detmath::FloatFloat<F> p = detmath::product(log2.hi, exponent);
        power = detmath::exp2_of<F>({max(p.hi, F(-100.0f)), p.lo + log2_lo * exponent});
        vanishes = vanishes | (p.hi < F(-100.0f));
    }
    return select(vanishes, F(0.0f), select(versine == versine, power, versine));
}

// ---- Everything -----------------------------------------------------------------------------------------------------

// Where w_o lies below the surface, as it may where a shading normal turns away from who looks at it, nothing is
// reflected; but what is diffuse alone looks the same from everywhere.
template <class F>
PLUMB_INLINE mask_t<F> hidden(const LobeShares<F>& share, const vec3<F>& n, const vec3<F>& w_o) {
    const mask_t<F> below = dot3(n, w_o) < F(0.0f), diffuse = share.diffuse == F(1.0f);
    return below & !diffuse;
}

// Both parts of a Scattering share the lobe. Its density is that of sample(), also below the surface, where the value
// is 0.
template <class F>
PLUMB_INLINE Scattering<F> scatter(const Bsdf<F>& bsdf, const vec3<F>& n, const vec3<F>& w_o, const vec3<F>& w_i) {
    const LobeShares<F> share = lobe_shares(bsdf);
    const F zero(0.0f), cosine = max(dot3(n, w_i), zero);
    vec3<F> f = bsdf.diffuse * F(one_over_pi);
    F pdf = share.diffuse * cosine * one_over_pi;

    // Most packets have no lobe; a lane without one would add 0.
    if (any(!(share.specular == zero))) {
        const F lobe = phong_lobe(mirrored(n, w_o), w_i, bsdf.exponent) * one_over_two_pi;
        f += bsdf.specular * ((bsdf.exponent + 2.0f) * lobe);
        pdf += share.specular * ((bsdf.exponent + 1.0f) * lobe);
    }
    return {f * select(hidden(share, n, w_o), zero, cosine), pdf};
}

// f N.w_i without the mirror, 1/sr; 0 where w_o or w_i lies below the surface, for w_o see hidden().
template <class F>
PLUMB_INLINE vec3<F> evaluate(const Bsdf<F>& bsdf, const vec3<F>& n, const vec3<F>& w_o, const vec3<F>& w_i) {
    return scatter(bsdf, n, w_o, w_i).value;
}

// The density of sample() without the mirror, 1/sr: over the sphere it integrates to 1 - the mirror's share.
template <class F>
PLUMB_INLINE F pdf(const Bsdf<F>& bsdf, const vec3<F>& n, const vec3<F>& w_o, const vec3<F>& w_i) {
    return scatter(bsdf, n, w_o, w_i).pdf;
}

// Chooses a lobe by u_lobe and a direction of it by u1 and u2. The weight is 0 where the direction lies below the
// surface, which the Phong lobe's may.
template <class F>
PLUMB_INLINE BsdfSample<F> sample(const Bsdf<F>& bsdf, const vec3<F>& n, const vec3<F>& w_o, F u_lobe, F u1, F u2) {
    const LobeShares<F> share = lobe_shares(bsdf);
    const F zero(0.0f);
    const vec3<F> r = mirrored(n, w_o), black{zero, zero, zero};
    // Shares are rounded and may sum to less than u_lobe: never is a lobe chosen that has none.
    const mask_t<F> mirror = u_lobe < share.mirror;
    const mask_t<F> phong = ((u_lobe < share.mirror + share.specular) | (share.diffuse == zero)) & !mirror;

    vec3<F> direction = to_world(basis_of(n), cosine_hemisphere(u1, u2));
    if (any(phong)) {
        const vec3<F> about_r = to_world(basis_of(r), cosine_power(u1, u2, bsdf.exponent));
        direction = select3<F>(phong, about_r, direction);
    }
    direction = select3<F>(mirror, r, direction);

    const Scattering<F> s = scatter(bsdf, n, w_o, direction);
    // On the rim of a lobe, too, rounding may leave no density to divide by.
    const F cosine_i = dot3(n, direction);
    const mask_t<F> unseen = hidden(share, n, w_o), lost = unseen | (cosine_i <= zero) | (s.pdf == zero);
    const vec3<F> weight = select3<F>(lost, black, s.value / s.pdf);
    const vec3<F> reflected = select3<F>(unseen, black, bsdf.mirror / share.mirror);
    return {direction, select3<F>(mirror, reflected, weight), select(mirror, zero, s.pdf), mirror};
}

// ---- Diffuse alone --------------------------------------------------------------------------------------------------
//
// For scenes that have nothing else; the normal is on the side of w_o.

template <class F>
PLUMB_INLINE F pdf_diffuse(const vec3<F>& n, const vec3<F>& w_i) {
    return max(dot3(n, w_i), F(0.0f)) * one_over_pi;
}

template <class F>
PLUMB_INLINE vec3<F> evaluate_diffuse(const vec3<F>& diffuse, const vec3<F>& n, const vec3<F>& w_i) {
    return diffuse * pdf_diffuse(n, w_i);
}

template <class F>
PLUMB_INLINE BsdfSample<F> sample_diffuse(const vec3<F>& diffuse, const vec3<F>& n, F u1, F u2) {
    const F zero(0.0f);
    const vec3<F> direction = to_world(basis_of(n), cosine_hemisphere(u1, u2));
    const F pdf = pdf_diffuse(n, direction);
    // On the horizon, where rounding may even put a direction below the surface, there is no density to divide by.
    const vec3<F> black{zero, zero, zero};
    return {direction, select3<F>(pdf == zero, black, diffuse), pdf, zero < zero};
}

}  // namespace plumb::reference
