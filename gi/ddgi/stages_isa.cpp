#include "core/shade_rows.h"
// After core/wide.h, so that the kernels see their number.
#include "gi/ddgi/blend_kernel.h"
#include "gi/ddgi/border_kernel.h"
#include "gi/ddgi/sample_kernel.h"

namespace plumb {

template struct Rows<ddgi::BlendKernel, Isa::PLUMB_ISA>;
template struct Rows<ddgi::BorderKernel, Isa::PLUMB_ISA>;
template struct Rows<ddgi::SampleKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
