// What isr.unseen and isr.gather_camera share with their bindings: checks, and the uniform blocks of their kernels.
#pragma once

#include "gi/isr/gather_camera_kernel.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

// Throw InputError that names stage and input.
void validate(const IsrParams& params, const UnseenInputs& inputs);
void validate(const IsrParams& params, const CameraGatherInputs& inputs);

UnseenUniforms uniforms(const IsrParams& params, const UnseenInputs& inputs);
GatherCameraUniforms uniforms(const IsrParams& params, const CameraGatherInputs& inputs);

}  // namespace plumb::isr
