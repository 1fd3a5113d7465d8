// The layout of a lightmap that somebody else made, as an atlas: texture coordinates as the meshes have them, neither scaled
// nor moved. Charts are islands of the coordinates.
#pragma once

#include <string>
#include <vector>

#include "gi/probes/atlas.h"

namespace plumb::probes {

struct OwnLayout {
    std::vector<glm::vec2> uv;    // of each vertex of the geometry, unit square, (0, 0) the top left corner
    std::vector<bool> on_map;     // [mesh of the scene]: the others cast shadows and have no texel. Empty: all are
    glm::ivec2 size{0};           // texels of the map
};

// By how much triangles may overlap, and reach beyond the unit square: what packers of layouts round away.
inline constexpr double layout_slack_texels = 1.0 / 16;

// geometry: flatten(scene). Throws InputError that begins with `file` and names the mesh: where coordinates are not finite,
// leave the unit square, cover each other or have no area at all; and for a map that is not square where texels would be
// stretched more than those of a square one.
Atlas own_layout(const Scene& scene, const Geometry& geometry, const OwnLayout& layout, const std::string& file);

// Mean width of a texel on the surfaces over its height, of a square map.
double texel_aspect(const Atlas& atlas);

}  // namespace plumb::probes
