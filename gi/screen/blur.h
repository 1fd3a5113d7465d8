// screen.blur: the mean of ambient occlusion over views, blurred by a box of 4 x 4 pixels (LRA 4.3.2, 6.2.3).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/ao_params.h"
#include "gi/screen/blur_kernel.h"
#include "raster/covered.h"

namespace plumb::screen {

struct BlurInputs {
    using Kernel = BlurKernel;
    const Image4* summed = nullptr;
    const Image4* position = nullptr;
    const Image4* normal = nullptr;
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<BlurInputsView> describe(BlurKernel) {
    using View = BlurInputsView;
    return {
        .name = "screen.blur",
        .source = "LRA 6.2.3, 6.3.2 (4 x 4 box), 4.3.2 (mean over views)",
        .domain = "pixel",
        .inputs = {{.name = "summed", .at = &View::summed,
                    .meaning = "sum w o; sum w; o of the receivers' own view; 1 on a surface", .fixed = 8},
                   {.name = "position", .at = &View::position, .unit = "m",
                    .meaning = "xyz world-space position, w linear depth"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is"}},
        .outputs = {{.name = "open", .at = &View::open, .meaning = "xyz open share; w 1 on a surface", .fixed = 8}},
        .params = params_of({"variant", "blur"}),
        .uniforms = {{"first", -2, 0}, {"last", 0, 2}, {"published", 0, 1}, {"edges", 0, 1}},
        .cost = {1, "samples"},
    };
}

StageData data_of(const AoParams& params, const BlurInputs& in);

}  // namespace plumb::screen
