// probes.relief: normal maps and highlights by the light vector, of what moves and of what does not.
#pragma once

#include "core/binding.h"
#include "core/scene.h"
#include "core/stage_description.h"
#include "gi/probes/relief_kernel.h"
#include "gi/probes/volume.h"

namespace plumb::probes {

struct ReliefInputs {
    using Kernel = ReliefKernel;
    bool maps = true, highlights = true;
    float most = 4;                        // of the ratio by which a normal map changes irradiance
    glm::vec3 eye{0};                      // m
    const Image4* position = nullptr;      // xyz m
    const Image4* normal = nullptr;        // xyz unit, mapped; w 1: a point
    const Image4* irradiance = nullptr;    // W/m2: of the lightmap, or of the volume
    const Image4* mapped = nullptr;        // VolumeLight::irradiance, everywhere
    const Image4* plain = nullptr;         // the same along normals without maps; w 0 where `irradiance` is the volume's
    const Image4* light = nullptr;         // VolumeLight::light
    const Image4* from_light = nullptr;    // VolumeLight::from_light
    const Image4* specular = nullptr;      // Material::specular; w: exponent
    const std::vector<Light>* lights = nullptr;  // null: none
    const Buffer<float>* visibility = nullptr;   // [lights][height][width]
};

inline StageDescription<ReliefView> describe(ReliefKernel) {
    using View = ReliefView;
    return {
        .name = "probes.relief",
        .source = "IPR 4.1.2, 5.2.1.3, 5.2.1.6: normal maps and specular reflection by the light vector",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal, mapped; w 1: a point", .fixed = 8},
                   {.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "of the lightmap or of the volume; w unused", .fixed = 8},
                   {.name = "mapped", .at = &View::mapped, .unit = "W/m2", .meaning = "of the volume along the mapped normal; w unused", .fixed = 8},
                   {.name = "plain", .at = &View::plain, .unit = "W/m2",
                    .meaning = "of the volume along the normal without map; w 0: the irradiance is that of the mapped one", .fixed = 8},
                   {.name = "light", .at = &View::light, .meaning = "the light vector, unit; w unused", .fixed = 8},
                   {.name = "from_light", .at = &View::from_light, .unit = "W/m2", .meaning = "of the volume along the light vector; w unused", .fixed = 8},
                   {.name = "specular", .at = &View::specular, .meaning = "reflectance of the lobe; w: its exponent", .fixed = 8},
                   {.name = "lights", .at = &View::lights, .unit = "m, W/sr, W/m2", .meaning = "as direct has them",
                    .count = [](const View& v) { return std::size_t(v.u.lights) * sizeof(raster::LightArgs) / 16; },
                    .why = "four vec4 a light"},
                   {.name = "visibility", .at = &View::visibility, .meaning = "a layer a light: 1 lit, 0 shadowed",
                    .count = [](const View& v) { return std::size_t(v.u.lights) * std::size_t(v.u.width) * std::size_t(v.u.height); },
                    .why = "a layer a light"}},
        .outputs = {{.name = "relieved", .at = &View::relieved, .unit = "W/m2", .meaning = "irradiance of the mapped normal; w 1: a point"},
                    {.name = "glossy", .at = &View::glossy, .unit = "W/(m2 sr)", .meaning = "radiance of the lobe; w 1: a point"}},
        .uniforms = {{"maps", 0, 1}, {"highlights", 0, 1}, {"most", 1, 1e6}, {"lights", 0, 0x7fffffff}},
        .cost = {20, "pixels x (1 + lights)"},
    };
}
// Throws InputError where an input is missing, or the visibility is of another size.
StageData data_of(const ReliefInputs& in);

struct ReliefLight {
    Image4 relieved, glossy;
};
void run(const ReliefInputs& in, const RunOptions& options, ReliefLight& out);

}  // namespace plumb::probes
