// How large a lightmap must be for a number of receivers: charts do not fill it alike in every scene.
#pragma once

#include "core/isa.h"
#include "core/scene.h"
#include "gi/probes/bake_params.h"

namespace plumb::cli {

// Of a lightmap of so many texels a side; 0 where it has no room for the scene's charts.
int receivers_at(const Scene& scene, probes::BakeParams params, int size, const RunOptions& options);

// The size whose lightmap has about as many receivers, within 0.5 % where there is one. start: where the search begins.
int lightmap_for(const Scene& scene, const probes::BakeParams& params, int receivers, int start, const RunOptions& options);

}  // namespace plumb::cli
