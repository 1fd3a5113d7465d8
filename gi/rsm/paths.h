// The stage rsm.paths as gather.h runs it. Inputs are validated.
#pragma once

#include "gi/rsm/gather.h"
#include "gi/rsm/paths_kernel.h"

namespace plumb::rsm {

PathsUniforms paths_uniforms(const GatherParams& params, const GatherInputs& inputs);

void run_paths(const GatherParams& params, const GatherInputs& inputs, const RunOptions& options, Image4& irradiance);
void run_paths_double(const GatherParams& params, const GatherInputs& inputs, const RunOptions& options,
                      Image<glm::dvec4>& irradiance);
std::vector<TapValue> explain_paths(const GatherParams& params, const GatherInputs& inputs, glm::ivec2 pixel);

// Of gather.cpp: what both gathers set up alike.
float least_distance2(const GatherParams& params);
float irradiance_scale(const GatherParams& params);
Buffer<float> widened(const Buffer<Half>& halves);  // exact

}  // namespace plumb::rsm
