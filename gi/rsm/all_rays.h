// The stage rsm.all_rays behind the functions of gather.h: which texels are asked, and how far rays keep off surfaces.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gi/rsm/gather.h"
#include "raster/layout.h"

namespace plumb::rsm {

// How many of `texels` each of `points` asks: all of them, or, where that takes more than params.max_rays rays, 16 times
// the largest power of two that keeps within (at least 16).
std::uint64_t texels_asked(const GatherParams& params, std::uint64_t points, std::uint64_t texels);

// By how much positions may lie off their surfaces: rounding in the rasterizer, in proportion to the largest coordinate
// of the scene's bounds, and that of the layout's formats. `view` and `size` are the camera's and the frame's. See
// gi/rsm/README.md.
RayOffsets ray_offsets(const raster::Layout& layout, const glm::vec3& low, const glm::vec3& high, const View& view,
                       glm::ivec2 size);

// What the run did, for its reason: "subset of 512 of 250101 lit texels a pixel".
std::string summary(const RaysReport& report);

// The kernels' constants, gather_data.cpp.
float least_distance2(const GatherParams& params);   // m2: the floor of |x - x_p|^2
float irradiance_scale(const GatherParams& params);  // 1/pi; published: 1

// What run_maps() and explain_maps() of gather.h call.
void run_all_rays(const GatherParams& params, const GatherInputs& inputs, std::span<const raster::Rsm> maps,
                  const RunOptions& options, Image4& irradiance, RaysReport* report);
std::vector<TapValue> explain_all_rays(const GatherParams& params, const GatherInputs& inputs,
                                       std::span<const raster::Rsm> maps, glm::ivec2 pixel);

}  // namespace plumb::rsm
