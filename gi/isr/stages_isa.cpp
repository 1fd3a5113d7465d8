#include "core/shade_rows.h"
#include "gi/isr/bounce_kernel.h"
#include "gi/isr/compose_kernel.h"
#include "gi/isr/downsample_kernel.h"
#include "gi/isr/gather_camera_kernel.h"
#include "gi/isr/unseen_kernel.h"

namespace plumb {

template struct Rows<isr::DownsampleKernel, Isa::PLUMB_ISA>;
template struct Rows<isr::BounceKernel, Isa::PLUMB_ISA>;
template struct Rows<isr::UnseenKernel, Isa::PLUMB_ISA>;
template struct Rows<isr::GatherCameraKernel, Isa::PLUMB_ISA>;
template struct Rows<isr::ComposeKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
