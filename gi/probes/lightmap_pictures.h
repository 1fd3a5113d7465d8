// Pictures of a lightmap that was checked: on the map, and in the scene as its camera sees it.
#pragma once

#include "gi/probes/debug_layers.h"
#include "gi/probes/lightmap_check.h"

namespace plumb::probes {

inline constexpr double picture_swing = 0.5;  // relative error of full colour

// "truth", "map", "error" (signed, noise taken off), "seams", "leaks", each also as ".scene".
std::vector<DebugLayer> lightmap_pictures(const Image4& map, const Lightmap& lightmap, const ReceiverIrradiance& truth,
                                          const LightmapCheck& check, const CheckParams& params, const DebugView& view,
                                          const RunOptions& options);

}  // namespace plumb::probes
