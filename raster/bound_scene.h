// What a raster stage draws, rebuilt from named arrays that nobody vouches for.
#pragma once

#include "core/binding.h"
#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::raster {

struct BoundScene {
    Geometry geometry;
    Surfaces surfaces;
    Buffer<glm::vec4> clip_positions;  // a vertex each
};

// Copies the inputs of the stages gbuffer and rsm, whose slots were checked (check_slots). Every index that a kernel
// follows is in range afterwards, and every clip position is finite; else throws InputError "<label>: <cause>".
BoundScene bound_scene(const StageData& data);

// The kernels' view of it, for a viewer and a footprint as the uniform block has them.
SurfaceArgs surface_args(const BoundScene& scene, const float viewer[4], const float forward[3], float pixel_area);

}  // namespace plumb::raster
