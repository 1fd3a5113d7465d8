// Data of the stages that relight probes (probes.radiance, probes.lambda): of a small bake, and by hand.
#pragma once

#include "gi/probes/bake.h"
#include "gi/stability/bake.h"

namespace plumb::stability {

// Of a bake whose probes stand: 130 relight rays of each as the scene has them, two levels of detail, and a lightmap of random
// numbers. What lights would bring stands for itself: 1 W/m2.
std::vector<StageData> relight_data(const Scene& scene, const probes::BakeGraph& graph, const RunOptions& options);

// Data that no scene has: fields that cancel, numbers far apart, places on the edge of texels.
std::vector<BakeCase> relight_cases();

}  // namespace plumb::stability
