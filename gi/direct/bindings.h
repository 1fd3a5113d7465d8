// The stages shadow.blur, shadow and direct bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/direct/direct.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/log_blur.h"
#include "gi/direct/log_blur_kernel.h"
#include "gi/direct/shadow_kernel.h"

namespace plumb::direct {

const StageBinding& log_blur_binding();
const StageBinding& shadow_binding();
const StageBinding& direct_binding();

LogBlurUniforms log_blur_uniforms(const ShadowParams& params, const LogBlurInputs& inputs);
void validate(const ShadowParams& params, const LogBlurInputs& inputs);

// What the shadow test of that map reads: its own depth, or the blurred one.
const Image4& map_of(const ShadowInputs& inputs, int face);

// Of the dispatch that reads inputs.rsms[face].
ShadowUniforms shadow_uniforms(const ShadowParams& params, const ShadowInputs& inputs, int face);

DirectUniforms direct_uniforms(const DirectParams& params, const DirectInputs& inputs);

// One dispatch, with copies of all it reads; label and id are the caller's.
StageData log_blur_data(const ShadowParams& params, const LogBlurInputs& inputs);
StageData shadow_data(const ShadowParams& params, const ShadowInputs& inputs, int face);
StageData direct_data(const DirectParams& params, const DirectInputs& inputs);

}  // namespace plumb::direct
