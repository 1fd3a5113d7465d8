// The gutter of octahedral tiles: what a bilinear lookup reads beyond a tile's edge lies where the octahedron is folded
// together (DDGI 2019, section 4.1 and figure 3). The algorithm that border.comp mirrors line by line.
//
//     beside an edge     the texel of the same edge that lies mirrored about its middle
//     at a corner        the texel of the opposite corner: all four corners are the direction -z
//
// differs: the whole atlas is written anew, where engines copy in place.
#pragma once

#include "gi/ddgi/octahedral_kernel.h"

namespace plumb::ddgi {

// The twin's uniform block (std140).
struct BorderUniforms {
    std::int32_t width, height;  // of the atlas, texels
    std::int32_t side;           // of a tile, without its gutter
    std::int32_t padding;
};
static_assert(sizeof(BorderUniforms) == 16);

struct BorderView {
    BorderUniforms u;
    const float* atlas;  // [height][width][4]: the gutter holds anything
    float* bordered;     // out: [height][width][4]
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> border(const BorderView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using I = index_t<F>;
    const BorderUniforms& u = in.u;
    const InTile<F> at = in_tile<F>(px, py, u.side);
    const I one(1), side(u.side);
    const mask_t<F> beside_x = !in_range(at.texel.x - one, side), beside_y = !in_range(at.texel.y - one, side);
    const I x = max(one, min(at.texel.x, side)), y = max(one, min(at.texel.y, side));
    const ivec2<I> from{select(beside_y, side + one - x, x), select(beside_x, side + one - y, y)};
    tap("from", from, "texel of the tile that is copied; its first is 1, 1");
    const I row = min(at.tile.y * I(u.side + 2) + from.y, I(u.height - 1));
    const I column = min(at.tile.x * I(u.side + 2) + from.x, I(u.width - 1));
    return number<F>::fetch4(in.atlas, row * I(u.width) + column);
}

struct BorderKernel {
    using View = BorderView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return border<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.bordered; }
};

}  // namespace plumb::ddgi
