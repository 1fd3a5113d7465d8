// screen.occlude: ambient occlusion over indirect and ambient light (LRA 4.2.3).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/ao_params.h"
#include "gi/screen/occlude_kernel.h"

namespace plumb::screen {

struct OccludeInputs {
    using Kernel = OccludeKernel;
    const Image4* indirect = nullptr;
    const Image4* open = nullptr;
};

inline StageDescription<OccludeInputsView> describe(OccludeKernel) {
    using View = OccludeInputsView;
    return {
        .name = "screen.occlude",
        .source = "LRA 4.2.3, 6.2.3 (ambient occlusion is a factor of light from everywhere)",
        .domain = "pixel",
        .inputs = {{.name = "indirect", .at = &View::indirect, .unit = "W/m2",
                    .meaning = "indirect irradiance; w goes through"},
                   {.name = "open", .at = &View::open, .meaning = "x open share; w 1 on a surface", .fixed = 8}},
        .outputs = {{.name = "occluded", .at = &View::occluded, .unit = "W/m2",
                     .meaning = "open share of indirect and ambient irradiance"}},
        .params = params_of({"ambient"}),
        .cost = {2, "pixels"},
    };
}

StageData data_of(const AoParams& params, const OccludeInputs& in);

}  // namespace plumb::screen
