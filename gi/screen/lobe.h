// screen.lobe: the rays of mirrors and of Phong's lobes, some a pixel.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/lobe_kernel.h"
#include "gi/screen/reflect_params.h"
#include "gi/screen/sheet.h"

namespace plumb::screen {

struct LobeInputs {
    using Kernel = LobeKernel;
    const Image4* position = nullptr;
    const Image4* normal = nullptr;
    const Image4* mirror = nullptr;  // w 0: none
    const Image4* lobe = nullptr;    // xyz reflectance, w exponent; xyz 0: none
    glm::dvec3 eye{0};
    std::uint32_t seed = 0;
};

// The pictures of a sheet: the mirrors' rays and the lobes'.
inline int lobe_blocks(const ReflectParams& params) { return params.lobe == Lobe::phong ? 1 + params.rays : 1; }

inline StageDescription<LobeInputsView> describe(LobeKernel) {
    using View = LobeInputsView;
    const auto picture = [](const View& v) { return glm::ivec2(v.u.columns, v.u.rows); };
    const std::string why = "as columns and rows say";
    return {
        .name = "screen.lobe",
        .source = "Lafortune and Willems 1994, Using the Modified Phong Reflectance Model for Physically Based Rendering (4)",
        .domain = "pixel and ray",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position", .size = picture, .why = why},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is", .size = picture, .why = why},
                   {.name = "mirror", .at = &View::mirror, .meaning = "reflectance of the mirror; w 0: none", .fixed = 8,
                    .size = picture, .why = why},
                   {.name = "lobe", .at = &View::lobe, .meaning = "xyz reflectance of Phong's lobe, w its exponent; xyz 0: none",
                    .size = picture, .why = why}},
        .outputs = {{.name = "ray", .at = &View::ray, .meaning = "xyz unit direction; w its weight, of a mirror 1; 0: none"}},
        .params = reflect_params_of({"lobe", "rays"}),
        .uniforms = {{"columns", 1, 32767}, {"rows", 1, 32767}, {"across", 1, 9}, {"rays", 1, most_lobe_rays}},
        .refuses = [](const View& v, glm::ivec2 size) -> std::string {
            const int blocks = 1 + v.u.rays;
            const bool whole = v.u.across == sheet_across(blocks) && size == sheet_of({v.u.columns, v.u.rows}, blocks);
            return whole ? "" : "the sheet is not of that many pictures";
        },
        .cost = {20, "rays"},
    };
}

StageData data_of(const ReflectParams& params, const LobeInputs& in);

}  // namespace plumb::screen
