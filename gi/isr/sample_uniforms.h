// The block of a gather, which the stages of additional cameras have as a part of theirs.
#pragma once

#include "gi/isr/gather.h"

namespace plumb::isr {

SampleUniforms uniforms(const IsrParams& params, const GatherInputs& in);

// Lends the pattern's offsets; throws InputError for a pattern of other parameters.
void lend_offsets(StageData& data, const char* stage, const Pattern* pattern, int rings, const IsrParams& params);

}  // namespace plumb::isr
