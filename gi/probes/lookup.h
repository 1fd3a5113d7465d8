// probes.lookup: indirect light of static surfaces, from the lightmap.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/lookup_kernel.h"

namespace plumb::probes {

struct LookupInputs {
    using Kernel = LookupKernel;
    const Image4* uv = nullptr;        // of probes.lightmap_uv
    const Image4* lightmap = nullptr;  // the strip: as wide as its finest level
    int levels = 1;
};

inline StageDescription<LookupView> describe(LookupKernel) {
    using View = LookupView;
    return {
        .name = "probes.lookup",
        .source = "IPR 3.3.1.4, 4.2.4",
        .domain = "pixel",
        .inputs = {{.name = "uv", .at = &View::uv, .meaning = "xy on the lightmap, z level of detail, w 1; w 0: it has no place there",
                    .fixed = 8},
                   {.name = "lightmap", .at = &View::lightmap, .unit = "W/m2", .meaning = "irradiance, the levels of detail below each other",
                    .fixed = 8, .size = [](const View& v) { return glm::ivec2(v.u.side, lightmap_rows(v.u.side, v.u.levels)); },
                    .why = "the strip of all levels"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "indirect irradiance; 0 without a place on the lightmap"}},
        .uniforms = {{"side", 1, 16384}, {"levels", 1, most_levels}},
        .cost = {4, "pixels"},
    };
}

StageData data_of(const LookupInputs& in);

}  // namespace plumb::probes
