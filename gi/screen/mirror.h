// screen.mirror: what mirrors show of the picture and of the lights' maps, and the picture with it (LRA 4.3.1).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/mirror_kernel.h"
#include "gi/screen/reflect_params.h"

namespace plumb::screen {

struct MirrorInputs {
    using Kernel = MirrorKernel;
    const Image4* hit = nullptr;
    const Image4* mirror = nullptr;
    const Image4* composed = nullptr;  // the picture without reflections
    // Of what was met in the lights' maps; null: nothing was.
    const Image4* albedo = nullptr;
    const Image4* emission = nullptr;
    const Image4* direct = nullptr;
};

inline StageDescription<MirrorInputsView> describe(MirrorKernel) {
    using View = MirrorInputsView;
    return {
        .name = "screen.mirror",
        .source = "LRA 4.3.1, 6.3.1 (indirect specular lighting)",
        .domain = "pixel",
        .inputs = {{.name = "hit", .at = &View::hit, .meaning = "xy texel; z distance, m; w in which view", .fixed = 11},
                   {.name = "mirror", .at = &View::mirror, .meaning = "reflectance of the mirror", .fixed = 8},
                   {.name = "composed", .at = &View::composed, .unit = "W/(m2 sr)", .meaning = "the picture without reflections"},
                   {.name = "albedo", .at = &View::albedo, .meaning = "of what was met in a light's map: diffuse reflectance",
                    .optional = true},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "its radiant exitance", .optional = true},
                   {.name = "direct", .at = &View::direct, .unit = "W/m2", .meaning = "its direct irradiance", .optional = true}},
        .outputs = {{.name = "reflection", .at = &View::reflection, .unit = "W/(m2 sr)",
                     .meaning = "what the mirror shows; w 1: something was met", .fixed = 8},
                    {.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)", .meaning = "the picture with it"}},
        .params = reflect_params_of({"fade", "attenuation"}),
        .cost = {4, "pixels"},
    };
}

StageData data_of(const ReflectParams& params, const MirrorInputs& in);
// What mirrors show, and the picture with it.
void run(const ReflectParams& params, const MirrorInputs& in, const RunOptions& options, Image4& reflection, Image4& radiance);

}  // namespace plumb::screen
