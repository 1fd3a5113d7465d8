// screen.reuse: indirect light of frames before this one (LRA 4.3.3 and its conclusion).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/last_frame.h"
#include "gi/screen/reuse_kernel.h"
#include "gi/screen/reuse_params.h"

namespace plumb::screen {

struct ReuseInputs {
    using Kernel = ReuseKernel;
    const Image4* irradiance = nullptr;  // gathered in this frame, W/m2
    const Image4* position = nullptr;
    const Image4* normal = nullptr;
    View view;                           // that sees them
    const LastFrame* last = nullptr;     // null, or empty: there is none
    glm::ivec2 frame{0};                 // pixels of the picture, of which they may be half; 0: they are its
};

inline StageDescription<ReuseInputsView> describe(ReuseKernel) {
    using View = ReuseInputsView;
    constexpr auto size = [](const View& v) { return glm::ivec2(v.u.last.width, v.u.last.height); };
    const std::string why = "as last.width and last.height say";
    return {
        .name = "screen.reuse",
        .source = "LRA 4.3.3, 9 (ten samples, turned every frame, and the last frame's light)",
        .domain = "pixel",
        .inputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "gathered in this frame"},
                   {.name = "position", .at = &View::position, .unit = "m", .meaning = "xyz world space, w linear depth"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is"},
                   {.name = "last_irradiance", .at = &View::last_irradiance, .unit = "W/m2", .meaning = "what this stage made in the last frame", .size = size, .why = why},
                   {.name = "last_age", .at = &View::last_age, .meaning = "of how many frames that is, in x; w 1 on a surface", .size = size, .why = why},
                   {.name = "last_position", .at = &View::last_position, .unit = "m", .meaning = "of the last frame", .size = size, .why = why},
                   {.name = "last_normal", .at = &View::last_normal, .meaning = "of the last frame", .size = size, .why = why}},
        .outputs = {{.name = "reused", .at = &View::reused, .unit = "W/m2", .meaning = "irradiance, mean of up to `most` frames; w linear depth"},
                    {.name = "age", .at = &View::age, .meaning = "frames, weight of the last one, W/m2 by which it was a ghost; w 1 on a surface", .fixed = 8}},
        .params = reuse_params_of({"frames", "clamp", "sigma_depth", "sigma_normal"}),
        .uniforms = {{"most", 1, 4096}, {"last.width", 1, 32767}, {"last.height", 1, 32767}, {"clamps", 0, 1}, {"there", 0, 1}},
        .fixed_uniforms = {{"last.perspective", 1}, {"now.perspective", 1}},
        .cost = {12, "pixels"},
    };
}

StageData data_of(const ReuseParams& params, const ReuseInputs& in);

// light and age: as the outputs `reused` and `age`; written in place where their size is right.
void run_reuse(const ReuseParams& params, const ReuseInputs& in, const RunOptions& options, Image4& light, Image4& age);

// By how many columns a pattern of `rotations` is turned in frame i: no two frames of as many alike, and any few of them are
// spread over the circle, as multiples of the golden ratio are.
int turn_of_frame(std::uint32_t frame, int rotations);

}  // namespace plumb::screen
