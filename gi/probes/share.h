// probes.share: what each ray of a receiver counts for.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/share_kernel.h"

namespace plumb::probes {

struct ShareInputs {
    using Kernel = ShareKernel;
    int receivers = 0, rays = 0, slots = 0;
    bool published = false;
    const glm::vec4* supporting = nullptr;  // [slots][receivers]
    const float* factors = nullptr;         // [rays]
    const std::int32_t* visible = nullptr;  // [rays][receivers]
    const float* lengths = nullptr;         // [rays][receivers]
};

inline constexpr float least_weight = 0x1p-64f;    // 2^-48 is the least that probes.supports gives
inline constexpr float most_weight = 1.001f;       // 1, and what a device may add to it
inline constexpr float most_factor = 12.5663706f;  // 4 pi sr
inline constexpr float most_length = 1e16f;        // m: 1e15 stands for a ray that met nothing

// Refuses weights, factors and lengths that no bake has: shares would leave a float's range. Throws InputError.
void check_share(ShareView& view, Buffer<float>& own);

inline StageDescription<ShareView> describe(ShareKernel) {
    using View = ShareView;
    const auto pairs = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.height); };
    return {
        .name = "probes.share",
        .source = "IPR 3.1.2.3, 3.2.3.2; the weight by distance 5.1.3.2",
        .domain = "ray of a receiver",
        .inputs = {{.name = "supporting", .at = &View::supporting, .unit = "m",
                    .meaning = "[slot][receiver] xyz the supporting probe; w its weight, 0: none",
                    .count = [](const View& v) { return std::size_t(v.u.slots) * std::size_t(v.u.width); },
                    .why = "slots of each receiver"},
                   {.name = "factors", .at = &View::factors, .unit = "sr", .meaning = "weight of each ray",
                    .count = [](const View& v) { return std::size_t(v.u.height); }, .why = "one a ray"},
                   {.name = "visible", .at = &View::visible, .meaning = "[ray][receiver] bit i: probe i sees what was met",
                    .count = pairs, .why = "rays of each receiver"},
                   {.name = "lengths", .at = &View::lengths, .unit = "m", .meaning = "[ray][receiver] of the ray",
                    .count = pairs, .why = "rays of each receiver"}},
        .outputs = {{.name = "share", .at = &View::share, .unit = "sr",
                     .meaning = "weight over the sum of the weights of the probes that see it; 0: none does"}},
        .uniforms = {{"slots", 1, 16}, {"published", 0, 1}},
        .prepare = check_share,
        .cost = {3, "rays"},
    };
}

StageData data_of(const ShareInputs& in);

}  // namespace plumb::probes
