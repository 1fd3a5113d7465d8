// screen.reflect: where mirrored rays meet what a view sees (LRA 4.2.4, 4.3.1), by steps of one length.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "core/view.h"
#include "gi/screen/reflect_kernel.h"
#include "gi/screen/reflect_params.h"
#include "raster/covered.h"

namespace plumb::screen {

struct ReflectInputs {
    using Kernel = ReflectKernel;
    const Image4* position = nullptr;  // of the mirrors
    const Image4* normal = nullptr;
    const Image4* mirror = nullptr;    // w 0: none
    glm::dvec3 eye{0};                 // of the camera that sees them
    const Image4* seen = nullptr;      // of the view: its positions, w linear depth
    const Image4* seen_normal = nullptr;
    View view;
    int number = 1;                    // of the view: 1 the camera's, then its layers, then the lights' maps
    const Image4* before = nullptr;    // what earlier views found; null: nothing
    const Image4* rays = nullptr;      // as screen.lobe makes them; null: the mirrored ray of each pixel
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<ReflectInputsView> describe(ReflectKernel) {
    using View = ReflectInputsView;
    const auto of_view = [](const View& v) { return glm::ivec2(v.u.view.width, v.u.view.height); };
    const auto picture = [](const View& v) {
        return v.u.rows > 0 ? glm::ivec2(v.u.columns, v.u.rows) : glm::ivec2(v.u.width, v.u.height);
    };
    const std::string of_picture = "as columns and rows say";
    return {
        .name = "screen.reflect",
        .source = "LRA 4.2.4, 6.2.4 (screen space reflections), 4.3.1, 6.3.1 (in the lights' maps)",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position", .size = picture,
                    .why = of_picture},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is", .size = picture,
                    .why = of_picture},
                   {.name = "mirror", .at = &View::mirror, .meaning = "reflectance of the mirror; w 0: none", .fixed = 8,
                    .size = picture, .why = of_picture},
                   {.name = "map_position", .at = &View::map_position, .unit = "m",
                    .meaning = "of the view: xyz world-space position, w linear depth; 0 where nothing is", .size = of_view,
                    .why = "as view.width and view.height say"},
                   {.name = "map_normal", .at = &View::map_normal, .meaning = "of the view: unit normal, towards it",
                    .size = of_view, .why = "as view.width and view.height say"},
                   {.name = "before", .at = &View::before, .meaning = "what earlier views found", .fixed = 11, .optional = true},
                   {.name = "rays", .at = &View::rays, .meaning = "as screen.lobe writes them, where rows > 0", .optional = true}},
        .outputs = {{.name = "hit", .at = &View::hit,
                     .meaning = "xy texel; z distance along the ray, m; w in which view: 1 the camera's, 0 none", .fixed = 11}},
        .params = reflect_params_of({"march", "variant", "views", "layers", "step", "steps", "bisections", "thickness", "bias"}),
        .uniforms = {{"steps", 1, most_march_steps}, {"bisections", 0, most_bisections}, {"view.width", 1, 32767},
                     {"view.height", 1, 32767}, {"number", 1, 1 << 20}, {"columns", 0, 32767}, {"rows", 0, 32767}, {"published", 0, 1}},
        .fixed_uniforms = {{"view.perspective", 1}},
        .refuses = [](const View& v, glm::ivec2) -> std::string {
            if (v.u.published != 0 && v.u.rows > 0) return "as printed there are no drawn rays";
            if (v.u.rows > 0 && v.u.columns == 0) return "rows without columns";
            const std::int64_t texels = std::int64_t(v.u.view.width) * v.u.view.height;
            return texels < (std::int64_t(1) << 29) ? "" : "the view has 2^29 texels or more: expected fewer";
        },
        .cost = {3, "steps"},
    };
}

StageData data_of(const ReflectParams& params, const ReflectInputs& in);

}  // namespace plumb::screen
