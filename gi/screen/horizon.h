// screen.horizon: ambient occlusion by the horizons that the camera sees (GTAO).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "core/view.h"
#include "gi/screen/ao_params.h"
#include "gi/screen/horizon_kernel.h"
#include "raster/covered.h"

namespace plumb::screen {

struct HorizonInputs {
    using Kernel = HorizonKernel;
    const Image4* position = nullptr;  // xyz world, m; w linear depth, m
    const Image4* normal = nullptr;
    View view;                         // the camera's
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<HorizonInputsView> describe(HorizonKernel) {
    using View = HorizonInputsView;
    return {
        .name = "screen.horizon",
        .source = "Jimenez et al. 2016, Practical Realtime Strategies for Accurate Indirect Occlusion (GTAO)",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m",
                    .meaning = "xyz world-space position, w linear depth"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is"},
                   {.name = "turns", .at = &View::turns, .meaning = "cosine and sine of each slice, for each pixel of 4 x 4",
                    .count = [](const View& v) { return std::size_t(rotation_count) * std::size_t(v.u.slices); },
                    .why = "16 vec2 a slice"},
                   {.name = "shares", .at = &View::shares, .meaning = "of the radius, at which the image is read",
                    .count = [](const View& v) { return std::size_t(v.u.steps); }, .why = "a number a step"}},
        .outputs = {{.name = "summed", .at = &View::summed, .meaning = "open share; 1; open share; 1 on a surface",
                     .fixed = 10}},
        .params = params_of({"method", "radius", "bias", "slices", "steps"}),
        .uniforms = {{"slices", 1, most_slices}, {"steps", 1, most_steps}},
        .cost = {4, "samples"},
    };
}

StageData data_of(const AoParams& params, const HorizonInputs& in);

// [16][slices][2]: cosine and sine of (i + r / 16) pi / slices, r the rotation of a pixel of 4 x 4.
Buffer<float> slice_turns(const AoParams& params);
// [steps]: ((k + 1/2) / steps)^2.
Buffer<float> step_shares(const AoParams& params);

}  // namespace plumb::screen
