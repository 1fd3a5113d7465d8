// probes.volume: irradiance of what has no lightmap, from the grid of spatial receivers, and its light vector.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/run_params.h"
#include "gi/probes/spatial.h"
#include "gi/probes/volume_kernel.h"

namespace plumb::probes {

inline constexpr float least_light = 1.0f / 64;

struct VolumeInputs {
    using Kernel = VolumeKernel;
    SpatialGrid grid;
    VolumeForm form = VolumeForm::linear;
    bool everywhere = false;                // of surfaces with a lightmap, too: for their light vectors
    float least = least_light;              // of the light vector along the normal, of all irradiance
    const Image4* position = nullptr;       // xyz m
    const Image4* normal = nullptr;         // xyz unit; w 1: a point
    const Image4* lightmap_uv = nullptr;    // x < 0: no lightmap
    const Buffer<glm::vec4>* irradiance = nullptr;  // [place][direction]: gather_grid()
};

inline StageDescription<VolumeView> describe(VolumeKernel) {
    using View = VolumeView;
    return {
        .name = "probes.volume",
        .source = "IPR 4.1.2: irradiance from the voxel grid, light vector",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; w 1: a point", .fixed = 8},
                   {.name = "lightmap_uv", .at = &View::lightmap_uv, .meaning = "x < 0: the surface has no lightmap", .fixed = 15},
                   {.name = "grid", .at = &View::grid, .unit = "W/m2", .meaning = "[place][direction] irradiance; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.count_x) * std::size_t(v.u.count_y) * std::size_t(v.u.count_z) * 6; },
                    .why = "six a place"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "E(n); w 1: a point without lightmap"},
                    {.name = "light", .at = &View::light, .meaning = "unit, towards the light; w as of irradiance"},
                    {.name = "from_light", .at = &View::from_light, .unit = "W/m2", .meaning = "E in the light's direction; w as of irradiance"}},
        .uniforms = {{"count_x", 1, 1 << 20}, {"count_y", 1, 1 << 20}, {"count_z", 1, 1 << 20}, {"form", 0, 2}, {"everywhere", 0, 1},
                     {"least", 1e-3, 1}},
        .refuses =
            [](const View& v, glm::ivec2) {
                for (const float s : {v.u.spacing[0], v.u.spacing[1], v.u.spacing[2]})
                    if (!(s > 0 && s < 1e15f)) return std::string("spacing: expected positive numbers");
                if (std::int64_t(v.u.count_x) * v.u.count_y > 1 << 22 || std::int64_t(v.u.count_x) * v.u.count_y * v.u.count_z > 1 << 22)
                    return std::string("more than 2^22 places");
                return std::string();
            },
        .cost = {60, "pixels"},
    };
}
// Throws InputError where an input is missing, or the list does not fit the grid.
StageData data_of(const VolumeInputs& in);

struct VolumeLight {
    Image4 irradiance, light, from_light;
};
void run(const VolumeInputs& in, const RunOptions& options, VolumeLight& out);

}  // namespace plumb::probes
