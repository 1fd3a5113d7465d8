#include "core/shade_rows.h"
#include "gi/compose/compose_kernel.h"
#include "gi/compose/tonemap_kernel.h"

namespace plumb {

template struct Rows<compose::ComposeKernel, Isa::PLUMB_ISA>;
template struct Rows<compose::TonemapKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
