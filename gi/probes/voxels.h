// A grid of cubes over a scene, and which of them hold a surface (IPR 3.2.2.1, figure 3.13).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/isa.h"
#include "core/scene.h"

namespace plumb::probes {

// The part of a scene's surface that lies in one voxel; lengths in cells.
struct Surface {
    glm::dvec3 normal{0};  // sum of area * unit normal, by the winding of the triangles
    glm::dvec3 centre{0};  // sum of area * centre, in cells from the grid's corner
    double area = 0;       // what only touches the voxel counts 2^-20
    // Whether normals agree: the mean of their dot products with their mean direction, weighted by area, is at least
    // `least_agreement`.
    bool has_normal() const;
};
inline constexpr double least_agreement = 0.5;  // ours; two walls of a corner have 0.71, three 0.58, a thin sheet 0

struct Voxels {
    glm::dvec3 low{0};    // m: the corner of cell (0, 0, 0)
    double cell_m = 0;
    glm::ivec3 size{0};   // cells
    std::vector<std::int32_t> surface;  // [z][y][x]: index into `surfaces`, -1: none
    std::vector<Surface> surfaces;      // ascending by cell

    std::size_t cell(glm::ivec3 at) const {
        return (std::size_t(at.z) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.x) + std::size_t(at.x);
    }
    glm::dvec3 centre_m(glm::ivec3 at) const { return low + (glm::dvec3(at) + 0.5) * cell_m; }
};
inline constexpr std::int64_t most_cells = std::int64_t(1) << 25;

// Cells that grid_of() would make; more than most_cells are refused by voxelise().
std::int64_t cell_count(const glm::dvec3& low, const glm::dvec3& high, double cell_m);

// Voxels of the box [low, high] (m) with a ring of cells around it. The box's faces lie at least a quarter of a cell away
// from the sides of cells, so that no rounding decides on which side a wall of the box is.
//
// A cell holds each triangle that meets it or touches it, by the axes of Akenine-Moeller ("Fast 3D Triangle-Box Overlap
// Testing", 2001), in double with a margin of 2^-30 cells. Triangles without area count as nothing. The same for any
// number of threads. Throws InputError for corners that are not finite, and for too many cells.
Voxels voxelise(const Geometry& geometry, const glm::dvec3& low, const glm::dvec3& high, double cell_m,
                const RunOptions& options);

}  // namespace plumb::probes
