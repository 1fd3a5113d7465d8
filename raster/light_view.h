// The view through which a light sees, and the light's constants as kernels read them.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/binding.h"
#include "core/scene.h"
#include "core/view.h"
#include "raster/light_kernel.h"
#include "raster/project_kernel.h"

namespace plumb::raster {

// A spot sees through a square pyramid around its outer cone; a directional light through a box around the bounding
// sphere of [low, high], so that every vertex is inside. Depth is reversed: a float then resolves the same share of the
// distance everywhere. What is nearer to a spot than 1e-6 of its farthest point is cut off. Up is +Y, or +Z where the
// light points within 2.6 degrees (cosine 0.999) of the vertical. Throws InputError for a point light (it has
// six views) and for a light whose cone or direction is unusable.
View light_view(const Light& light, const glm::vec3& low, const glm::vec3& high);

// The same for every light: one view, or a point light's six. Each face is a pyramid of exactly 90 degrees, so that
// neighbours share their border. The six lie around the light as in a cube map; `up` is a column, seen from the light:
//
//            +-----+                    face    +x  -x  +y  -y  +z  -z
//            | +y  |                    right   +z  -z  -x  -x  -x  +x
//      +-----+-----+-----+-----+        up      +y  +y  -z  +z  +y  +y
//      | +x  | +z  | -x  | -z  |
//      +-----+-----+-----+-----+        the order of faces, and of `face_of()`
//            | -y  |
//            +-----+
//
// A face is drawn as the light sees it; the face of a cube map on a device is the same picture mirrored left to right.
std::vector<View> light_views(const Light& light, const glm::vec3& low, const glm::vec3& high);
inline constexpr int light_faces = 6;
inline constexpr const char* face_names[light_faces] = {"px", "nx", "py", "ny", "pz", "nz"};
inline int map_count(const Light& light) { return light.type == LightType::point ? light_faces : 1; }

// False where all of [low, high] lies outside the view's pyramid: nothing can be seen.
bool may_see(const View& view, const glm::vec3& low, const glm::vec3& high);

// Where x falls on a map of size x size texels: (0, 0) is the top left corner of the first texel, its centre (0.5,
// 0.5). Meaningful in front of the light only.
glm::dvec2 project_to_texels(const View& view, int size, const glm::dvec3& x);

// The same for kernels: composed in double and rounded once. `clamped` holds the projection on the map.
Projection projection_args(const View& view, int size, bool clamped);

// Cosines are computed in double and rounded once. Throws InputError for a radius that is not 0, below or above these, or of
// a directional light.
LightArgs light_args(const Light& light);

}  // namespace plumb::raster
