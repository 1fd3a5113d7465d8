// What Phong's lobes at given points gather: the truth of rough reflections.
#pragma once

#include "gi/reference/cache.h"

namespace plumb::reference {

// Of Phong's lobe at given points, as if its reflectance were 1, what it sends to the eye of all light that arrives but that
// of lamps that shine on the points themselves: no ray meets a point light. points.normal: w exponent of the lobe.
Estimate trace_lobes(const PathParams& params, const PathScene& scene, const PointInputs& points, const glm::dvec3& eye,
                     std::uint32_t seed, const RunOptions& options);
// As the others of gi/reference/cache.h.
std::uint64_t cache_key_of_lobes(const PathParams& params, const Scene& scene, const Geometry& geometry,
                                 const PointInputs& points, const glm::dvec3& eye, std::uint32_t seed, Isa isa);

}  // namespace plumb::reference
