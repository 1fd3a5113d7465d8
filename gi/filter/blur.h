// filter.blur: the edge-aware blur of VRSM 4.5, all of its kernel, or a row or a column of it.
#pragma once

#include "core/stage_description.h"
#include "gi/filter/blur_kernel.h"
#include "gi/filter/filter_params.h"
#include "raster/covered.h"

namespace plumb::filter {

enum class Direction : int { both, horizontal, vertical };

struct BlurInputs {
    using Kernel = BlurKernel;
    const Image4* irradiance = nullptr;
    const Image4* position = nullptr;
    const Image4* normal = nullptr;
    Direction direction = Direction::both;  // params.blur is not read
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<BlurInputsView> describe(BlurKernel) {
    using View = BlurInputsView;
    return {
        .name = "filter.blur",
        .source = "VRSM 4.5 (edge-aware blur, kernel 17)",
        .domain = "pixel",
        .inputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "w: linear depth, m"},
                   {.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal"},
                   {.name = "spatial", .at = &View::spatial,
                    .meaning = "[2 radius_y + 1][2 radius_x + 1]: Gaussian of the distance; 0 in the middle",
                    .count = [](const View& v) { return std::size_t(2 * v.u.radius_x + 1) * std::size_t(2 * v.u.radius_y + 1); },
                    .why = "a weight for each pixel of the kernel"}},
        .outputs = {{.name = "blurred", .at = &View::blurred, .unit = "W/m2", .meaning = "irradiance; w: linear depth, m"}},
        .params = params_of({"blur", "kernel", "sigma_distance", "similarity", "sigma_depth", "sigma_normal"}),
        .uniforms = {{"similarity", 0, int(Similarity::depth)},
                     {"radius_x", 0, BlurPlanes::padding},
                     {"radius_y", 0, BlurPlanes::padding}},
        .cost = {0.2, "samples"},
    };
}

StageData data_of(const FilterParams& params, const BlurInputs& in);

// exp(-(dx^2 + dy^2) / (2 sigma^2)), [2 radius_y + 1][2 radius_x + 1], made in double precision; 0 in the middle, whose
// weight the kernel knows.
Buffer<float> spatial_weights(const FilterParams& params, Direction direction);

// The blur of params.blur: nothing, one dispatch, or two; automatic is separable.
void run_blur(const FilterParams& params, const BlurInputs& in, const RunOptions& options, Image4& blurred);

}  // namespace plumb::filter
