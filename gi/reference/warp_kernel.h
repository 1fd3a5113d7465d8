// From uniform numbers in [0, 1) to directions and points of a triangle.
//
// What a path samples with, a packet at a time: its sines and cosines are short polynomials, good to 1e-7, where
// core/detmath.h would give the last bit at several times the cost. core/sequences.h has such maps in double.
#pragma once

#include <type_traits>

#include "core/detmath.h"
#include "core/number.h"

namespace plumb::reference {

inline constexpr float one_over_pi = 0.318309886f, one_over_two_pi = 0.159154943f;

// ---- Frames ---------------------------------------------------------------------------------------------------------

// tangent x bitangent = normal; all of unit length.
template <class F>
struct Basis {
    vec3<F> tangent, bitangent, normal;
};

// Duff et al. 2017, "Building an Orthonormal Basis, Revisited", of a unit vector n.
template <class F>
PLUMB_INLINE Basis<F> basis_of(const vec3<F>& n) {
    const F sign = select(n.z < F(0.0f), F(-1.0f), F(1.0f));
    const F a = F(-1.0f) / (sign + n.z), b = n.x * n.y * a;
    return {{F(1.0f) + sign * n.x * n.x * a, sign * b, -(sign * n.x)}, {b, sign + n.y * n.y * a, -n.y}, n};
}

template <class F>
PLUMB_INLINE vec3<F> to_world(const Basis<F>& basis, const vec3<F>& local) {
    return basis.tangent * local.x + basis.bitangent * local.y + basis.normal * local.z;
}

// ---- Sine and cosine ------------------------------------------------------------------------------------------------

// The cosine and sine of t pi/4, |t| <= 1. Minimax polynomials (Sollya's fpminimax): the cosine to 1.1e-9, the sine to
// 2.8e-8 of itself; what floats round comes on top.
template <class F>
PLUMB_INLINE vec2<F> eighth_turn(F t) {
    const F x = t * t;
    const F cosine =
        1.0f - x * (0.308425128f + x * (-0.0158542674f + x * (0.000325820176f + x * -3.46135539e-06f)));
    const F sine = t * (0.785398185f + x * (-0.0807456225f + x * (0.00249037519f + x * -3.61621242e-05f)));
    return {cosine, sine};
}

// The cosine and sine of 2 pi turn, 0 <= turn <= 1.
template <class F>
PLUMB_INLINE vec2<F> on_circle(F turn) {
    using I = index_t<F>;
    // 2^-n steps of the turn stay exact: four quarters, and what is left of one, between -1/2 and 1/2.
    const F quarters = turn * 4.0f;
    const I quarter = number<F>::round_to_index(quarters);
    const vec2<F> p = eighth_turn<F>((quarters - number<F>::from_index(quarter)) * 2.0f);
    const mask_t<F> swapped = (quarter & I(1)) == I(1);
    const mask_t<F> minus_sine = (quarter & I(2)) == I(2), minus_cosine = ((quarter + I(1)) & I(2)) == I(2);
    const F cosine = select(swapped, p.y, p.x), sine = select(swapped, p.x, p.y);
    return {select(minus_cosine, -cosine, cosine), select(minus_sine, -sine, sine)};
}

// ---- Directions about z ---------------------------------------------------------------------------------------------

// Density cos(theta) / pi: the concentric disc (Shirley and Chiu 1997), raised to the hemisphere (Malley).
template <class F>
PLUMB_INLINE vec3<F> cosine_hemisphere(F u1, F u2) {
    const F x = 2.0f * u1 - 1.0f, y = 2.0f * u2 - 1.0f;
    const mask_t<F> along_x = abs(x) > abs(y);
    const F radius = select(along_x, x, y), other = select(along_x, y, x);
    const vec2<F> p = eighth_turn<F>(other / select(radius == F(0.0f), F(1.0f), radius)) * radius;
    return {select(along_x, p.x, p.y), select(along_x, p.y, p.x), sqrt((1.0f - radius) * (1.0f + radius))};
}

// Density (n + 1) / (2 pi) cos(theta)^n, n >= 0: cos(theta) = (1 - u1)^(1 / (n + 1)). For a lobe of large n the steps of
// a cosine near 1 are coarse: so 1 - cos(theta) is computed for itself, from 2^v - 1 = v P(v), to 1.4e-8 of it.
template <class F>
PLUMB_INLINE vec3<F> cosine_power(F u1, F u2, F exponent) {
    const F rest = 1.0f - u1;
    F cosine, versine;
    if constexpr (std::is_same_v<F, double>) {
        cosine = detmath::pow(rest, 1.0 / (exponent + 1.0));
        versine = 1.0 - cosine;
    } else {
        using I = index_t<F>;
        const F v = detmath::log2_of(rest).hi / (exponent + 1.0f);
        const I k = number<F>::round_to_index(v);
        const F r = v - number<F>::from_index(k);
        const F m =
            r * (0.693147182f + r * (0.240226492f + r * (0.0555036627f +
            r * (0.00961832330f + r * (0.00133878936f + r * 0.000153767120f)))));
        cosine = detmath::power_of_two<F>(k) * (1.0f + m);
        versine = select(k == I(0), -m, 1.0f - cosine);
    }
    const vec2<F> p = on_circle<F>(u2) * sqrt(versine * (2.0f - versine));
    return {p.x, p.y, cosine};
}

// 1/sr; 0 on the far side.
template <class F>
PLUMB_INLINE F pdf_cosine_power(F cosine, F exponent) {
    const F power = detmath::pow(max(cosine, F(0.0f)), exponent);
    return select(cosine <= F(0.0f), F(0.0f), (exponent + 1.0f) * one_over_two_pi * power);
}

// ---- Triangles ------------------------------------------------------------------------------------------------------

// Barycentrics (l1, l2) of a point, uniform in area (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
template <class F>
PLUMB_INLINE vec2<F> uniform_triangle(F u1, F u2) {
    const mask_t<F> upper = u2 > u1;
    const F half = 0.5f * select(upper, u1, u2);
    return {select(upper, half, u1 - half), select(upper, u2 - half, half)};
}

}  // namespace plumb::reference
