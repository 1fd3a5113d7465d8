// Which triangle each pixel sees: clipping, exact coverage, depth test. The other passes resolve attributes from it.
//
// Coverage is exact: vertices are snapped to 1/256 pixel (nearest even), edge functions are integers, and a pixel
// centre on an edge belongs to the triangle whose top or left edge it is. Triangles are two-sided. Depth passes when it
// is less (reversed z: greater) than what is there, so that of equal depths the earlier triangle stays. See
// raster/README.md.
//
// `behind` (depth peeling, Everitt 2001): a depth buffer of the frame's size that these functions drew from the same
// geometry and view; what does not lie strictly farther is not drawn. Null: everything is. It may not be part of `out`.
#pragma once

#include <cstdint>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/view.h"
#include "raster/surfaces.h"

namespace plumb::raster {

inline constexpr int max_frame_side = 32767;  // pixels

struct VisibilityBuffer {
    Image<std::int32_t> triangle;   // index into Geometry::triangles; -1: nothing
    Image1 depth;                   // z of the depth buffer; where nothing: 1 (reversed z: 0)
    Image<glm::vec2> barycentrics;  // l1, l2 of the whole, unclipped triangle, perspective-correct; l0 = 1 - l1 - l2
};

// Memory that passes keep from one frame to the next (raster/workspace.h); what it holds never changes a result.
struct Workspace;

// Draws what the view sees. With surfaces, nothing is drawn, no depth either, where a material's alpha is below its
// cutoff. The memory of `out` is used again if it has the size. Throws InputError for a size outside 1..max_frame_side
// and for vertices that are not finite.
void draw_visibility(const Geometry& geometry, const Surfaces* surfaces, const View& view, glm::ivec2 size,
                     const RunOptions& options, VisibilityBuffer& out, Workspace* workspace = nullptr,
                     const Image1* behind = nullptr);

// The same from clip positions, one a vertex.
void draw_visibility(const Geometry& geometry, const Surfaces* surfaces, const Buffer<glm::vec4>& clip_positions,
                     bool reversed_z, glm::ivec2 size, const RunOptions& options, VisibilityBuffer& out,
                     Workspace* workspace = nullptr, const Image1* behind = nullptr);

// The same without alpha masks.
VisibilityBuffer draw_visibility(const Geometry& geometry, const View& view, glm::ivec2 size,
                                 const RunOptions& options);

// The same for rows [first, last) alone, slowly; the other rows see nothing.
VisibilityBuffer draw_visibility_rows(const Geometry& geometry, const Surfaces* surfaces, const View& view,
                                      glm::ivec2 size, int first, int last, const RunOptions& options,
                                      const Image1* behind = nullptr);
VisibilityBuffer draw_visibility_rows(const Geometry& geometry, const View& view, glm::ivec2 size, int first, int last,
                                      const RunOptions& options);

void check_frame_size(glm::ivec2 size);
// Throws InputError unless `behind` is null or of that size.
void check_behind(const Image1* behind, glm::ivec2 size);

}  // namespace plumb::raster
