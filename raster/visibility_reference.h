// The visibility pass as one reads it: triangle by triangle, pixel by pixel. The lesson, what explain shows, and the
// truth that the fast pass (visibility.cpp) is proven equal to.
#pragma once

#include "raster/visibility.h"

namespace plumb::raster {

// Rows [first, last) of what draw_visibility draws; the other rows see nothing.
VisibilityBuffer reference_visibility(const Geometry& geometry, const Surfaces* surfaces, const View& view,
                                      glm::ivec2 size, int first, int last, const RunOptions& options,
                                      const Image1* behind = nullptr);

// The same from clip positions, of each vertex one, that are finite.
VisibilityBuffer reference_visibility(const Geometry& geometry, const Surfaces* surfaces,
                                      const Buffer<glm::vec4>& clip_positions, bool reversed_z, glm::ivec2 size,
                                      int first, int last, const RunOptions& options, const Image1* behind = nullptr);

}  // namespace plumb::raster
