// Form factors by hemicubes, beside what they are held against; and how a hemicube errs as it turns about its normal.
#pragma once

#include <functional>
#include <vector>

#include "core/isa.h"
#include "core/scene.h"
#include "gi/radiosity/ray_form_factors.h"
#include "gi/radiosity/texel_weights.h"
#include "raster/surfaces.h"

namespace plumb::radiosity {

// The mean over points of what their hemicubes see of target 0; targets as for rays: of triangle t's front and of its
// back. The eye stands `offset` off the surface, its near plane is half of that. surfaces: null: no material has holes.
double hemicube_form_factor(const Geometry& geometry, const raster::Surfaces* surfaces,
                            const std::vector<SourcePoint>& points, const std::vector<std::int32_t>& targets, int size,
                            Weights weights, double offset, const RunOptions& options);

// Which triangles are target 0 as seen from `eye`, by the side that they turn to it.
std::vector<bool> counted_from(const Geometry& geometry, const std::vector<std::int32_t>& targets, const glm::dvec3& eye);

// Of a patch opposite the middle of a unit square at distance 1, turned by 0..90 degrees in steps of 1: error in % of
// 0.239456470460774 (Howell's B-3), verification.md 3. One position says little: aliasing is not monotone in the size.
struct RotationErrors {
    double rms = 0, largest = 0;  // %
};
RotationErrors rotation_errors(int size, Weights weights, const RunOptions& options);
// The same of anything that says how much of all triangles is seen from the origin along +y.
RotationErrors rotation_errors(const std::function<double(const Geometry&)>& seen);

}  // namespace plumb::radiosity
