#include "core/kernel_stage.h"
#include "gi/direct/direct.h"
#include "gi/direct/log_blur.h"
#include "gi/direct/visibility_filter.h"
#include "twins/gi.direct.direct.comp.h"
#include "twins/gi.direct.log_blur.comp.h"
#include "twins/gi.direct.shadow.comp.h"
#include "twins/gi.direct.visibility_filter.comp.h"

namespace plumb {

template <>
const StageBinding& stage<direct::LogBlurKernel>() { return made<direct::LogBlurKernel, twins::gi_direct_log_blur_comp>(); }
template <>
const StageBinding& stage<direct::ShadowKernel>() { return made<direct::ShadowKernel, twins::gi_direct_shadow_comp>(); }
template <>
const StageBinding& stage<direct::VisibilityFilterKernel>() {
    return made<direct::VisibilityFilterKernel, twins::gi_direct_visibility_filter_comp>();
}
template <>
const StageBinding& stage<direct::DirectKernel>() { return made<direct::DirectKernel, twins::gi_direct_direct_comp>(); }

}  // namespace plumb
