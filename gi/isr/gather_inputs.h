// What isr.downsample, isr.gather, isr.ssao and isr.bounce share with their bindings: checks, and the uniform blocks that
// their kernels read.
#pragma once

#include "gi/isr/gather_rows.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

// Throw InputError that names stage and input.
void validate(const IsrParams& params, Coarse what, const DownsampleInputs& inputs);
void validate(const IsrParams& params, const GatherInputs& inputs);
void validate(const IsrParams& params, const SsaoInputs& inputs);
void validate(const BounceInputs& inputs);

DownsampleUniforms uniforms(const IsrParams& params, Coarse what, const DownsampleInputs& inputs);
SampleUniforms uniforms(const IsrParams& params, const GatherInputs& inputs);
SampleUniforms uniforms(const IsrParams& params, const SsaoInputs& inputs);
BounceUniforms uniforms(const BounceInputs& inputs);

// The rows of `plumb stages` for the parameters of these names, in the order of fields().
std::vector<ParamInfo> params_of(std::initializer_list<const char*> names);

}  // namespace plumb::isr
