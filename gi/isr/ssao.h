// isr.ssao: ambient occlusion by what the camera sees (ISR 4.4).
#pragma once

#include "core/binding.h"
#include "gi/isr/gather.h"
#include "gi/isr/isr_params.h"
#include "gi/isr/ssao_kernel.h"
#include "raster/covered.h"

namespace plumb::isr {

struct SsaoInputs {
    using Kernel = SsaoKernel;
    const Image4* surface = nullptr;   // of the receivers
    const Image4* source_surface = nullptr;
    const Image4* gathered = nullptr;  // xyz goes through; null: 0
    CoarseCamera camera;
    int margin = 0;
    const Pattern* pattern = nullptr;  // ssao_pattern()
    std::uint32_t seed = 1;
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<SsaoInputsView> describe(SsaoKernel) {
    using View = SsaoInputsView;
    return {
        .name = "isr.ssao",
        .source = "ISR 4.4, (26): ambient occlusion by what the camera sees",
        .domain = "coarse pixel",
        .inputs = {{.name = "surface", .at = &View::surface, .unit = "m", .meaning = "receivers: xyz unit normal, w depth"},
                   {.name = "source_surface", .at = &View::source_surface, .unit = "m",
                    .meaning = "what occludes: xyz unit normal, w depth",
                    .size = [](const View& v) { return glm::ivec2(v.u.source_width, v.u.source_height); },
                    .why = "as source_width and source_height say"},
                   {.name = "gathered", .at = &View::gathered, .unit = "W/m2",
                    .meaning = "irradiance, which goes through", .optional = true},
                   {.name = "offsets", .at = &View::offsets, .unit = "coarse pixels", .meaning = "[samples][rotations]",
                    .count = [](const View& v) { return std::size_t(sample_count(v.u.rings)) * std::size_t(v.u.rotations); },
                    .why = "samples x rotations"}},
        .outputs = {{.name = "lit", .at = &View::lit, .unit = "W/m2", .meaning = "irradiance; w: accessibility",
                     .unwritten = {0, 0, 0, 1}}},
        .params = params_of({"variant", "solid_angle", "ssao_rings", "ssao_spacing", "rotations", "turn", "position", "length_unit"}),
        .uniforms = {{"rings", 0, 127}, {"source_width", 1, 32767}, {"source_height", 1, 32767}},
        .refuses = [](const View& v, glm::ivec2 size) { return refuse_samples(v.u, size); },
        .cost = {1, "samples"},
    };
}

StageData data_of(const IsrParams& params, const SsaoInputs& in);

}  // namespace plumb::isr
