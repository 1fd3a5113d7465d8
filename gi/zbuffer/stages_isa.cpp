#include "core/shade_rows.h"
#include "gi/zbuffer/interpolate_kernel.h"
#include "gi/zbuffer/pixels_kernel.h"
#include "gi/zbuffer/vertices_kernel.h"

namespace plumb {

template struct Rows<zbuffer::VerticesKernel, Isa::PLUMB_ISA>;
template struct Rows<zbuffer::InterpolateKernel, Isa::PLUMB_ISA>;
template struct Rows<zbuffer::PixelsKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
