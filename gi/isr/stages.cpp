#include "core/kernel_stage.h"
#include "gi/isr/isr.h"
#include "twins/gi.isr.blur.comp.h"
#include "twins/gi.isr.bounce.comp.h"
#include "twins/gi.isr.compose.comp.h"
#include "twins/gi.isr.downsample.comp.h"
#include "twins/gi.isr.gather.comp.h"
#include "twins/gi.isr.gather_camera.comp.h"
#include "twins/gi.isr.ssao.comp.h"
#include "twins/gi.isr.unseen.comp.h"
#include "twins/gi.isr.upsample.comp.h"

namespace plumb {

using namespace isr;

template <>
const StageBinding& stage<DownsampleKernel>() { return made<DownsampleKernel, twins::gi_isr_downsample_comp>(); }
template <>
const StageBinding& stage<GatherKernel>() { return made<GatherKernel, twins::gi_isr_gather_comp>(); }
template <>
const StageBinding& stage<SsaoKernel>() { return made<SsaoKernel, twins::gi_isr_ssao_comp>(); }
template <>
const StageBinding& stage<BounceKernel>() { return made<BounceKernel, twins::gi_isr_bounce_comp>(); }
template <>
const StageBinding& stage<UnseenKernel>() { return made<UnseenKernel, twins::gi_isr_unseen_comp>(); }
template <>
const StageBinding& stage<GatherCameraKernel>() { return made<GatherCameraKernel, twins::gi_isr_gather_camera_comp>(); }
template <>
const StageBinding& stage<BlurKernel>() { return made<BlurKernel, twins::gi_isr_blur_comp>(); }
template <>
const StageBinding& stage<UpsampleKernel>() { return made<UpsampleKernel, twins::gi_isr_upsample_comp>(); }
template <>
const StageBinding& stage<ComposeKernel>() { return made<ComposeKernel, twins::gi_isr_compose_comp>(); }

}  // namespace plumb
