// The stages shadow and direct bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/direct/direct.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/shadow_kernel.h"

namespace plumb::direct {

const StageBinding& shadow_binding();
const StageBinding& direct_binding();

// Of the dispatch that reads inputs.rsms[face].
ShadowUniforms shadow_uniforms(const ShadowParams& params, const ShadowInputs& inputs, int face);

DirectUniforms direct_uniforms(const DirectParams& params, const DirectInputs& inputs);

// One dispatch, with copies of all it reads; label and id are the caller's.
StageData shadow_data(const ShadowParams& params, const ShadowInputs& inputs, int face);
StageData direct_data(const DirectParams& params, const DirectInputs& inputs);

}  // namespace plumb::direct
