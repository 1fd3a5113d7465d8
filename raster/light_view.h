// The view through which a light sees, and the light's constants as kernels read them.
#pragma once

#include <glm/glm.hpp>

#include "core/scene.h"
#include "core/view.h"
#include "raster/light_kernel.h"

namespace plumb::raster {

// A spot sees through a square pyramid around its outer cone; a directional light through a box around the bounding
// sphere of [low, high], so that every vertex is inside. Depth is reversed: a float then resolves the same share of the
// distance everywhere. What is nearer to a spot than 1e-6 of its farthest point is cut off. Up is +Y, or +Z where the
// light points within 2.6 degrees (cosine 0.999) of the vertical. Throws InputError for a point light (it needs six
// views) and for a light whose cone or direction is unusable.
View light_view(const Light& light, const glm::vec3& low, const glm::vec3& high);

// Where x falls on a map of size x size texels: (0, 0) is the top left corner of the first texel, its centre (0.5,
// 0.5). Meaningful in front of the light only.
glm::dvec2 project_to_texels(const View& view, int size, const glm::dvec3& x);

// Cosines are computed in double and rounded once.
LightArgs light_args(const Light& light);

}  // namespace plumb::raster
