// isr.bounce: B = B0 + rho E, what the next bounce gathers (ISR chapter 6, (8)).
#pragma once

#include "core/binding.h"
#include "gi/isr/bounce_kernel.h"
#include "gi/isr/isr_params.h"

namespace plumb::isr {

struct BounceInputs {
    using Kernel = BounceKernel;
    const Image4* radiosity = nullptr;    // B0 of all sources, with their margin
    const Image4* reflectance = nullptr;  // of the receivers
    const Image4* gathered = nullptr;     // of the receivers
    int margin = 0;
};

inline StageDescription<BounceInputsView> describe(BounceKernel) {
    using View = BounceInputsView;
    const auto receivers = [](const View& v) { return glm::ivec2(v.u.receivers_width, v.u.receivers_height); };
    const std::string why = "as receivers_width and receivers_height say";
    return {
        .name = "isr.bounce",
        .source = "ISR chapter 6 (more bounces), (8): B = B0 + rho E",
        .domain = "coarse pixel",
        .inputs = {{.name = "radiosity", .at = &View::radiosity, .unit = "W/m2",
                    .meaning = "B0 of all sources; w: radiation mask"},
                   {.name = "reflectance", .at = &View::reflectance, .meaning = "of the receivers", .size = receivers,
                    .why = why},
                   {.name = "gathered", .at = &View::gathered, .unit = "W/m2", .meaning = "irradiance of the receivers",
                    .size = receivers, .why = why}},
        .outputs = {{.name = "bounced", .at = &View::bounced, .unit = "W/m2",
                     .meaning = "B = B0 + rho E of all sources; w: radiation mask"}},
        .params = params_of({"variant", "bounces"}),
        .uniforms = {{"receivers_width", 1, 32767}, {"receivers_height", 1, 32767}},
        .cost = {4, "pixels"},
    };
}

StageData data_of(const IsrParams& params, const BounceInputs& in);

}  // namespace plumb::isr
