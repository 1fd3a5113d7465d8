// Dispatches of the stages that look up the lightmap for pixels (probes.lightmap_uv, probes.lookup), for cells of a small bake.
#pragma once

#include <vector>

#include "core/stage.h"
#include "gi/probes/bake.h"

namespace plumb::stability {

// Some of the bake's receivers as pixels, seen by a viewer at the first of them, with three levels of detail; on a lightmap that
// varies from texel to texel. They own their inputs.
std::vector<StageData> lookup_data(const probes::Bake& bake);

}  // namespace plumb::stability
