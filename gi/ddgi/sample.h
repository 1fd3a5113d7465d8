// ddgi.sample: irradiance at points from the probes around them.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/ddgi/sample_kernel.h"

namespace plumb::ddgi {

// Probe (x, y, z) stands at origin + (x, y, z) spacing; its tile is (x + count.x y, z).
struct Grid {
    glm::ivec3 count{1};
    glm::vec3 origin{0}, spacing{1};  // m

    int probes() const { return count.x * count.y * count.z; }
    glm::ivec2 tiles() const { return {count.x * count.y, count.z}; }
    glm::ivec2 atlas_size(int side) const { return tiles() * (side + 2); }
};

// How probes are weighed; fields() of volume.h says what each means.
struct Weighing {
    bool visibility = true, wrapped = true, root = false;
    float normal_bias = 0, view_bias = 0;  // m
    float crush = 0.2f, least_weight = 1e-6f;
    float scale = 1;
};

struct SampleInputs {
    using Kernel = SampleKernel;
    Grid grid;
    Weighing weighing;
    int side = 8, depth_side = 16;
    const Image4* position = nullptr;  // xyz m
    const Image4* normal = nullptr;    // xyz unit; 0: no point
    const Image4* view = nullptr;      // xyz unit, towards the viewer; null: it is at `eye`
    glm::vec3 eye{0};                  // m
    const Image4* irradiance = nullptr;
    const Image4* moments = nullptr;   // may be null without visibility
};

inline StageDescription<SampleView> describe(SampleKernel) {
    using View = SampleView;
    return {
        .name = "ddgi.sample",
        .source = "DDGI 2019 (Majercik, Guertin, Nowrouzezahrai, McGuire, JCGT 8(2)) 5: irradiance query",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; 0: no point", .fixed = 8},
                   {.name = "view", .at = &View::view, .meaning = "unit, towards the viewer", .fixed = 8,
                    .size = [](const View& v) { return glm::ivec2(v.u.width, v.u.height); }, .why = "as the points",
                    .read = [](const View& v) { return v.u.viewer == 0; }},
                   {.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "octahedral tiles with gutters",
                    .size = [](const View& v) { return glm::ivec2(v.u.count_x * v.u.count_y, v.u.count_z) * (v.u.side + 2); },
                    .why = "a tile a probe"},
                   {.name = "moments", .at = &View::moments, .unit = "m",
                    .meaning = "octahedral tiles with gutters: mean distance m, mean square m2",
                    .size = [](const View& v) { return glm::ivec2(v.u.count_x * v.u.count_y, v.u.count_z) * (v.u.depth_side + 2); },
                    .why = "a tile a probe", .read = [](const View& v) { return v.u.visibility != 0; }}},
        .outputs = {{.name = "sampled", .at = &View::sampled, .unit = "W/m2",
                     .meaning = "irradiance; w: sum of the weights of the eight probes"}},
        .uniforms = {{"side", 1, 64}, {"depth_side", 1, 64}, {"count_x", 1, 1024}, {"count_y", 1, 1024}, {"count_z", 1, 1024},
                     {"visibility", 0, 1}, {"wrapped", 0, 1}, {"root", 0, 1}, {"viewer", 0, 1}, {"crush", 1e-12, 1e9},
                     {"least_weight", 1e-12, 1}},
        .refuses =
            [](const View& v, glm::ivec2) {
                for (const float s : {v.u.spacing[0], v.u.spacing[1], v.u.spacing[2]})
                    if (!(s > 0 && s < 1e15f)) return std::string("spacing: expected positive numbers");
                return std::string();
            },
        .cost = {60, "pixels"},
    };
}
StageData data_of(const SampleInputs& in);

}  // namespace plumb::ddgi
