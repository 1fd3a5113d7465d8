// What is a perfect mirror of what a G-buffer sees, and what has Phong's lobe.
#pragma once

#include "core/image.h"
#include "core/scene.h"
#include "gi/frame/settings.h"

namespace plumb::frame {

// Whether any material of the scene is one.
bool any_mirror(const Scene& scene);
// xyz: its reflectance, of the triangles in `id` (object, triangle; -1, -1: nothing); w: 1 where that is not black.
Image4 mirrors_of(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id);

// The same of lobes: xyz reflectance, w exponent; 0 where the material has none.
bool any_lobe(const Scene& scene);
Image4 lobes_of(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id);

// What of the materials that meshes use the picture does not show, in one sentence: microfacets, lobes, mirrors. Empty:
// nothing.
std::string lobes_left_out(const Scene& scene, const Settings& settings);

}  // namespace plumb::frame
