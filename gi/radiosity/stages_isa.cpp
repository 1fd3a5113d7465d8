#include "core/shade_rows.h"
// After core/wide.h, so that the kernels see their number.
#include "gi/radiosity/lookup_kernel.h"
#include "gi/radiosity/reduce_kernel.h"

namespace plumb {

template struct Rows<radiosity::LookupKernel, Isa::PLUMB_ISA>;
template struct Rows<radiosity::ReduceKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
