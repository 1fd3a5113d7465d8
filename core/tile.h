// The order in which a square tile of pixels deals something out: the twin of core/tile.glsl.
#pragma once

#include <cstdint>

#include "core/number.h"

namespace plumb {

// Where a pixel stands in that order, 0 to tile^2 - 1: Bayer's matrix, so that neighbours differ most. tile: a power of two.
template <class I>
PLUMB_INLINE I tile_place(std::int32_t tile, I px, I py) {
    const I across = px ^ py;
    I place(0);
    for (std::int32_t bit = 1; bit < tile; bit *= 2) {
        const I of_across = select((across & I(bit)) == I(0), I(0), I(2)), of_row = select((py & I(bit)) == I(0), I(0), I(1));
        place = (place << 2) + of_across + of_row;
    }
    return place;
}

// The side of the square tile that has as many pixels, a power of two; 0 where there is none.
constexpr int tile_of(int pixels) {
    int side = 1;
    while (side < 16384 && side * side < pixels) side *= 2;
    return side * side == pixels ? side : 0;
}

}  // namespace plumb
