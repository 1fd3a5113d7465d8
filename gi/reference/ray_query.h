// Builds the ray query of a scene with Embree. See core/ray_query.h.
#pragma once

#include <memory>

#include "core/ray_query.h"
#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::reference {

// The arguments must outlive the result: alpha masks are read from `surfaces`. Throws InputError where Embree refuses
// the geometry or memory runs out.
std::unique_ptr<RayQuery> build_ray_query(const Geometry& geometry, const raster::Surfaces& surfaces, Rays rays);

}  // namespace plumb::reference
