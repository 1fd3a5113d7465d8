// isr.compose: outgoing radiance of direct, indirect and ambient light (ISR 4.5, (29)).
#pragma once

#include "core/binding.h"
#include "gi/isr/compose_kernel.h"
#include "gi/isr/isr_params.h"

namespace plumb::isr {

struct ComposeInputs {
    using Kernel = ComposeKernel;
    const Image4* normal = nullptr;    // w: 1 on a surface, 0 where nothing is
    const Image4* albedo = nullptr;    // rho
    const Image4* emission = nullptr;  // W/m2
    const Image4* direct = nullptr;    // W/m2
    const Image4* indirect = nullptr;  // xyz W/m2, w accessibility
    glm::vec3 environment{0};          // W/(m2 sr)
};

inline StageDescription<ComposeInputsView> describe(ComposeKernel) {
    using View = ComposeInputsView;
    return {
        .name = "isr.compose",
        .source = "ISR 4.5, (29)",
        .domain = "pixel",
        .inputs = {{.name = "normal", .at = &View::normal, .meaning = "w: 1 on a surface, 0 where nothing is", .fixed = 8},
                   {.name = "albedo", .at = &View::albedo, .meaning = "diffuse reflectance rho"},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "radiant exitance M"},
                   {.name = "direct", .at = &View::direct, .unit = "W/m2", .meaning = "direct irradiance"},
                   {.name = "indirect", .at = &View::indirect, .unit = "W/m2",
                    .meaning = "indirect irradiance; w: accessibility"}},
        .outputs = {{.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)",
                     .meaning = "outgoing radiance towards the viewer"}},
        .params = params_of({"variant", "ssao_term", "light_unit", "k_ssao", "k_isr", "ambient"}),
        .uniforms = {{"published", 0, 1}},
        .cost = {5, "pixels"},
    };
}

StageData data_of(const IsrParams& params, const ComposeInputs& in);

}  // namespace plumb::isr
