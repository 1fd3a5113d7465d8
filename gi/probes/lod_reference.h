// What the run time computes with levels of detail, in double: for tests and experiments. Without levels: converge.h.
#pragma once

#include <vector>

#include "gi/probes/lod.h"

namespace plumb::probes {

// lambda_ij of radiances [probes][rays], by the rays and to the degree of each probe's level: [probes][coefficients of the bake],
// 0 behind those of the level. IPR (10), 4.2.1.
std::vector<glm::dvec3> lod_lambda(const Bake& bake, const Lod& lod, const Levels& levels, const std::vector<glm::dvec3>& radiance);

// U (Sigma V^T lambda) of receivers that are computed, by the coefficients of each cluster's level; 0 of others. IPR 4.2.2, 4.2.3.
std::vector<glm::dvec3> lod_irradiance(const Bake& bake, const Lod& lod, const Levels& levels, const std::vector<glm::dvec3>& lambda);

}  // namespace plumb::probes
