// The pass texture_space: the surface at each texel of a lightmap, drawn with texture coordinates for positions (IPR
// 3.2.1.2). See raster/README.md.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/stage.h"
#include "raster/surfaces.h"
#include "raster/visibility.h"

namespace plumb::raster {

// All zero, -1 where no triangle covers the texel's centre.
struct TextureSpace {
    Image4 position;                // xyz world, m; w 0
    Image4 normal;                  // xyz unit, on the front of the triangle; w: 1 covered
    Image4 albedo;                  // diffuse reflectance
    Image4 emission;                // W/m2
    Image<glm::ivec3> id;           // object, triangle, material
    Image<glm::vec2> barycentrics;  // l1, l2
};

// uv: a texture coordinate for each vertex of `geometry`, (0, 0) the top left corner of the first texel, (1, 1) the
// bottom right one of the last; what lies outside is cut off. Where triangles overlap, the first one stays. Reuses
// `out`. Throws InputError for coordinates that are missing or not finite and for sizes that draw_visibility refuses.
void draw_texture_space(const Geometry& geometry, const Surfaces& surfaces, const std::vector<glm::vec2>& uv,
                        glm::ivec2 size, const RunOptions& options, TextureSpace& out, Workspace* workspace = nullptr);

// The vertices' own coordinates.
std::vector<glm::vec2> texture_coordinates(const Geometry& geometry);

StageInfo info_texture_space();

}  // namespace plumb::raster
