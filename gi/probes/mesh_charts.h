// All charts of all meshes as plane figures, before their texels are known.
#pragma once

#include <vector>

#include "gi/probes/atlas.h"
#include "gi/probes/chart_layout.h"
#include "gi/probes/own_uv.h"

namespace plumb::probes {

struct MeshCharts {
    SurfaceMesh mesh;  // without its edges
    OwnUv verdict = OwnUv::kept;
    int mirrored_islands = 0, overlaps_cut = 0;
    std::vector<ChartShape> shapes;  // kept: islands; otherwise planar charts
};

// One for each object that has triangles, in their order; the same for any number of threads.
std::vector<MeshCharts> mesh_charts(const Geometry& geometry, double chart_angle_deg);

// Shapes [first, first + count) of a mesh that lie in one rectangle.
struct ChartPiece {
    std::uint32_t mesh, first, count;
    TexelRectangle rectangle;
    std::vector<TexelHole> holes;
};

// The islands of a kept mesh stay as they were laid out where they are `gap` texels apart, each holds the centre of a
// texel, and they fill a quarter of their rectangle. differs: elsewhere each becomes a chart of its own, where IPR
// takes the mesh as one.
std::vector<ChartPiece> chart_pieces(const std::vector<MeshCharts>& meshes, double texels_per_m, int gap);

}  // namespace plumb::probes
