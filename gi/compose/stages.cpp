#include "core/kernel_stage.h"
#include "gi/compose/compose.h"
#include "twins/gi.compose.compose.comp.h"
#include "twins/gi.compose.tonemap.comp.h"

namespace plumb {

template <>
const StageBinding& stage<compose::ComposeKernel>() { return made<compose::ComposeKernel, twins::gi_compose_compose_comp>(); }
template <>
const StageBinding& stage<compose::TonemapKernel>() { return made<compose::TonemapKernel, twins::gi_compose_tonemap_comp>(); }

}  // namespace plumb
