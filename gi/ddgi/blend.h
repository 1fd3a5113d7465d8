// ddgi.blend: rays of probes into the texels of their octahedral tiles. ddgi.border: the gutter around each tile.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/ddgi/blend_kernel.h"
#include "gi/ddgi/border_kernel.h"

namespace plumb::ddgi {

inline constexpr int most_probes = 1 << 20, most_rays = 1 << 15, most_side = 64, most_hits = 1 << 28;

struct BlendInputs {
    using Kernel = BlendKernel;
    int side = 8, columns = 1;
    bool moments = false;
    int sharpness = 1;
    float hysteresis = 0;                            // of what `previous` holds
    float scale = 1, farthest = 1e15f, least_weight = 1e-6f;
    const Buffer<glm::vec4>* directions = nullptr;   // [rays] unit
    const Image4* hits = nullptr;                    // [probes][rays]: xyz radiance, w distance, m
    const Image4* previous = nullptr;                // the atlas, which has the size of the result
};

inline StageDescription<BlendView> describe(BlendKernel) {
    using View = BlendView;
    return {
        .name = "ddgi.blend",
        .source = "DDGI 2019 (Majercik, Guertin, Nowrouzezahrai, McGuire, JCGT 8(2)) 4.2: probe update",
        .domain = "texel",
        .inputs = {{.name = "directions", .at = &View::directions, .meaning = "[ray] xyz unit, the same for all probes; w unused",
                    .fixed = 8, .count = [](const View& v) { return std::size_t(v.u.rays); }, .why = "one a ray"},
                   {.name = "hits", .at = &View::hits, .unit = "W/(m2 sr)",
                    .meaning = "[probe][ray] radiance that comes back; w: distance, m",
                    .count = [](const View& v) { return std::size_t(v.u.probes) * std::size_t(v.u.rays); },
                    .why = "rays of each probe"},
                   {.name = "previous", .at = &View::previous, .meaning = "what the atlas held"}},
        .outputs = {{.name = "blended", .at = &View::blended, .meaning =
                         "tiles of probes: irradiance, W/m2, or mean distance m and mean square m2; the gutter is not written"}},
        .uniforms = {{"side", 1, most_side}, {"columns", 1, most_probes}, {"probes", 1, most_probes}, {"rays", 1, most_rays},
                     {"moments", 0, 1}, {"sharpness", 1, 256}, {"hysteresis", 0, 1}, {"least_weight", 1e-30, 1}},
        .refuses =
            [](const View& v, glm::ivec2) {
                return std::string(std::int64_t(v.u.probes) * v.u.rays > most_hits ? "more than 2^28 rays" : "");
            },
        .cost = {2, "texels x rays"},
    };
}
StageData data_of(const BlendInputs& in);

struct BorderInputs {
    using Kernel = BorderKernel;
    int side = 8;
    const Image4* atlas = nullptr;
};

inline StageDescription<BorderView> describe(BorderKernel) {
    using View = BorderView;
    return {
        .name = "ddgi.border",
        .source = "DDGI 2019 4.1: the gutter of octahedral tiles",
        .domain = "texel",
        .inputs = {{.name = "atlas", .at = &View::atlas, .meaning = "tiles of probes; the gutter holds anything"}},
        .outputs = {{.name = "bordered", .at = &View::bordered, .meaning = "the same with its gutter"}},
        .uniforms = {{"side", 1, most_side}},
        .cost = {1, "texels"},
    };
}
StageData data_of(const BorderInputs& in);

}  // namespace plumb::ddgi
