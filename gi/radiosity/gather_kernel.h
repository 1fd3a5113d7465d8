// Irradiance of elements from what leaves all others, by rows of form factors: the algorithm that gather.comp mirrors line by line.
//
//     H_i = H0_i + sum_j F_ij B_j          (HEM (4.30), (4.32): F_ij are the shares of the hemicube in which j is seen)
//
// A row is kept as runs of elements that it sees, one after the other, each number a half times the row's scale: F_ij = scale_i h_ij.
// A run holds zeros where that is shorter than two runs.
//
// Sums are those of sixteen lanes, whatever the processor has: the k-th number of a run goes to sum k mod 16, and at the end they are
// added in halves, 8 to 8, 4 to 4, 2 to 2, 1 to 1.
#pragma once

#include "core/number.h"

namespace plumb::radiosity {

inline constexpr int row_lanes = 16;

// The twin's uniform block (std140).
struct GatherUniforms {
    std::int32_t width, height;  // of the domain: the list of elements of a block, folded to rows
    std::int32_t count;          // elements of the block
    std::int32_t elements;       // of the scene
};
static_assert(sizeof(GatherUniforms) == 16);

struct GatherView {
    GatherUniforms u;
    const std::int32_t* rows;     // [count][4]: first run, runs, first weight, weights
    const std::int32_t* runs;     // [run][2]: first element, elements
    const float* weights;         // F_ij / scale, run by run
    const Half* half_weights;     // lent: the same; then `weights` may be null
    const float* scale;           // [count]
    const float* own;             // [count][4]: H0, W/m2
    const float* radiosity;       // [elements][4]: xyz B, W/m2
    const float* planes;          // lent: the same as three lists of `elements` and row_lanes zeros each
    float* irradiance;            // out: [height][width][4]
};

// F_ij / scale. Halves are gathered one by one: gather_isa.cpp reads them side by side.
template <class F>
PLUMB_INLINE F weight_at(const GatherView& in, const index_t<F>& at) {
    if (in.weights) return number<F>::fetch(in.weights, at);
    constexpr int width = number<F>::width;
    std::int32_t place[width];
    float weight[width];
    std::memcpy(place, &at, sizeof place);
    for (int k = 0; k < width; ++k) weight[k] = half_to_float(in.half_weights[place[k]]);
    return number<F>::fetch(weight, number<F>::iota(0));
}

// The sixteen sums of a row.
template <class F>
struct LaneSums {
    vec3<F> lane[row_lanes];
    PLUMB_INLINE vec3<F> total() {
        for (int half = row_lanes / 2; half > 0; half /= 2)
            for (int k = 0; k < half; ++k)
                lane[k] = {lane[k].x + lane[k + half].x, lane[k].y + lane[k + half].y, lane[k].z + lane[k + half].z};
        return lane[0];
    }
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> gathered(const GatherView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I i = min(py * I(in.u.width) + px, I(in.u.count - 1));
    const I run = N::fetch(in.rows, i * I(4)), runs = N::fetch(in.rows, i * I(4) + I(1)), weight = N::fetch(in.rows, i * I(4) + I(2));
    tap("runs", runs, "of elements that it sees");
    LaneSums<F> sums;
    for (int k = 0; k < row_lanes; ++k) sums.lane[k] = {F(0.0f), F(0.0f), F(0.0f)};
    I at = weight;
    for (int r = 0; any(I(r) < runs); ++r) {
        tap.sample(r);
        const mask_t<F> has = I(r) < runs;
        const I place = select(has, run + I(r), I(0)) * I(2);
        const I first = N::fetch(in.runs, place), count = select(has, N::fetch(in.runs, place + I(1)), I(0));
        tap("first", first, "element of the run"), tap("count", count, "elements of it");
        for (int k = 0; any(I(k) < count); ++k) {
            const mask_t<F> there = (I(k) < count) & in_range(first + I(k), I(in.u.elements));
            const F f = weight_at<F>(in, select(there, at + I(k), I(0)));
            const vec3<F> b = xyz<F>(N::fetch4(in.radiosity, select(there, first + I(k), I(0))));
            vec3<F>& lane = sums.lane[k % row_lanes];
            lane = select3<F>(there, {lane.x + f * b.x, lane.y + f * b.y, lane.z + f * b.z}, lane);
        }
        at = at + count;
    }
    tap.sample(-1);
    const vec3<F> sum = sums.total();                             tap("sum", sum, "of h_ij B_j, W/m2");
    const F scale = N::fetch(in.scale, i);                        tap("scale", scale, "of the row");
    const vec3<F> own = xyz<F>(N::fetch4(in.own, i));             tap("own", own, "H0: of lamps and the sky, W/m2");
    const vec4<F> h{own.x + scale * sum.x, own.y + scale * sum.y, own.z + scale * sum.z, F(0.0f)};
    tap("irradiance", xyz<F>(h), "H_i, W/m2");
    return h;
}

struct GatherKernel {
    using View = GatherView;
    static constexpr int band = 1;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return gathered<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.irradiance; }
    // The last row of the fold may be longer than the list.
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        using I = index_t<F>;
        return py * I(in.u.width) + px < I(in.u.count);
    }
};

}  // namespace plumb::radiosity
