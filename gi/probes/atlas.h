// The lightmap atlas of the irradiance-probe bake: where on one square texture every surface of the scene lies (IPR
// 3.2.1.1, figures 3.7 to 3.12). See gi/probes/README.md.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/scene.h"

namespace plumb::probes {

struct AtlasParams {
    double receivers_per_m2 = 80;  // IPR 3.1.1: texels on a square metre of surface
    int size = 0;                  // texels a side; the density is then the largest that fits. 0: what the density asks
    int gap = 3;                   // texels that stay free between charts (IPR 3.2.1.1), 0..64
    double chart_angle_deg = 60;   // a planar chart holds triangles whose normals are within this of its own, 1..80
    int max_size = 16384;          // texels a side; more is refused
};

// A rectangle of whole texels. The chart lies in it, and may reach 2^-10 of a texel beyond. Rectangles may lie inside
// others: where a chart leaves room, smaller ones take it. What charts touch is always the gap apart.
struct Chart {
    int object = 0;
    glm::ivec2 origin{0}, size{0};  // texels, without the gap
    std::int32_t own_uv = 0;        // 1: the mesh's own coordinates, scaled; 0: a projection onto a plane
};

// What an atlas is made of, for reports.
struct AtlasSummary {
    double used = 0;                                     // share of texels: area of the surface in texels / size^2
    int meshes_kept = 0, meshes_cut = 0;                 // own coordinates; planar charts
    int degenerate = 0, stretched = 0, overlapping = 0;  // why the meshes were cut
    int layouts_split = 0;                               // kept meshes whose islands are charts of their own
    int mirrored_islands = 0;                            // of kept meshes: laid out as seen from the back
    int overlaps_cut = 0;                                // planar charts that would have covered themselves
    std::int64_t triangles_without_area = 0;
    int charts_without_texel = 0;  // too small or too thin to hold the centre of a texel anywhere
};

struct Atlas {
    // The scene's, in world space: triangles, materials and objects in the same order, vertices doubled where charts
    // end (the scene's vertices first).
    Geometry geometry;
    std::vector<glm::vec2> uv;        // of each vertex, unit square, (0, 0) the top left corner of the first texel
    std::vector<std::int32_t> chart;  // of each triangle: index into charts; -1: no area, its corners at one place
    std::vector<Chart> charts;        // mesh by mesh
    glm::ivec2 size{0};               // texels; square
    double texels_per_m = 0;          // of charts with the density asked for
    AtlasSummary summary;
};

// geometry: flatten(scene). A mesh keeps its texture coordinates where gi/probes/own_uv.h allows; any other is cut into
// planar charts (gi/probes/planar_charts.h). Every chart holds the centre of a texel, but for those that the summary
// counts. Throws InputError for parameters out of range, for a scene without surfaces, and for one that max_size or
// size has no room for.
Atlas make_atlas(const Scene& scene, const Geometry& geometry, const AtlasParams& params);

}  // namespace plumb::probes
