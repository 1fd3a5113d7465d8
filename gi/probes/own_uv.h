// Whether a mesh's own texture coordinates serve a lightmap (IPR 3.2.1.1), and its islands.
#pragma once

#include <cstdint>
#include <vector>

#include "gi/probes/surface_mesh.h"

namespace plumb::probes {

enum class OwnUv : int {
    kept,
    degenerate,  // absent, not finite, or a triangle with area in space has none in the plane
    stretched,   // a texel would cover more than largest_stretch of the mean edge, or the mesh that many squared its
                 // area
    overlapping,
};

// differs: IPR takes any coordinates. A texel of a kept mesh covers at most 4 times the length that the mean edge says,
// and all its texels together at most 4 times the mesh's area.
inline constexpr double largest_stretch = 4, largest_area_ratio = 4;

// Parts of a mesh that hang together by edges with equal positions and equal coordinates on both sides.
struct UvIslands {
    OwnUv verdict = OwnUv::kept;
    double metres = 0;             // a unit of the coordinates in metres: sum |e|/|j| / |E| (IPR 3.2.1.1)
    std::vector<std::int32_t> of;  // [triangle]: island; -1: no area. Empty unless kept
    int count = 0, mirrored = 0;   // islands; those laid out as the surface is seen from the back
};

// Exact but for a tolerance of 2^-22 of the mesh's largest coordinate, four of its roundings.
UvIslands judge_own_uv(const SurfaceMesh& mesh);

// Fills `of`, `count` and `mirrored`, of any finite coordinates.
void find_islands(const SurfaceMesh& mesh, UvIslands& islands);

}  // namespace plumb::probes
