// The stage shadow.filter: the shadows of a light, filtered over the screen before direct light reads them (ISR 4.7). See
// gi/direct/README.md.
#pragma once

#include "gi/direct/log_blur.h"
#include "gi/direct/visibility_filter_kernel.h"

namespace plumb::direct {

struct VisibilityFilterInputs {
    using Kernel = VisibilityFilterKernel;
    const float* visibility = nullptr;  // [height][width] of the light
    const Image4* position = nullptr;   // xyz world, w linear depth, m
    const Image4* normal = nullptr;     // xyz unit; all 0 where nothing is
    Direction direction = Direction::horizontal;
};

inline constexpr const char* visibility_filter_stage = "shadow.filter";

inline StageDescription<VisibilityFilterView> describe(VisibilityFilterKernel) {
    using View = VisibilityFilterView;
    ShadowParams defaults;
    return {
        .name = visibility_filter_stage,
        .source = "ISR 4.7 (shadows in a screen-sized buffer, filtered); edge_aware: VRSM 4.5",
        .domain = "pixel",
        .inputs = {{.name = "visibility", .at = &View::visibility, .meaning = "1 lit, 0 shadowed", .channels = 1},
                   {.name = "position", .at = &View::position, .unit = "m",
                    .meaning = "world-space position; w: linear depth; edge_aware"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is"},
                   {.name = "spatial", .at = &View::spatial,
                    .meaning = "[2 radius + 1]: Gaussian of the distance; 0 in the middle",
                    .count = [](const View& v) { return std::size_t(2 * v.u.radius + 1); },
                    .why = "a weight for each pixel of the row or the column"}},
        .outputs = {{.name = "filtered", .at = &View::filtered, .meaning = "1 lit, 0 shadowed; where nothing is as it was"}},
        .params = plumb::describe(fields(defaults), {"filter", "filter_radius", "filter_sigma", "filter_sigma_depth",
                                                     "filter_sigma_normal"}),
        .uniforms = {{"radius", 0, most_filter_radius}, {"vertical", 0, 1}, {"kind", 0, int(FilterKind::edge_aware)}},
        .cost = {3, "samples"},
    };
}

// One pass. [height][width] floats.
StageData data_of(const ShadowParams& params, const VisibilityFilterInputs& in);

// Along the rows, then along the columns. `filtered` is another buffer than `visibility`; filter = none copies.
void filter_visibility(const ShadowParams& params, const VisibilityFilterInputs& in, const RunOptions& options, float* filtered);

}  // namespace plumb::direct
