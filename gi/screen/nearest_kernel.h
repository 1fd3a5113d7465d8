// The least depths of blocks of a view's texels, level by level: the algorithm that nearest.comp mirrors line by line.
//
// Level l has blocks of 2^l x 2^l texels. All levels lie in one image, one under the other: with a height H that is a
// multiple of the largest block, level l has H / 2^l rows, and begins at row H - 2 H / 2^l.
//
// differs: Uludag 2014 makes each level from the one before. Here every block reads its texels: the levels are few.
#pragma once

#include "core/number.h"

namespace plumb::screen {

inline constexpr int most_levels = 6;
inline constexpr float no_depth = 3e38f;  // of a block that nothing is seen in, m

// The twin's uniform block (std140).
struct NearestUniforms {
    std::int32_t width, height;      // blocks a row of level 1, and rows of all levels
    std::int32_t view_width, view_height;  // texels
    std::int32_t levels;
    std::int32_t padded;             // H: the height as a multiple of 2^levels
    std::int32_t padding[2];
};
static_assert(sizeof(NearestUniforms) == 32);

struct NearestInputsView {
    NearestUniforms u;
    const float* map_position;  // [view_height][view_width] rgba32f: w linear depth, m; 0: nothing
    float* nearest;             // out: [height][width] rgba32f: x least depth, m
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> nearest(const NearestInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const NearestUniforms& u = in.u;
    const F zero(0.0f);
    // The level of the row, and its row there.
    I side(2), row = py;
    for (int l = 2; l <= u.levels; ++l) {
        const int start = u.padded - (2 * u.padded >> l);
        const mask_t<F> beyond = py >= I(start);
        side = select(beyond, I(1 << l), side), row = select(beyond, py - I(start), row);
    }
    tap("side", N::from_index(side), "of the block, texels");
    F least(no_depth);
    for (int y = 0; any(I(y) < side); ++y)
        for (int x = 0; any(I(x) < side); ++x) {
            const I at_x = px * side + I(x), at_y = row * side + I(y);
            const mask_t<F> inside = (I(x) < side) & (I(y) < side) & (at_x < I(u.view_width)) & (at_y < I(u.view_height));
            const F depth = N::fetch(in.map_position, select(inside, at_y * I(u.view_width) + at_x, I(0)) * I(4) + I(3));
            const mask_t<F> known = inside & (depth > zero);
            least = select(known, min(least, depth), least);
        }
    tap("least", least, "depth of its texels, m");
    return {least, zero, zero, zero};
}

struct NearestKernel {
    using View = NearestInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return nearest<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.nearest; }
};

}  // namespace plumb::screen
