// "All + rays" (VRSM fig. 5.1 d): the irradiance of gather_kernel.h over every texel of a light's maps, each as far as a
// shadow ray says that x sees x_p:
//
//     E(x, n) = sum_p V(x, x_p) Phi_p/pi max(0, n_p.(x - x_p)) max(0, n.(x_p - x)) / |x - x_p|^4         VRSM (3.2)
//
// Lanes are shading points and all of them ask for the same texel, so that the order of the sum is that of gather_all(),
// whatever the packet's width: where nothing is hidden the two agree to the bit.
#pragma once

#include "core/hash.h"
#include "gi/rsm/gather_kernel.h"
#include "gi/rsm/shadow_rays.h"

namespace plumb::rsm {

// Independent estimates whose spread is the standard error of a subset.
inline constexpr int replicates = 16;

// The lit texels of all maps of a light, one after the other, and where the sum pauses.
struct AllRaysView {
    const float* position;           // [height][width] rgba32f: xyz world, m
    const float* normal;             // [height][width] rgba32f: xyz unit; 0: no shading point
    const float* records;            // [lit] records: position, normal, flux W
    const std::int32_t* map_ends;    // [maps]: of each map, the end of its rows
    const std::int32_t* row_ends;    // [rows]: of each row, the end of its lit texels
    const std::int32_t* starts;      // [lit + 1], subset: where each texel's share of [0, 2^31) begins
    const std::int32_t* firsts;      // [strata + 1], subset: the texel that stratum k begins in
    float* irradiance;               // [height][width] rgba32f, out: W/m2
    float* standard_error;           // [height][width] rgba32f, out: W/m2; subset only
    float least_distance2;           // m2
    float scale;                     // 1/pi; published: 1
    std::int32_t width, height, maps;
    std::int32_t strata_log2;        // subset: strata of a replicate, one texel each; below 0: every texel
    std::uint32_t seed;
};

template <class F>
struct ShadingPoint {
    vec3<F> x, n;
    mask_t<F> wanted;  // lanes that hold a shading point
};

template <class F, class Tap>
PLUMB_INLINE ShadingPoint<F> shading_point(const AllRaysView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const mask_t<F> inside = in_range(px, I(in.width)) & in_range(py, I(in.height));
    const I pixel = min(py, I(in.height - 1)) * I(in.width) + min(px, I(in.width - 1));
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of x");
    const mask_t<F> wanted = inside & !(dot3(n, n) == F(0.0f));
    return {x, n, wanted};
}

// form() where x sees the texel, else 0. What is not a number stays so: no ray can hide it.
template <class F, class Tap>
PLUMB_INLINE F visible_form(const ShadingPoint<F>& at, const vec3<F>& x_p, const vec3<F>& n_p, F least_distance2,
                            ShadowRays<F>& rays, Tap& tap) {
    tap("x_p", x_p, "world, m");
    tap("n_p", n_p, "unit normal of x_p");
    const F g = form(at.x, at.n, x_p, n_p, least_distance2, tap);
    const mask_t<F> faces = at.wanted & !(g == F(0.0f));
    if (!any(faces)) return F(0.0f);
    const vec3<F> d = x_p - at.x;
    const mask_t<F> seen = rays.visible(at.x, at.n, x_p, n_p, dot3(d, d), faces);
    tap("visible", seen, "VRSM fig. 5.1 d: 1 if the ray from x meets nothing before x_p");
    return select(seen, g, F(0.0f));
}

// The complete sum: map by map, row by row.
template <class F, class Tap>
PLUMB_INLINE vec3<F> gather_all_rays(const AllRaysView& in, index_t<F> px, index_t<F> py, ShadowRays<F>& rays,
                                     Tap& tap) {
    const ShadingPoint<F> at = shading_point<F>(in, px, py, tap);
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    vec3<F> irradiance = zero;
    for (int map = 0, row = 0, texel = 0; any(at.wanted) && map < in.maps; ++map) {
        vec3<F> sum = zero;
        for (; row < in.map_ends[map]; ++row) {
            vec3<F> row_sum = zero;
            for (; texel < in.row_ends[row]; ++texel) {
                tap.sample(texel);
                const float* p = in.records + record_stride * std::ptrdiff_t(texel);
                const vec3<F> flux{F(p[8]), F(p[9]), F(p[10])};   tap("flux", flux, "Phi_p, W");
                const F g = visible_form<F>(at, {F(p[0]), F(p[1]), F(p[2])}, {F(p[4]), F(p[5]), F(p[6])},
                                            F(in.least_distance2), rays, tap);
                row_sum.x += flux.x * g;
                row_sum.y += flux.y * g;
                row_sum.z += flux.z * g;                          tap("row_sum", row_sum, "sum over this row of Phi_p form, W/m2");
            }
            sum.x += row_sum.x;
            sum.y += row_sum.y;
            sum.z += row_sum.z;                                   tap("sum", sum, "sum over the rows so far, W/m2");
        }
        const vec3<F> share = sum * F(in.scale);
        irradiance.x += share.x;
        irradiance.y += share.y;
        irradiance.z += share.z;
    }
    tap.sample(-1);                                               tap("irradiance", irradiance, "E = sum / pi, W/m2");
    return irradiance;
}

// The texel whose share of [0, 2^31) holds u, by bisection among those that meet stratum k.
template <class F>
PLUMB_INLINE index_t<F> texel_at(const AllRaysView& in, index_t<F> u, int k) {
    using I = index_t<F>;
    I low(in.firsts[k]), high(in.firsts[k + 1]);
    for (std::int32_t span = in.firsts[k + 1] - in.firsts[k]; span > 0; span >>= 1) {
        const I middle = low + ((high - low + I(1)) >> 1);
        const mask_t<F> reached = number<F>::fetch(in.starts, middle) <= u;
        low = select(reached, middle, low);
        high = select(reached, high, middle + I(-1));
    }
    return low;
}

template <class F>
struct SubsetEstimate {
    vec3<F> irradiance, standard_error;  // W/m2
};

// The standard error of the mean E of the estimates E_r: sqrt(sum (E_r - E)^2 / (R (R - 1))). Deviations are those from
// the first one, less their mean: estimates that are all the same have none, though their mean may round. They are
// divided by the largest, so that no square leaves the range of a float.
template <class F>
PLUMB_INLINE F standard_error_of_mean(const F (&estimates)[replicates]) {
    F deviations[replicates], mean(0.0f), largest(0.0f), squares(0.0f);
    for (int r = 0; r < replicates; ++r) {
        deviations[r] = estimates[r] - estimates[0];
        mean += deviations[r];
    }
    mean = mean * F(1.0f / replicates);
    for (F& d : deviations) {
        d = d - mean;
        largest = max(largest, abs(d));
    }
    const F scale = select(largest > F(0.0f), largest, F(1.0f));
    for (const F& d : deviations) squares += (d / scale) * (d / scale);
    return scale * sqrt(squares * F(1.0f / (replicates * (replicates - 1))));
}

// A subset: in each of `replicates` independent estimates one texel a stratum, with probability in proportion to its
// share of [0, 2^31). A texel of share s counts 2^31 / (s strata) times, so the mean is the complete sum; the standard
// error is that of the mean of the replicates.
template <class F, class Tap>
PLUMB_INLINE SubsetEstimate<F> gather_subset(const AllRaysView& in, index_t<F> px, index_t<F> py, ShadowRays<F>& rays,
                                             Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ShadingPoint<F> at = shading_point<F>(in, px, py, tap);
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    if (!any(at.wanted)) return {zero, zero};
    const int strata = 1 << in.strata_log2;
    const F per_share(0x1p31f / float(strata));
    F estimates[3][replicates];
    vec3<F> mean = zero;
    for (int r = 0; r < replicates; ++r) {
        vec3<F> sum = zero;
        for (int k = 0; k < strata; ++k) {
            const int sample = r * strata + k;                    tap.sample(sample);
            const I hash = pixel_hash(px, py, I(sample), I(std::int32_t(in.seed))).x;
            const I u = I(k << (31 - in.strata_log2)) + shift_right(shift_right(hash, 1), in.strata_log2);
            const I texel = texel_at<F>(in, u, k);                tap("texel", texel, "of the lit texels, along the curve");
            const Record<F> p = N::fetch_record(in.records, texel);
            const I share = N::fetch(in.starts, texel + I(1)) - N::fetch(in.starts, texel);
            const F weight = per_share / N::from_index(share);    tap("weight", weight, "1 / expected number of choices");
            const vec3<F> flux = xyz<F>(p.c);                     tap("flux", flux, "Phi_p, W");
            const F g = visible_form<F>(at, xyz<F>(p.a), xyz<F>(p.b), F(in.least_distance2), rays, tap) * weight;
            sum.x += flux.x * g;
            sum.y += flux.y * g;
            sum.z += flux.z * g;                                  tap("sum", sum, "of this replicate: weight Phi_p form, W/m2");
        }
        const vec3<F> estimate = sum * F(in.scale);
        estimates[0][r] = estimate.x, estimates[1][r] = estimate.y, estimates[2][r] = estimate.z;
        mean.x += estimate.x;
        mean.y += estimate.y;
        mean.z += estimate.z;
    }
    tap.sample(-1);
    mean = mean * F(1.0f / replicates);
    const vec3<F> error{standard_error_of_mean<F>(estimates[0]), standard_error_of_mean<F>(estimates[1]),
                        standard_error_of_mean<F>(estimates[2])};
    tap("standard_error", error, "sqrt(sum (E_r - E)^2 / (R (R - 1))), W/m2");
    tap("irradiance", mean, "E, mean of the replicates, W/m2");
    return {mean, error};
}

}  // namespace plumb::rsm
