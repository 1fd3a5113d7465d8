// The stage direct: the irradiance that lights send. See gi/direct/README.md.
#pragma once

#include <vector>

#include "core/scene.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/shadow.h"

namespace plumb::direct {

struct DirectInputs {
    using Kernel = DirectKernel;
    const Image4* position = nullptr;
    const Image4* normal = nullptr;  // w: 1 on a surface; all 0 where nothing is
    const std::vector<Light>* lights = nullptr;
    const Buffer<float>* visibility = nullptr;  // [lights][height][width]
    const raster::Covered* tiles = nullptr;     // the others keep 0 throughout; null: all are shaded
    bool density = false;                       // whether the shadow density is asked for; published has it always
};

inline StageDescription<DirectInputsView> describe(DirectKernel) {
    using View = DirectInputsView;
    DirectParams defaults;
    return {
        .name = "direct",
        .source = "the rendering equation for point-like lights; LRA 4.4; VRSM 4.3 (shadow density)",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m",
                    .meaning = "world-space position of the shading points"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal, w 1; all 0 where nothing is",
                    .fixed = 8},
                   {.name = "lights", .at = &View::lights, .unit = "m, W/sr, W/m2",
                    .meaning = "four vec4 a light: position, cos_outer; direction, falloff_scale; intensity, "
                               "directional; 1 / radius^2, radius^2",
                    .count = [](const View& v) { return std::size_t(v.u.lights) * sizeof(raster::LightArgs) / 16; },
                    .why = "four vec4 a light"},
                   {.name = "visibility", .at = &View::visibility, .meaning = "a layer a light: 1 lit, 0 shadowed",
                    .count = [](const View& v) { return std::size_t(v.u.lights) * std::size_t(v.u.width) * std::size_t(v.u.height); },
                    .why = "a layer a light"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2",
                     .meaning = "direct irradiance; w: shadow density where it is asked for"}},
        .params = plumb::describe(fields(defaults)),
        .uniforms = {{"lights", 0, 0x7fffffff}},
        .cost = {6, "pixels x lights"},
    };
}

// irradiance: W/m2 in xyz; w the shadow density (VRSM 4.3, fig. 4.3), 0 where it is not asked for.
StageData data_of(const DirectParams& params, const DirectInputs& in);

}  // namespace plumb::direct
