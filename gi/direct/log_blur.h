// The stage shadow.blur: the depth maps of mode = esm, blurred before points are compared with them (ISR 4.6). See
// gi/direct/README.md.
#pragma once

#include <span>
#include <vector>

#include "gi/direct/log_blur_kernel.h"
#include "gi/direct/shadow.h"

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
    using Kernel = LogBlurKernel;
    const Image4* map = nullptr;  // w: linear depth, m; 0 where nothing is
    Direction direction = Direction::horizontal;
    double range = 1;             // m: depth_range()
};

inline constexpr const char* log_blur_stage = "shadow.blur";

inline StageDescription<LogBlurInputsView> describe(LogBlurKernel) {
    using View = LogBlurInputsView;
    ShadowParams defaults;
    return {
        .name = log_blur_stage,
        .source = "ISR 4.6 (logarithmic blur of the shadow map)",
        .domain = "texel",
        .inputs = {{.name = "depth_map", .at = &View::depth_map, .unit = "m",
                    .meaning = "w: linear light-space depth; 0 where nothing is"},
                   {.name = "spatial", .at = &View::spatial, .meaning = "[2 radius + 1]: Gaussian of the distance",
                    .count = [](const View& v) { return std::size_t(2 * v.u.radius + 1); },
                    .why = "a weight for each texel of the row or the column"}},
        .outputs = {{.name = "blurred", .at = &View::blurred, .unit = "m",
                     .meaning = "w: blurred depth; 0 where no tap has anything"}},
        .params = plumb::describe(fields(defaults), {"esm_c", "esm_blur_radius", "esm_blur_sigma"}),
        .uniforms = {{"radius", 0, most_blur_radius}},
        .cost = {3, "samples"},
    };
}

// One dispatch. blurred: w linear depth, m, 0 where no tap has anything; xyz 0.
StageData data_of(const ShadowParams& params, const LogBlurInputs& in);

// Along the rows, then along the columns: each map of a light. Maps of size 0 stay empty images.
void blur_maps(const ShadowParams& params, std::span<const raster::Rsm> rsms, const RunOptions& options,
               std::vector<Image4>& blurred);

// exp(-i^2 / (2 sigma^2)), [2 radius + 1], made in double precision; none is below 2^-100.
Buffer<float> blur_weights(const ShadowParams& params);

}  // namespace plumb::direct
