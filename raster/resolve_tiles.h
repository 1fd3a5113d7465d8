// The kernels over the pixels of a tile, one specialisation per instruction set (resolve_isa.cpp). Pixels that see
// nothing become 0, their ids -1.
#pragma once

#include "core/isa.h"
#include "raster/gbuffer_kernel.h"
#include "raster/rsm_kernel.h"
#include "raster/visible_tiles.h"

namespace plumb::raster {

template <Isa isa>
struct ResolveTile {
    static void gbuffer(const GBufferArgs& in, const TilePixels& seen);
    static void rsm(const RsmArgs& in, const TilePixels& seen, const RsmStore& store = {});
};

}  // namespace plumb::raster
