// Cells of hemicube radiosity's stages that have a twin: what a hemicube sees, irradiance gathered by rows, and looked up at pixels.
#pragma once

#include "gi/stability/bake.h"

namespace plumb::stability {

// Dispatches of a scene as it is, without finer meshes: hemicubes of some of its elements, each block of rows from hemicubes of 16
// under what leaves elements after some passes, and points of its triangles. They own their inputs.
std::vector<StageData> radiosity_data(const Scene& scene, const RunOptions& options);

// What no scene of the other cases has: hemicubes of 2 and 1024, slivers, eyes in walls, areas of a million to one.
void add_radiosity_cases(std::vector<BakeCase>& cases);

}  // namespace plumb::stability
