// filter.upsample: half-size irradiance becomes irradiance of every pixel (VRSM 4.5, fig. 4.4).
#pragma once

#include "core/stage_description.h"
#include "gi/filter/filter_params.h"
#include "gi/filter/upsample_kernel.h"
#include "raster/covered.h"

namespace plumb::filter {

struct UpsampleInputs {
    using Kernel = UpsampleKernel;
    const Image4* coarse_irradiance = nullptr;
    const Image4* coarse_position = nullptr;
    const Image4* coarse_normal = nullptr;
    const Image4* position = nullptr;
    const Image4* normal = nullptr;
    const raster::Covered* tiles = nullptr;  // the others get 0; null: all are computed
};

inline StageDescription<UpsampleInputsView> describe(UpsampleKernel) {
    using View = UpsampleInputsView;
    const auto half = [](const View& v) { return half_size({v.u.width, v.u.height}); };
    const std::string why = "half of the outputs, rounded up";
    return {
        .name = "filter.upsample",
        .source = "VRSM 4.5 (the indirect illumination buffer is first upsampled), fig. 4.4",
        .domain = "pixel",
        .inputs = {{.name = "coarse_irradiance", .at = &View::coarse_irradiance, .unit = "W/m2",
                    .meaning = "at half size; w: linear depth, m", .size = half, .why = why},
                   {.name = "coarse_position", .at = &View::coarse_position, .unit = "m",
                    .meaning = "world-space position at half size", .size = half, .why = why},
                   {.name = "coarse_normal", .at = &View::coarse_normal, .meaning = "unit normal at half size",
                    .size = half, .why = why},
                   {.name = "position", .at = &View::position, .unit = "m",
                    .meaning = "world-space position; w: linear depth"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal"}},
        .outputs = {{.name = "upsampled", .at = &View::upsampled, .unit = "W/m2",
                     .meaning = "irradiance of every pixel; w: linear depth, m"}},
        .params = params_of({"upsample", "similarity", "sigma_depth", "sigma_normal"}),
        .uniforms = {{"mode", 0, int(Upsample::published)}, {"similarity", 0, int(Similarity::depth)}},
        .prepare = [](View& v, Buffer<float>&) {
            const glm::ivec2 size = half_size({v.u.width, v.u.height});
            v.u.coarse_width = size.x, v.u.coarse_height = size.y;
        },
        .cost = {8, "pixels"},
    };
}

StageData data_of(const FilterParams& params, const UpsampleInputs& in);

}  // namespace plumb::filter
