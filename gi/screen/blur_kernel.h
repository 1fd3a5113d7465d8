// The mean over views, and a box of 4 x 4 pixels over it (LRA 6.2.3): the algorithm that blur.comp mirrors line by line.
//
// Every pixel of 4 x 4 has a rotation of its own. A box of even size has no middle: here it is the mean of the two of
// each axis that stand about the pixel, weights 1 2 2 2 1 over 8, in which each rotation has the same weight, and the
// result is not moved. Pixels without a surface have none.
//
// differs: the listing's box is -2..1, which moves the result by half a pixel, and takes in the background (`published`).
#pragma once

#include "gi/filter/weights_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct BlurUniforms {
    std::int32_t width, height;
    std::int32_t first, last;    // of the box, pixels; 0, 0: none
    std::int32_t published;
    std::int32_t edges;          // 1: weights stop at edges
    float sigma_depth, normal_slope, normal_offset;  // as gi/filter has them
    std::int32_t padding[3];
};
static_assert(sizeof(BlurUniforms) == 48);

struct BlurInputsView {
    BlurUniforms u;
    const float* summed;    // [height][width] rgba32f: as screen.ssao makes it
    const float* position;  // xyz world, m; w linear depth, m
    const float* normal;
    float* open;            // out: [height][width] rgba32f
};

// How open a pixel is by all views: LRA 4.3.2; where no view has a weight, by the receivers' own.
template <class F>
PLUMB_INLINE F mean_of(const vec4<F>& summed) {
    const mask_t<F> weighed = summed.y > F(0.0f);
    return select(weighed, summed.x / select(weighed, summed.y, F(1.0f)), summed.z);
}

// 1 2 2 2 1, over 8.
template <class F>
PLUMB_INLINE F box_weight(int at) {
    return F(at == -2 || at == 2 ? 0.125f : 0.25f);
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> blur(const BlurInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const BlurUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    const I pixel = py * I(u.width) + px;
    const vec4<F> summed = N::fetch4(in.summed, pixel);
    const F own = mean_of<F>(summed);                             tap("own", own, "LRA 4.3.2: sum w o / sum w");
    const mask_t<F> covered = summed.w > zero;
    const vec4<F> x = N::fetch4(in.position, pixel);
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));
    const filter::Centre<F> centre = filter::centre_of(xyz<F>(x), x.w, n, u.sigma_depth, u.normal_slope);
    F sum(0.0f), total(0.0f);
    const int side = u.last - u.first + 1;
    for (int k = 0; any(covered) && k < side * side; ++k) {
        tap.sample(k);
        const int dx = u.first + k % side, dy = u.first + k / side;
        const I at_x = min(max(px + I(dx), I(0)), I(u.width - 1)), at_y = min(max(py + I(dy), I(0)), I(u.height - 1));
        const mask_t<F> inside = (at_x == px + I(dx)) & (at_y == py + I(dy));
        const I at = at_y * I(u.width) + at_x;
        const vec4<F> other = N::fetch4(in.summed, at);
        F weight = u.published != 0 ? one : box_weight<F>(dx) * box_weight<F>(dy);
        if (u.edges != 0) {
            const vec4<F> x_i = N::fetch4(in.position, at);
            const vec3<F> n_i = xyz<F>(N::fetch4(in.normal, at));
            const F of_depth = filter::depth_weight(true, centre, filter::Texel<F>{{}, x_i.w, n_i, xyz<F>(x_i)}, tap);
            const F of_normal = filter::normal_weight(centre, n_i, u.normal_offset, tap);
            weight = weight * of_depth * of_normal;
        }
        if (u.published == 0) weight = select(inside & (other.w > zero), weight, zero);
        tap("weight", weight, "of this pixel");
        sum += weight * mean_of<F>(other);
        total += weight;
    }
    tap.sample(-1);
    const mask_t<F> weighed = total > zero;
    const F mean = select(weighed, sum / select(weighed, total, one), own);
    const F open = select(covered, mean, zero);                   tap("open", open, "sum / total; 0 where nothing is");
    return {open, open, open, select(covered, one, zero)};
}

struct BlurKernel {
    using View = BlurInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return blur<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.open; }
};

}  // namespace plumb::screen
