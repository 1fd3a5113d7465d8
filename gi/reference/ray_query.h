// Builds the ray query of a scene with Embree. See core/ray_query.h.
#pragma once

#include <memory>
#include <string>

#include "core/ray_query.h"
#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::reference {

// The arguments must outlive the result: alpha masks are read from `surfaces`. Throws InputError where Embree refuses
// the geometry or memory runs out.
std::unique_ptr<RayQuery> build_ray_query(const Geometry& geometry, const raster::Surfaces& surfaces, Rays rays);

// Of the library that runs, "3.13.5": what native rays find may change with it.
std::string embree_version();

}  // namespace plumb::reference
