// Real spherical harmonics in kernels, to degree 7: core/sh.h's functions, signs and numbering, in a kernel's number type.
//
//     Y_lm(d) = p_lm(z) c_m(x, y)       c_m + i s_m = (x + i y)^m;  s_|m| for m < 0
//     p_mm = rise[m][m]                 p_lm = rise[l][m] (z p_{l-1,m} - fall[l][m] p_{l-2,m})
//
// core/sh.glsl is the twin of add_harmonic(), which computes one function; add_harmonics() computes all of them, with the
// same bits.
#pragma once

#include "core/number.h"

namespace plumb::sh {

// rise[l][m] at 8 l + m, then fall[l][m]: recurrence() of core/sh.h.
inline constexpr int kernel_degrees = 8, recurrence_size = 2 * kernel_degrees * kernel_degrees;

// sum + weight Y_lm(d). m: |m|; sine: whether m < 0.
template <class F>
PLUMB_INLINE F add_harmonic(const float* recurrence, index_t<F> l, index_t<F> m, mask_t<F> sine, const vec3<F>& d,
                            F weight, F sum) {
    using N = number<F>;
    using I = index_t<F>;
    // weight (x + i y)^m
    F c = weight, s(0.0f);
    for (int k = 0; k < kernel_degrees - 1; ++k) {
        const mask_t<F> turns = I(k) < m;
        const F next = c * d.x - s * d.y;
        s = select(turns, c * d.y + s * d.x, s);
        c = select(turns, next, c);
    }
    F p = N::fetch(recurrence, m * I(kernel_degrees + 1)), before(0.0f);
    for (int k = 1; k < kernel_degrees; ++k) {
        const mask_t<F> rises = (m < I(k)) & (I(k) <= l);
        const I at = I(kernel_degrees * k) + m;
        const F rise = N::fetch(recurrence, at), fall = N::fetch(recurrence + kernel_degrees * kernel_degrees, at);
        const F next = rise * (d.z * p - fall * before);
        before = select(rises, p, before);
        p = select(rises, next, p);
    }
    return sum + p * select(sine, s, c);
}

// Adds weight Y_j(d) to sums[j], j = l (l + 1) + m, for all degrees up to `degree`.
template <class F>
PLUMB_INLINE void add_harmonics(const float* recurrence, int degree, const vec3<F>& d, F weight, F* sums) {
    const float *rise = recurrence, *fall = recurrence + kernel_degrees * kernel_degrees;
    F c = weight, s(0.0f);
    for (int m = 0; m <= degree; ++m) {
        F p(rise[m * (kernel_degrees + 1)]), before(0.0f);
        for (int l = m; l <= degree; ++l) {
            if (l > m) {
                const int at = kernel_degrees * l + m;
                const F next = F(rise[at]) * (d.z * p - F(fall[at]) * before);
                before = p, p = next;
            }
            F* of_degree = sums + l * (l + 1);
            of_degree[m] = of_degree[m] + p * c;
            if (m > 0) of_degree[-m] = of_degree[-m] + p * s;
        }
        const F next = c * d.x - s * d.y;
        s = c * d.y + s * d.x, c = next;
    }
}

}  // namespace plumb::sh
