// The stages compose and tonemap bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/compose/compose.h"
#include "gi/compose/compose_kernel.h"

namespace plumb::compose {

const StageBinding& compose_binding();
const StageBinding& tonemap_binding();

ComposeUniforms uniforms(const ComposeParams& params, const ComposeInputs& inputs);
TonemapUniforms uniforms(const TonemapParams& params, const Image4& radiance);

// One dispatch, with copies of all it reads; label and id are the caller's.
StageData compose_data(const ComposeParams& params, const ComposeInputs& inputs);
StageData tonemap_data(const TonemapParams& params, const Image4& radiance);

}  // namespace plumb::compose
