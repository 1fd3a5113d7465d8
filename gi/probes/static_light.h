// Lamps that shine on places in the air (IPR 5.2.1.5): what moves is lit by them as by everything that is known of the static scene.
#pragma once

#include "core/ray_query.h"
#include "core/scene.h"
#include "gi/probes/spatial.h"

namespace plumb::probes {

// [place][direction], as gather_grid() has it: irradiance of those lamps at each place along the six directions, W/m2, weighed as the
// bake weighs radiance (spatial_weight). query: of the static scene; what lies between lamp and place shadows it. `offset`: m, how far
// rays keep off the lamp.
Buffer<glm::vec4> static_light(const Spatial& spatial, SpatialWeight weight, const std::vector<Light>& lamps, const RayQuery& query,
                               float offset);

}  // namespace plumb::probes
