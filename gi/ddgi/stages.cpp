#include "core/kernel_stage.h"
#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "twins/gi.ddgi.blend.comp.h"
#include "twins/gi.ddgi.border.comp.h"
#include "twins/gi.ddgi.sample.comp.h"

namespace plumb {

using namespace ddgi;

template <>
const StageBinding& stage<BlendKernel>() { return made<BlendKernel, twins::gi_ddgi_blend_comp>(); }
template <>
const StageBinding& stage<BorderKernel>() { return made<BorderKernel, twins::gi_ddgi_border_comp>(); }
template <>
const StageBinding& stage<SampleKernel>() { return made<SampleKernel, twins::gi_ddgi_sample_comp>(); }

}  // namespace plumb
