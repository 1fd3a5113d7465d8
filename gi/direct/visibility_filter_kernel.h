// A filter of a light's shadows over the screen, along rows or columns (ISR 4.7): the algorithm that
// visibility_filter.comp mirrors line by line.
//
//     V' = sum_i w_i V_i / sum_i w_i,    i = -radius .. radius along a row or a column
//
//     gaussian    w_i = g_i where i has a surface, else 0; beyond the border there is none
//     edge_aware  w_i = g_i depth_weight_i normal_weight_i, as gi/filter weighs (weights_kernel.h), by the pixel's plane
//
// g is a Gaussian, 1 in the middle. The pixel itself has weight 1, whatever its normal's length: the table has 0 in its
// place, and the sums begin with it. Where all is lit both sums are made by the same additions: 1 stays 1, bit for bit.
// A pixel without a surface keeps what it has.
#pragma once

#include "core/number.h"
#include "gi/filter/weights_kernel.h"

namespace plumb::direct {

inline constexpr int most_filter_radius = 32;

enum class FilterKind : int { gaussian, edge_aware };

// The twin's uniform block (std140).
struct VisibilityFilterUniforms {
    std::int32_t width, height;
    std::int32_t radius;                // pixels
    std::int32_t vertical;              // 0: along rows, 1: along columns
    std::int32_t kind;                  // FilterKind
    float sigma_depth;                  // of the depth
    float normal_slope, normal_offset;  // 1 / sigma_normal, 1 - 1 / sigma_normal
};
static_assert(sizeof(VisibilityFilterUniforms) == 32);

struct VisibilityFilterView {
    VisibilityFilterUniforms u;
    const float* visibility;  // [height][width] r32f: 1 lit, 0 shadowed
    const float* position;    // [height][width] rgba32f: xyz world, m, w linear depth, m; of edge_aware alone
    const float* normal;      // [height][width] rgba32f: xyz unit; all 0 where there is no surface
    const float* spatial;     // [2 radius + 1]; 0 in the middle
    float* filtered;          // [height][width] r32f, out
};

template <class F, bool edges, class Tap>
PLUMB_INLINE F filtered_by(const VisibilityFilterView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const VisibilityFilterUniforms& u = in.u;
    const F zero(0.0f);
    const I pixel = py * I(u.width) + px;
    const F own = N::fetch(in.visibility, pixel);
    tap("own", own, "visibility of the pixel itself");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));
    tap("n", n, "unit normal; 0 where no surface is");
    filter::Centre<F> centre{};
    if constexpr (edges) {
        const vec4<F> x = N::fetch4(in.position, pixel);
        tap("x", xyz<F>(x), "world, m");
        tap("depth", x.w, "linear, m");
        centre = filter::centre_of<F>(xyz<F>(x), x.w, n, u.sigma_depth, u.normal_slope);
    }

    F sum = own, total(1.0f);
    for (int k = 0; k <= u.radius + u.radius; ++k) {
        tap.sample(k);
        const int along = k - u.radius;
        const I x = u.vertical != 0 ? px : px + I(along), y = u.vertical != 0 ? py + I(along) : py;
        const mask_t<F> inside = in_range(x, I(u.width)) & in_range(y, I(u.height));
        const I i = select(inside, y * I(u.width) + x, pixel);
        const vec3<F> n_i = xyz<F>(N::fetch4(in.normal, i));
        const mask_t<F> covered = inside & (dot3(n_i, n_i) > zero);
        // What has no surface, or lies beyond the border, counts by 0.
        const F visibility_i = select(covered, N::fetch(in.visibility, i), own);
        tap("visibility_i", visibility_i, "of the neighbour; the pixel's own where no surface is");
        F weight = select(covered, F(in.spatial[k]), zero);
        if constexpr (edges) {
            const vec4<F> x_i = N::fetch4(in.position, i);
            const filter::Texel<F> p{{zero, zero, zero}, x_i.w, n_i, xyz<F>(x_i)};
            const F of_depth = filter::depth_weight(true, centre, p, tap);
            const F of_normal = filter::normal_weight(centre, n_i, u.normal_offset, tap);
            weight = weight * of_depth * of_normal;
        }
        tap("weight", weight, "spatial; edge_aware: x depth x normal");
        sum += weight * visibility_i;
        total += weight;
        tap("total", total, "sum of the weights so far");
    }
    tap.sample(-1);
    const F mean = sum / total;
    const F filtered = select(dot3(n, n) > zero, mean, own);
    tap("filtered", filtered, "sum / total; as it was where no surface is");
    return filtered;
}

struct VisibilityFilterKernel {
    using View = VisibilityFilterView;
    template <class F, class Tap>
    PLUMB_INLINE static F item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        if (in.u.kind == int(FilterKind::gaussian)) return filtered_by<F, false>(in, px, py, tap);
        return filtered_by<F, true>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.filtered; }
};

}  // namespace plumb::direct
