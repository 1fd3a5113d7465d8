#include "core/shade_rows.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/log_blur_kernel.h"
#include "gi/direct/shadow_kernel.h"
#include "gi/direct/visibility_filter_kernel.h"

namespace plumb {

template struct Rows<direct::LogBlurKernel, Isa::PLUMB_ISA>;
template struct Rows<direct::ShadowKernel, Isa::PLUMB_ISA>;
template struct Rows<direct::VisibilityFilterKernel, Isa::PLUMB_ISA>;
template struct Rows<direct::DirectKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
