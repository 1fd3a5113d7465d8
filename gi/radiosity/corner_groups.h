// Which corners of triangles are one element: those at one position between which the surface goes on.
#pragma once

#include <cstdint>
#include <vector>

#include "gi/probes/surface_mesh.h"

namespace plumb::radiosity {

// Corner 3 t + k is corner k of triangle t, and half edge 3 t + k runs from it to the next.
struct CornerGroups {
    std::vector<std::uint32_t> group;  // [corner]: the least corner of its group
    std::vector<char> goes_on;         // [half edge]: whether the surface goes on beyond it
};

// Groups corners of triangles that share an edge there: of one object and one material, run through in opposite ways (so that
// the same side is in front), whose normals differ by at most `crease_deg`, to within 0.08 degrees and never the two sides of
// a sheet, and between which nothing
// stands: a third triangle at the edge that rises in front of the two, as a wall on a floor, divides what they see. Edges of
// more than 16 triangles are creases. Triangles without area are in no group but their own.
CornerGroups corner_groups(const Geometry& geometry, const probes::SurfaceMesh& mesh, double crease_deg);

// All corners at a position, whatever they belong to. The surface goes on beyond every edge that two triangles share.
CornerGroups corners_by_position(const probes::SurfaceMesh& mesh);

// All corners that are one vertex of the file. The surface goes on where two triangles share both vertices of an edge.
CornerGroups corners_by_vertex(const Geometry& geometry, const probes::SurfaceMesh& mesh);

}  // namespace plumb::radiosity
