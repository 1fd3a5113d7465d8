#include "core/kernel_stage.h"
#include "gi/screen/screen.h"
#include "twins/gi.screen.blur.comp.h"
#include "twins/gi.screen.horizon.comp.h"
#include "twins/gi.screen.occlude.comp.h"
#include "twins/gi.screen.reuse.comp.h"
#include "twins/gi.screen.ssao.comp.h"

namespace plumb {

template <>
const StageBinding& stage<screen::SsaoKernel>() { return made<screen::SsaoKernel, twins::gi_screen_ssao_comp>(); }
template <>
const StageBinding& stage<screen::HorizonKernel>() { return made<screen::HorizonKernel, twins::gi_screen_horizon_comp>(); }
template <>
const StageBinding& stage<screen::BlurKernel>() { return made<screen::BlurKernel, twins::gi_screen_blur_comp>(); }
template <>
const StageBinding& stage<screen::OccludeKernel>() { return made<screen::OccludeKernel, twins::gi_screen_occlude_comp>(); }
template <>
const StageBinding& stage<screen::ReuseKernel>() { return made<screen::ReuseKernel, twins::gi_screen_reuse_comp>(); }

}  // namespace plumb
