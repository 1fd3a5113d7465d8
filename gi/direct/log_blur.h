// The stage shadow.blur: the depth maps of mode = esm, blurred before points are compared with them (ISR 4.6). See
// gi/direct/README.md.
#pragma once

#include <span>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/stage.h"
#include "core/tap.h"
#include "gi/direct/direct.h"

namespace plumb::direct {

// Whether the maps are blurred: mode = esm with a radius, unless it is 0.
bool blurs_maps(const ShadowParams& params);

// What c is divided by, m, one number for all maps of a light: the depth of a directional light's box, or the farthest
// far plane. Maps that were not drawn count by their view; 1 m where no view says.
double depth_range(std::span<const raster::Rsm> rsms);
// c of ISR (30) for depths in m: esm_c / depth_range, 1/m.
float c_per_metre(const ShadowParams& params, std::span<const raster::Rsm> rsms);

enum class Direction : int { horizontal, vertical };

struct LogBlurInputs {
    const Image4* map = nullptr;  // w: linear depth, m; 0 where nothing is
    Direction direction = Direction::horizontal;
    double range = 1;             // m: depth_range()
};
// One dispatch. blurred: w linear depth, m, 0 where no tap has anything; xyz 0.
void run(const ShadowParams& params, const LogBlurInputs& inputs, const RunOptions& options, Image4& blurred);
// Along the rows, then along the columns: each map of a light. Maps of size 0 stay empty images.
void blur_maps(const ShadowParams& params, std::span<const raster::Rsm> rsms, const RunOptions& options,
               std::vector<Image4>& blurred);

// exp(-i^2 / (2 sigma^2)), [2 radius + 1], made in double precision; none is below 2^-100.
Buffer<float> blur_weights(const ShadowParams& params);

std::vector<TapValue> explain(const ShadowParams& params, const LogBlurInputs& inputs, glm::ivec2 texel);
StageInfo log_blur_info();

}  // namespace plumb::direct
