// What is a perfect mirror of what a G-buffer sees.
#pragma once

#include "core/image.h"
#include "core/scene.h"

namespace plumb::frame {

// Whether any material of the scene is one.
bool any_mirror(const Scene& scene);
// xyz: its reflectance, of the triangles in `id` (object, triangle; -1, -1: nothing); w: 1 where that is not black.
Image4 mirrors_of(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id);

}  // namespace plumb::frame
