// probes.radiance: what relight rays bring, from emission, direct light and the last lightmap.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/radiance_kernel.h"
#include "gi/probes/run_params.h"

namespace plumb::probes {

inline constexpr float published_constant = 0.19f;  // IPR 3.3.1.5, 1/sr

inline constexpr int most_relight_rays = 1 << 15, most_lightmap_side = 1 << 14;

struct RadianceInputs {
    using Kernel = RadianceKernel;
    int probes = 0, rays = 0;
    Feedback feedback = Feedback::corrected;
    float constant = published_constant;
    int side = 1, levels = 1;                     // of the lightmap
    const Buffer<glm::vec4>* surface = nullptr;   // [probes][rays]: xyz reflectance; w 1: a front with a place on the lightmap
    const Buffer<glm::vec4>* emitted = nullptr;   // [probes][rays]: W/(m2 sr)
    const Buffer<glm::vec4>* direct = nullptr;    // [probes][rays]: W/m2
    const Buffer<glm::vec4>* place = nullptr;     // [probes][rays]: xy of the lightmap in 0..1, z its level
    const Image4* lightmap = nullptr;             // the strip, W/m2
};

// Refuses surfaces that are neither 0 nor 1, and levels that the lightmap lacks. Throws InputError.
void check_radiance(RadianceView& view, Buffer<float>& own);

inline StageDescription<RadianceView> describe(RadianceKernel) {
    using View = RadianceView;
    const auto rays = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.height); };
    const std::string why = "rays of each probe";
    return {
        .name = "probes.radiance",
        .source = "IPR 3.3.1.1, 3.3.1.5: f(x), what a relight ray brings",
        .domain = "ray of a probe",
        .inputs = {{.name = "surface", .at = &View::surface,
                    .meaning = "[probe][ray] reflectance where the ray ends; w 1: a front with a place on the lightmap, else 0",
                    .fixed = 8, .count = rays, .why = why},
                   {.name = "emitted", .at = &View::emitted, .unit = "W/(m2 sr)",
                    .meaning = "[probe][ray] radiance of the surface's own, or the sky's; w unused", .fixed = 8, .count = rays, .why = why},
                   {.name = "direct", .at = &View::direct, .unit = "W/m2", .meaning = "[probe][ray] irradiance by lights; w unused",
                    .fixed = 8, .count = rays, .why = why},
                   {.name = "place", .at = &View::place,
                    .meaning = "[probe][ray] xy of the lightmap in 0..1; z the level that is looked up; w unused", .fixed = 12,
                    .count = rays, .why = why},
                   {.name = "lightmap", .at = &View::lightmap, .unit = "W/m2",
                    .meaning = "the last lightmap: levels below each other, two empty rows apart; w unused", .fixed = 8,
                    .size = [](const View& v) { return glm::ivec2(v.u.side, lightmap_rows(v.u.side, v.u.levels)); },
                    .why = "all levels, and two rows between them"}},
        .outputs = {{.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)", .meaning = "[probe][ray] f; w 0"}},
        .uniforms = {{"width", 1, most_relight_rays}, {"side", 1, most_lightmap_side}, {"levels", 1, most_levels}, {"feedback", 0, 2},
                     {"constant", 0, 1e6}},
        .prepare = check_radiance,
        .cost = {4, "rays"},
    };
}
StageData data_of(const RadianceInputs& in);

// f of each ray: [probes][rays], w 0.
void run(const RadianceInputs& in, const RunOptions& options, Buffer<glm::vec4>& radiance);

}  // namespace plumb::probes
