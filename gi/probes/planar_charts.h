// Cuts a mesh into charts that a projection onto a plane unfolds without overlap: for meshes whose own texture
// coordinates cannot serve a lightmap. differs: IPR 3.2.1.1 wants every model unwrapped by its author.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gi/probes/surface_mesh.h"

namespace plumb::probes {

struct PlanarCharts {
    std::vector<std::int32_t> of;    // [triangle]: chart; -1: no area
    std::vector<glm::dvec3> normal;  // [chart] unit, of its plane
    int split = 0;                   // charts that were cut off where the surface would have covered itself
};

// From the largest triangle that is left, a chart grows over shared edges while normals stay within five sixths of
// `angle_deg` of its own, which is the area-weighted mean of what it holds after at most four rounds. Then, the
// smallest first, a chart joins the neighbour with which it shares the longest border, if that has four times its area,
// all normals stay within `angle_deg` and nothing overlaps. Edges that more than 8 triangles share, and edges along
// which two triangles run the same way (a fold, a duplicate), end a chart. Ties are decided by indices: the charts are
// the same everywhere.
PlanarCharts cut_into_charts(const SurfaceMesh& mesh, double angle_deg);

// Unit vectors that span the plane across unit n: cross(first, second) = n.
void plane_axes(const glm::dvec3& n, glm::dvec3& first, glm::dvec3& second);

}  // namespace plumb::probes
