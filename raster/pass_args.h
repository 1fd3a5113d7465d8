// The kernels' arguments of a pass, without its targets: what draws, explains and binds it starts from.
#pragma once

#include "core/scene.h"
#include "core/view.h"
#include "raster/gbuffer_kernel.h"
#include "raster/rsm_kernel.h"
#include "raster/surfaces.h"

namespace plumb::raster {

GBufferArgs gbuffer_args(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size);
RsmArgs rsm_args(const Geometry& geometry, const Surfaces& surfaces, const Light& light, const View& light_view);

}  // namespace plumb::raster
