#include "core/kernel_stage.h"
#include "gi/filter/filter.h"
#include "twins/gi.filter.blur.comp.h"
#include "twins/gi.filter.reduce.comp.h"
#include "twins/gi.filter.upsample.comp.h"

namespace plumb {

using namespace filter;

template <>
const StageBinding& stage<ReduceKernel>() { return made<ReduceKernel, twins::gi_filter_reduce_comp>(); }
template <>
const StageBinding& stage<UpsampleKernel>() { return made<UpsampleKernel, twins::gi_filter_upsample_comp>(); }
template <>
const StageBinding& stage<BlurKernel>() { return made<BlurKernel, twins::gi_filter_blur_comp>(); }

}  // namespace plumb
