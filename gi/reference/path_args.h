// The arguments of path_kernel.h, as trace() and trace_irradiance() fill them: for who runs the kernel one path at a time.
#pragma once

#include "gi/reference/path_kernel.h"
#include "gi/reference/reference.h"

namespace plumb::reference {

// Of the first round and no samples yet; without a place for the sums. Both point into what they are given. They throw
// what trace() and trace_irradiance() throw.
PathArgs camera_args(const PathParams& params, const PathScene& scene, const Camera& camera, glm::ivec2 size,
                     std::uint32_t seed);
// The points are where anchored() puts them.
PathArgs point_args(const PathParams& params, const PathScene& scene, const PointInputs& points, std::uint32_t seed);

// Positions as the scene has them, from its anchor; where there is no point, they stay.
Image4 anchored(const PathScene& scene, const PointInputs& points);

}  // namespace plumb::reference
