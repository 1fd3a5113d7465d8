// screen.mirror: what mirrors show of the picture and of the lights' maps, and the picture with it (LRA 4.3.1).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/mirror_kernel.h"
#include "gi/screen/reflect_params.h"
#include "gi/screen/sheet.h"

namespace plumb::screen {

struct MirrorInputs {
    using Kernel = MirrorKernel;
    const Image4* hit = nullptr;
    const Image4* mirror = nullptr;
    const Image4* composed = nullptr;  // the picture without reflections
    // Of what was met in layers and in the lights' maps; null: nothing was.
    const Image4* albedo = nullptr;
    const Image4* emission = nullptr;
    const Image4* direct = nullptr;
    // With lobes: their reflectance, and the sheet of rays that screen.lobe makes; null: mirrors alone.
    const Image4* lobe = nullptr;
    const Image4* rays = nullptr;
};

inline StageDescription<MirrorInputsView> describe(MirrorKernel) {
    using View = MirrorInputsView;
    const auto sheet = [](const View& v) { return sheet_of({v.u.width, v.u.height}, 1 + v.u.rays); };
    const std::string why = "a sheet of 1 + rays pictures";
    const auto others = [](const View& v) { return v.u.others != 0; };
    return {
        .name = "screen.mirror",
        .source = "LRA 4.3.1, 6.3.1 (indirect specular lighting)",
        .domain = "pixel",
        .inputs = {{.name = "hit", .at = &View::hit, .meaning = "xy texel; z distance, m; w in which view", .fixed = 11,
                    .size = sheet, .why = why},
                   {.name = "mirror", .at = &View::mirror, .meaning = "reflectance of the mirror", .fixed = 8},
                   {.name = "composed", .at = &View::composed, .unit = "W/(m2 sr)", .meaning = "the picture without reflections"},
                   {.name = "albedo", .at = &View::albedo, .meaning = "of what was met in another view: diffuse reflectance",
                    .size = sheet, .why = why, .read = others},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "its radiant exitance", .size = sheet, .why = why,
                    .read = others},
                   {.name = "direct", .at = &View::direct, .unit = "W/m2", .meaning = "its direct irradiance", .size = sheet, .why = why,
                    .read = others},
                   {.name = "lobe", .at = &View::lobe, .meaning = "reflectance of Phong's lobe", .optional = true},
                   {.name = "drawn", .at = &View::drawn, .meaning = "w weight of a lobe's ray", .size = sheet, .why = why,
                    .read = [](const View& v) { return v.u.rays > 0; }}},
        .outputs = {{.name = "reflection", .at = &View::reflection, .unit = "W/(m2 sr)",
                     .meaning = "what the mirror shows; w 1: something was met", .fixed = 8},
                    {.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)", .meaning = "the picture with it"}},
        .params = reflect_params_of({"lobe", "rays", "fade", "attenuation"}),
        .uniforms = {{"rays", 0, most_lobe_rays}, {"across", 1, 9}, {"others", 0, 1}},
        .refuses = [](const View& v, glm::ivec2) -> std::string {
            return v.u.across == sheet_across(1 + v.u.rays) ? "" : "the sheets are not of 1 + rays pictures";
        },
        .cost = {4, "pixels"},
    };
}

StageData data_of(const ReflectParams& params, const MirrorInputs& in);
// What mirrors show, and the picture with it.
void run(const ReflectParams& params, const MirrorInputs& in, const RunOptions& options, Image4& reflection, Image4& radiance);

}  // namespace plumb::screen
