// The stages rsm.disc, rsm.paths, both with continuous texels, and rsm.all bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/rsm/gather.h"
#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

const StageBinding& disc_binding();
const StageBinding& paths_binding();
const StageBinding& disc_continuous_binding();
const StageBinding& paths_continuous_binding();
const StageBinding& all_binding();

GatherUniforms gather_uniforms(const GatherParams& params, const GatherInputs& inputs);

// One dispatch of params.gather (not all_rays) for the map inputs.rsm, with copies of all it reads; label and id are the
// caller's.
StageData gather_data(const GatherParams& params, const GatherInputs& inputs);

// Texels: the largest |dx| or |dy| of whole-texel offsets; of positions a texel more, rounded up.
int reach_of(const Pattern& pattern);

}  // namespace plumb::rsm
