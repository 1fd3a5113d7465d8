// A drawn hemicube, weighed and summed box by box until one number is left (HEM 6.7.1 proposes it; hemicube lightmappers run it): the
// algorithm that reduce.comp mirrors line by line.
//
//     first pass       S(x, y) = g sum_j sum_i w(X, Y) B(X, Y)         X = across x + i,  Y = down y + j
//     further passes   S(x, y) = g sum_j sum_i S'(X, Y)                S' of the pass before
//     last             H = S of one texel a hemicube                   w: texels' form factors, HEM 5.5; they sum to 1
//
// The sum of a hemicube is the tree of its boxes: rows of a box one after the other, in a row from left to right. g is 1 where sums
// are made; of means, which keep what is stored in few bits of ordinary size, 1 / (across down), and w is larger by a hemicube's texels.
#pragma once

#include "core/number.h"

namespace plumb::radiosity {

// The twin's uniform block (std140).
struct ReduceUniforms {
    std::int32_t width, height;  // of what is left
    std::int32_t across, down;   // texels of a box
    std::int32_t rows;           // of a hemicube, before
    std::int32_t weighted;       // 1: the first pass
    float gain;                  // g
    std::int32_t padding;
};
static_assert(sizeof(ReduceUniforms) == 32);

struct ReduceView {
    ReduceUniforms u;
    const float* texels;   // [height down][width across][4]: hemicubes, one below the other; xyz B, W/m2, w share of a front
    const float* weights;  // [rows][width across]; not read where weighted is 0
    float* sums;           // out: [height][width][4]
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> reduced(const ReduceView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ReduceUniforms& u = in.u;
    const int columns = u.width * u.across;
    const I left = px * I(u.across), top = py * I(u.down);
    // Rows of a hemicube are a multiple of `down`: a box lies in one.
    const I cube = N::truncate_to_index((N::from_index(top) + F(0.5f)) / F(float(u.rows)));
    tap("cube", cube, "of the hemicubes: that the box is of");
    const I own = top - cube * I(u.rows);
    const F zero(0.0f);
    vec4<F> sum{zero, zero, zero, zero};
    for (int j = 0; j < u.down; ++j)
        for (int i = 0; i < u.across; ++i) {
            tap.sample(j * u.across + i);
            const I x = left + I(i);
            const vec4<F> b = N::fetch4(in.texels, (top + I(j)) * I(columns) + x);      tap("texel", xyz<F>(b), "B, W/m2, or a sum of the pass before");
            F w(1.0f);
            if (u.weighted != 0) w = N::fetch(in.weights, (own + I(j)) * I(columns) + x);
            tap("weight", w, "w(X, Y), HEM 5.5; 1 in further passes");
            sum = vec4<F>{sum.x + w * b.x, sum.y + w * b.y, sum.z + w * b.z, sum.w + w * b.w};
        }
    tap.sample(-1);
    const F g(u.gain);
    const vec4<F> result{g * sum.x, g * sum.y, g * sum.z, g * sum.w};
    tap("sum", xyz<F>(result), "S(x, y), W/m2");
    tap("front", result.w, "the same of what is a front");
    return result;
}

struct ReduceKernel {
    using View = ReduceView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return reduced<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.sums; }
};

}  // namespace plumb::radiosity
