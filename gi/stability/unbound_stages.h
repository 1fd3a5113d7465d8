// The cells of the stages that bind no data, one stage each. Parts of unbound.cpp.
#pragma once

#include "gi/reference/path_args.h"
#include "gi/reference/reference.h"
#include "gi/rsm/gather.h"
#include "gi/stability/unbound_look.h"
#include "raster/surfaces.h"
#include "raster/visibility.h"

namespace plumb::stability {

// The world-space geometry of a scene and its materials, as they are drawn.
struct Drawable {
    Geometry geometry;
    raster::Surfaces surfaces;
};
Drawable drawable(const Scene& scene);

// Picks `wanted` of `count` numbers in the order of a hash.
std::vector<std::size_t> picked(std::size_t count, int wanted);

// Coverage has no double: it is exact, in integers. What is looked at are depth and barycentrics against extended
// precision from the same clip positions; flips are pixels whose centre, seen without snapping to 1/256 pixel, shows
// another triangle.
Cell visibility_cell(const Drawable& drawn, const View& view, glm::ivec2 size, const Effort& effort);

// The surface at the texels of a lightmap of size x size, the triangle and barycentrics given.
Cell texture_space_cell(Drawable drawn, const std::vector<glm::vec2>& uv, int size, const Effort& effort);

// Delta form factors as floats against extended precision, and their sum. Flips as those of visibility.
Cell hemicube_cell(const Drawable& drawn, const glm::dvec3& eye, const glm::dvec3& normal, double near, int size,
                   const Effort& effort);

// Irradiance by shadow rays, with the same answers of the rays in double: of every lit texel, and of a subset.
Cell all_rays_cell(rsm::GatherInputs inputs, const std::vector<raster::Rsm>& maps, const Effort& effort);

// Paths with the same random numbers and the same hits in double: of pixels of a camera.
Cell paths_cell(reference::PathScene& scene, const reference::PathParams& params, const Camera& camera, glm::ivec2 size,
                const Effort& effort);
// The same, of given points.
Cell points_cell(reference::PathScene& scene, const reference::PathParams& params, const Image4& position,
                 const Image4& normal, const Effort& effort);

}  // namespace plumb::stability
