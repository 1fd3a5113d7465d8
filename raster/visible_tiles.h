// What the pixels of a tile see, while it is still in a core's caches: passes that resolve attributes from it do so
// tile by tile, and only depth is ever a frame.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/view.h"
#include "raster/surfaces.h"

namespace plumb::raster {

struct Workspace;

// Planes of side x side values, in blocks (raster/blocks.h): as VisibilityBuffer has them for pixels [origin, end) of
// the frame; beyond them, nothing.
struct TilePixels {
    glm::ivec2 origin, end;
    int side;
    std::int32_t* triangle;
    float* l1;
    float* l2;
};

// As draw_visibility(), and calls `resolve` for every tile on the thread that drew it. Kernels that read the tile have
// to be those of options.isa.
void draw_visible_tiles(const Geometry& geometry, const Surfaces* surfaces, const View& view, glm::ivec2 size,
                        const RunOptions& options, Image1& depth, Workspace* workspace,
                        const std::function<void(const TilePixels&)>& resolve, const Image1* behind = nullptr);
void draw_visible_tiles(const Geometry& geometry, const Surfaces* surfaces, const Buffer<glm::vec4>& clip_positions,
                        bool reversed_z, glm::ivec2 size, const RunOptions& options, Image1& depth,
                        Workspace* workspace, const std::function<void(const TilePixels&)>& resolve,
                        const Image1* behind = nullptr);

}  // namespace plumb::raster
