// The stages filter.reduce, filter.upsample and filter.blur bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/filter/blur_kernel.h"
#include "gi/filter/filter.h"
#include "gi/filter/reduce_kernel.h"

namespace plumb::filter {

const StageBinding& reduce_binding();
const StageBinding& upsample_binding();
const StageBinding& blur_binding();

ReduceUniforms uniforms(const Image4& image);
UpsampleUniforms uniforms(const FilterParams& params, const UpsampleInputs& inputs);
BlurUniforms uniforms(const FilterParams& params, const BlurInputs& inputs);

void validate(const FilterParams& params, const UpsampleInputs& inputs);
void validate(const FilterParams& params, const BlurInputs& inputs);

// One dispatch, with copies of all it reads; label and id are the caller's.
StageData reduce_data(const Image4& image);
StageData upsample_data(const FilterParams& params, const UpsampleInputs& inputs);
StageData blur_data(const FilterParams& params, const BlurInputs& inputs);

}  // namespace plumb::filter
