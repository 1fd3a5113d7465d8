#include "core/kernel_stage.h"
#include "gi/screen/screen.h"
#include "twins/gi.screen.blur.comp.h"
#include "twins/gi.screen.cells.comp.h"
#include "twins/gi.screen.horizon.comp.h"
#include "twins/gi.screen.lobe.comp.h"
#include "twins/gi.screen.mirror.comp.h"
#include "twins/gi.screen.nearest.comp.h"
#include "twins/gi.screen.occlude.comp.h"
#include "twins/gi.screen.reflect.comp.h"
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
template <>
const StageBinding& stage<screen::LobeKernel>() { return made<screen::LobeKernel, twins::gi_screen_lobe_comp>(); }
template <>
const StageBinding& stage<screen::ReflectKernel>() { return made<screen::ReflectKernel, twins::gi_screen_reflect_comp>(); }
template <>
const StageBinding& stage<screen::NearestKernel>() { return made<screen::NearestKernel, twins::gi_screen_nearest_comp>(); }
template <>
const StageBinding& stage<screen::CellsKernel>() { return made<screen::CellsKernel, twins::gi_screen_cells_comp>(); }
template <>
const StageBinding& stage<screen::MirrorKernel>() { return made<screen::MirrorKernel, twins::gi_screen_mirror_comp>(); }

}  // namespace plumb
