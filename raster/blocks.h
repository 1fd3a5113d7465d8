// Blocks: a packet of lanes as a block of pixels, nearly square, so that it sees few triangles. Lane k is column
// k % block_width and row k / block_width. A tile's blocks lie in memory row by row of blocks. For kernel files, as
// core/wide.h.
#pragma once

#include "core/wide.h"
#include "raster/visible_tiles.h"
#include "raster/wide_double.h"

namespace plumb::PLUMB_ISA {

constexpr int lanes = number<Real>::width;
constexpr int block_shift = lanes >= 8 ? 2 : lanes >= 4 ? 1 : 0, block_width = 1 << block_shift,
              block_height = lanes / block_width;

// Where in a tile of that side the block lies whose first pixel is (x, y) of the tile.
PLUMB_INLINE std::ptrdiff_t block_at(int side, int x, int y) {
    return std::ptrdiff_t(y) * side + x * block_height;
}

// Columns and rows of lanes, from the block's first pixel on.
PLUMB_INLINE index_t<Real> lane_columns() { return number<Real>::iota(0) & index_t<Real>(block_width - 1); }
PLUMB_INLINE index_t<Real> lane_rows() { return number<Real>::iota(0) >> block_shift; }

// Calls visit(value, the lanes that have it) for each value of the lanes that are set.
template <class Visit>
PLUMB_INLINE void for_distinct(index_t<Real> value, const std::int32_t* in_memory, unsigned lanes_set,
                               const Visit& visit) {
    while (lanes_set) {
        const std::int32_t v = in_memory[__builtin_ctz(lanes_set)];
        const mask_t<Real> here = value == index_t<Real>(v);
        visit(v, here);
        lanes_set &= ~lane_bits(here);
    }
}

}  // namespace plumb::PLUMB_ISA
