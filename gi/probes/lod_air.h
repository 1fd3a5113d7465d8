// Levels of detail in the air: of places of spatial receivers, by what reads them (IPR 4.1.1, 4.2). README.md, Level of detail.
//
//     level of a cell     of the part that lies in it of each box that reads it, the finest: of nothing that is read there it is coarser
//     its lattice         every 2^k-th place along each axis, and the last; k that level, along each axis no more than the box is wide
//     places computed     the eight of the lattice's cell about it; the others of the cell lie between them: fill_air()
//     clusters            the finest of their places': how many coefficients of their probes they read
//
// differs: IPR 4.2.3 computes each place of a cell that a dynamic object touches; 4.2.2 measures a cluster's level from the box of its
// places, of which those that are read may be the farthest.
#pragma once

#include "gi/probes/spatial.h"

namespace plumb::probes {

// What is read of the grid: of each cell that a box touches the part of the box there.
struct AirReads {
    Buffer<glm::vec4> low, high;         // m; w 0
    std::vector<glm::ivec3> cell;        // its first place
    std::vector<glm::ivec3> coarsest;    // level along each axis: whose lattice's cells are no wider than the box
};
// Refuses boxes as active_places() does, whose places are those of the cells.
AirReads air_reads(const SpatialGrid& grid, const std::vector<Box>& boxes);

struct AirLevels {
    std::vector<std::int32_t> place;    // [places]: of those that are computed; no_level of the others
    std::vector<std::int32_t> cluster;  // [clusters]: no_level where none of its places is computed
};
// level: [cells of reads]. cluster_of: [receivers in the air].
AirLevels air_levels(const SpatialGrid& grid, const AirReads& reads, const std::vector<std::int32_t>& level,
                     const std::vector<std::int32_t>& cluster_of, int clusters);

// [place][direction], as gather_grid() has it: gives places that are not computed what lies there between those of the narrowest lattice
// whose places about it are. Others stay 0, and w of all that are not computed.
void fill_air(const SpatialGrid& grid, const std::vector<std::int32_t>& level, Buffer<glm::vec4>& gathered);

}  // namespace plumb::probes
