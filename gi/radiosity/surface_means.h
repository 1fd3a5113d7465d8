// What a material's textures are on the mean around each corner of a triangle.
#pragma once

#include <cstdint>
#include <vector>

#include "core/isa.h"
#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::radiosity {

// Means weighted by the corner's linear interpolant, which is 1 there and 0 at the other two: with them
// sum of area_i rho_i H_i is what the triangle reflects of an irradiance that is linear on it.
struct CornerMean {
    glm::dvec3 reflectance{0}, exitance{0};  // 0..1; W/m2
    double share = 1.0 / 3;                  // of the triangle's area; less where an alpha mask leaves holes
};

// [triangle][3]. Textures are read at level 0, at the centres of n x n equal parts of a triangle, n = 4 to 16 by how many
// texels it shows.
std::vector<CornerMean> corner_means(const Scene& scene, const Geometry& geometry, const raster::Surfaces& surfaces,
                                     const RunOptions& options);

}  // namespace plumb::radiosity
