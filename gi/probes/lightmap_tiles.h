// Which squares of the lightmap's strip an update writes: those that the view's levels of detail show (IPR 4.2.3), and of a lightmap
// without levels those that a lookup can reach. The others hold 0, and nothing reads them: README.md, Level of detail.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "raster/covered.h"

namespace plumb::probes {

struct Bake;
struct LightmapInputs;

// What is known of a strip's tiles (raster/covered.h) before there is a view.
struct LightmapTiles {
    glm::ivec2 size{0};               // of the strip; 0: nothing is known, and all tiles are written
    std::vector<std::uint8_t> always;  // [tiles]: 1 where something is looked up that no cluster is known for
    std::vector<std::int32_t> first;  // [tiles + 1]: the tile's first in `shows`
    std::vector<std::int32_t> shows;  // most_levels cluster + the coarsest level of the strip in which the tile shows it

    bool empty() const { return always.empty(); }
};

// A tile shows a cluster in level k of the strip where one of the cluster's receivers that level k has lies at most lookup_reach
// (lod.h) texels of it from the tile: whatever reads that receiver, or the rings beside it, reads no tile beyond. cluster, level:
// [receivers]: -1 of a receiver without; the coarsest level that shows it. A place on a chart that is looked up in a level in which
// the chart has no receiver near is in tiles that are always written.
LightmapTiles lightmap_tiles(const Bake& bake, int levels, const std::vector<std::int32_t>& cluster, const std::vector<std::int32_t>& level);

// The tiles that show a cluster in its level, or a coarser one. cluster_level: [clusters]; empty: all have level 0.
raster::Covered tiles_to_write(const LightmapTiles& tiles, const std::vector<std::int32_t>& cluster_level);

// A lightmap that is kept from update to update: which tiles are wanted, and which hold something; the others are 0.
struct TilesToWrite {
    raster::Covered wanted, written;
};

// probes.lightmap into the wanted tiles alone; those that were written before and are not wanted become 0. A lightmap of another size
// is made anew.
void write_lightmap(const LightmapInputs& in, const RunOptions& options, TilesToWrite& tiles, Image4& lightmap);

}  // namespace plumb::probes
