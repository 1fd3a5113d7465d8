// The stages rsm.disc, rsm.paths and rsm.all bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/rsm/gather.h"
#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

const StageBinding& disc_binding();
const StageBinding& paths_binding();
const StageBinding& all_binding();

GatherUniforms gather_uniforms(const GatherParams& params, const GatherInputs& inputs);

// One dispatch of params.gather (not all_rays) for the map inputs.rsm, with copies of all it reads; label and id are the
// caller's.
StageData gather_data(const GatherParams& params, const GatherInputs& inputs);

// Offsets are whole texels of 16 bits each: the largest |dx| or |dy| of them.
int reach_of(std::span<const std::int32_t> offsets);

}  // namespace plumb::rsm
