// The ray query on a device of one's own: how tests choose Embree's instruction set.
#pragma once

#include <string>

#include "gi/reference/ray_query.h"

namespace plumb::reference {

// `config` as rtcNewDevice takes it, as in "isa=sse4.2"; "": the device that the process shares.
std::unique_ptr<RayQuery> build_ray_query(const Geometry& geometry, const raster::Surfaces& surfaces, Rays rays,
                                          const std::string& config);

}  // namespace plumb::reference
