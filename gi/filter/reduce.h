// filter.reduce: one pixel of every 2 x 2, (min(2 x + 1, w - 1), min(2 y + 1, h - 1)).
#pragma once

#include "core/stage_description.h"
#include "gi/filter/filter_params.h"
#include "gi/filter/reduce_kernel.h"

namespace plumb::filter {

struct ReduceInputs {
    using Kernel = ReduceKernel;
    const Image4* full = nullptr;
};

inline StageDescription<ReduceInputsView> describe(ReduceKernel) {
    using View = ReduceInputsView;
    return {
        .name = "filter.reduce",
        .source = "VRSM 4.4 (indirect light at a quarter of the pixels)",
        .domain = "half-size pixel",
        .inputs = {{.name = "full", .at = &View::image, .meaning = "position or normal of every pixel",
                    .size = [](const View& v) { return glm::ivec2(v.u.full_width, v.u.full_height); },
                    .why = "as full_width and full_height say"}},
        .outputs = {{.name = "reduced", .at = &View::reduced, .meaning = "one pixel of every 2 x 2"}},
        .uniforms = {{"full_width", 1, 32767}, {"full_height", 1, 32767}},
        .refuses = [](const View& v, glm::ivec2 size) { return refuse_half({v.u.full_width, v.u.full_height}, size); },
        .cost = {1, "pixels"},
    };
}

StageData data_of(const FilterParams& params, const ReduceInputs& in);

}  // namespace plumb::filter
