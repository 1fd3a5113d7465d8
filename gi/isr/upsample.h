// isr.upsample: coarse irradiance and accessibility become those of every pixel (ISR 4.5, (27), (28)).
#pragma once

#include "core/binding.h"
#include "gi/isr/isr_params.h"
#include "gi/isr/upsample_kernel.h"
#include "raster/covered.h"

namespace plumb::isr {

struct UpsampleInputs {
    using Kernel = UpsampleKernel;
    const Image4* lit = nullptr;       // coarse
    const Image4* surface = nullptr;   // coarse
    const Image4* position = nullptr;  // w: linear eye depth, m
    const Image4* normal = nullptr;    // all 0 where nothing is
    double near = 0, far = 0;          // m
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<UpsampleInputsView> describe(UpsampleKernel) {
    using View = UpsampleInputsView;
    const auto coarse = [](const View& v) { return coarse_size({v.u.width, v.u.height}); };
    const std::string why = "half of the outputs, rounded up";
    return {
        .name = "isr.upsample",
        .source = "ISR 4.5, (27), (28)",
        .domain = "pixel",
        .inputs = {{.name = "lit", .at = &View::lit, .unit = "W/m2", .meaning = "coarse irradiance; w: accessibility",
                    .size = coarse, .why = why},
                   {.name = "surface", .at = &View::surface, .meaning = "coarse unit normal; w: depth", .size = coarse,
                    .why = why},
                   {.name = "position", .at = &View::position, .unit = "m", .meaning = "w: linear eye depth"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal"}},
        .outputs = {{.name = "upsampled", .at = &View::upsampled, .unit = "W/m2",
                     .meaning = "irradiance of every pixel; w: accessibility", .unwritten = {0, 0, 0, 1}}},
        .params = params_of({"variant", "position", "upsample", "epsilon"}),
        .uniforms = {{"bilateral", 0, 1}, {"published", 0, 1}, {"clip_depth", 0, 1}},
        .prepare = [](View& v, Buffer<float>&) {
            const glm::ivec2 size = coarse_size({v.u.width, v.u.height});
            v.u.coarse_width = size.x, v.u.coarse_height = size.y;
        },
        .cost = {4, "pixels"},
    };
}

StageData data_of(const IsrParams& params, const UpsampleInputs& in);

}  // namespace plumb::isr
