// The stages of gi/isr bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

const StageBinding& downsample_binding();
const StageBinding& gather_binding();
const StageBinding& ssao_binding();
const StageBinding& bounce_binding();
const StageBinding& unseen_binding();
const StageBinding& gather_camera_binding();
const StageBinding& blur_binding();
const StageBinding& upsample_binding();
const StageBinding& compose_binding();

// One dispatch, with copies of all it reads; label and id are the caller's.
StageData downsample_data(const IsrParams& params, Coarse what, const DownsampleInputs& inputs);
StageData gather_data(const IsrParams& params, const GatherInputs& inputs);
StageData ssao_data(const IsrParams& params, const SsaoInputs& inputs);
StageData bounce_data(const IsrParams& params, const BounceInputs& inputs);
StageData unseen_data(const IsrParams& params, const UnseenInputs& inputs);
StageData gather_camera_data(const IsrParams& params, const CameraGatherInputs& inputs);
StageData blur_data(const IsrParams& params, const BlurInputs& inputs);
StageData upsample_data(const IsrParams& params, const UpsampleInputs& inputs);
StageData compose_data(const IsrParams& params, const ComposeInputs& inputs);

}  // namespace plumb::isr
