#include "core/kernel_stage.h"
#include "gi/zbuffer/zbuffer.h"
#include "twins/gi.zbuffer.interpolate.comp.h"
#include "twins/gi.zbuffer.pixels.comp.h"
#include "twins/gi.zbuffer.vertices.comp.h"

namespace plumb {

using namespace zbuffer;

template <>
const StageBinding& stage<VerticesKernel>() { return made<VerticesKernel, twins::gi_zbuffer_vertices_comp>(); }
template <>
const StageBinding& stage<InterpolateKernel>() { return made<InterpolateKernel, twins::gi_zbuffer_interpolate_comp>(); }
template <>
const StageBinding& stage<PixelsKernel>() { return made<PixelsKernel, twins::gi_zbuffer_pixels_comp>(); }

}  // namespace plumb
