// The logarithmic blur of a light's depth map, one direction of it (ISR 4.6, after Salvi 2008): the algorithm that
// log_blur.comp mirrors line by line.
//
//     d' = log(sum_i w_i exp(c d_i) / sum_i w_i) / c
//        = d_ref + log(sum_i w_i exp(c (d_i - d_ref)) / sum_i w_i) / c
//
// along 2 radius + 1 texels of a row or a column, those left out where nothing is drawn. d_ref is the deepest of them: then no exponent is above 0 and nothing
// overflows, whatever c and depth; and its own term is w_ref exp(0), so that the sum is not 0 either.
//
// Where c (d_i - d_ref) is small, exp(..) has lost it beside 1. There the mean of exp(..) - 1 is summed, and its log1p
// taken by a series: a map whose depths differ little is blurred to the last place.
#pragma once

#include "core/detmath.h"
#include "core/number.h"

namespace plumb::direct {

inline constexpr int most_blur_radius = 32;

// The twin's uniform block (std140).
struct LogBlurUniforms {
    std::int32_t width, height;
    std::int32_t radius;    // texels
    std::int32_t vertical;  // 0: along rows, 1: along columns
    float c;                // 1/m
    std::int32_t padding[3];
};
static_assert(sizeof(LogBlurUniforms) == 32);

// Images are [height][width] rgba32f.
struct LogBlurInputsView {
    LogBlurUniforms u;
    const float* depth_map;     // w linear depth, m; 0 where nothing is
    const float* spatial;       // [2 radius + 1], each at least 2^-100
    float* blurred;             // out: w linear depth, m; 0 where no tap has anything
};

// What the map holds k - radius texels further along the row or the column; the border's texel stands in for what lies
// beyond it.
template <class F>
PLUMB_INLINE F stored_depth(const LogBlurInputsView& in, index_t<F> px, index_t<F> py, int k) {
    using I = index_t<F>;
    const I along(k - in.u.radius);
    const I x = in.u.vertical != 0 ? px : min(max(px + along, I(0)), I(in.u.width - 1));
    const I y = in.u.vertical != 0 ? min(max(py + along, I(0)), I(in.u.height - 1)) : py;
    return number<F>::fetch4(in.depth_map, y * I(in.u.width) + x).w;
}

// log(1 + m) for -1/4 <= m <= 0: 2 artanh(s), s = m / (2 + m), |s| <= 1/7; to 2^-31.
template <class F>
PLUMB_INLINE F log_near_one(F m) {
    const F s = m / (F(2.0f) + m), t = s * s;
    const F tail = t * (0.333333343f + t * (0.2f + t * (0.142857149f + t * 0.111111112f)));
    return (s + s * tail) * F(2.0f);
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> log_blur(const LogBlurInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    const LogBlurUniforms& u = in.u;
    const int last = u.radius + u.radius;

    // Find the deepest texel, and the nearest.
    F d_ref(0.0f), nearest(3e38f);
    for (int k = 0; k <= last; ++k) {
        const F d_i = stored_depth<F>(in, px, py, k);
        d_ref = max(d_ref, d_i);
        nearest = min(nearest, select(d_i > F(0.0f), d_i, nearest));
    }
    tap("d_ref", d_ref, "the deepest of the taps, m");

    F sum(0.0f), less(0.0f), total(0.0f);
    for (int k = 0; k <= last; ++k) {
        tap.sample(k);
        const F d_i = stored_depth<F>(in, px, py, k);           tap("d_i", d_i, "linear depth, m; 0 where nothing is");
        const F exponent = F(u.c) * (d_i - d_ref);              tap("exponent", exponent, "c (d_i - d_ref), at most 0");
        const F weight = select(d_i > F(0.0f), F(in.spatial[k]), F(0.0f));
        tap("weight", weight, "Gaussian; 0 where nothing is");
        sum += weight * detmath::exp(exponent);                 tap("sum", sum, "of w_i exp(c (d_i - d_ref)) so far");
        less += weight * detmath::expm1(exponent);
        total += weight;
    }
    tap.sample(-1);
    const F divisor = max(total, F(0x1p-100f));                 // of at least one weight, or of none
    const F mean = sum / divisor;                               tap("mean", mean, "sum / sum of w_i");
    const F mean_less = less / divisor;
    tap("mean_less", mean_less, "mean - 1, to the last place");
    const F logarithm = select(mean_less >= F(-0.25f), log_near_one<F>(mean_less), detmath::log(mean));
    // Rounding leads to no depth that is not between those of the taps.
    const F d = max(nearest, d_ref + logarithm / F(u.c));
    const F depth = select(d_ref > F(0.0f), d, F(0.0f));
    tap("depth", depth, "d_ref + log(mean) / c, m; 0 where no tap has anything");
    const F zero(0.0f);
    return {zero, zero, zero, depth};
}

struct LogBlurKernel {
    using View = LogBlurInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return log_blur<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.blurred; }
};

}  // namespace plumb::direct
