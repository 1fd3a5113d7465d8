// probes.supports: the probes that support each receiver, and their weights (IPR 3.2.3.2, figure 3.16).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/supports_kernel.h"

namespace plumb::probes {

inline constexpr int most_probes = 1 << 20;
inline constexpr int receivers_a_dispatch = 32767;

struct SupportsInputs {
    using Kernel = SupportsKernel;
    const Buffer<glm::vec4>* receivers = nullptr;  // xyz m
    const Buffer<glm::vec4>* probes = nullptr;     // xyz m
    float radius = 1;                              // m, of every probe
    int overlaps = 10;                             // N_OVERLAPS: probes of a receiver, 1 to most_overlaps
};

inline StageDescription<SupportsView> describe(SupportsKernel) {
    using View = SupportsView;
    return {
        .name = "probes.supports",
        .source = "IPR 3.2.3.2, figure 3.16: the N_OVERLAPS nearest probes within the radius; 3.1.2.3: w_i(x)",
        .domain = "slot of a receiver",
        .inputs = {{.name = "receivers", .at = &View::receivers, .unit = "m", .meaning = "xyz of each receiver; w unused",
                    .fixed = 8, .count = [](const View& v) { return std::size_t(v.u.height); }, .why = "one a row"},
                   {.name = "probes", .at = &View::probes, .unit = "m", .meaning = "xyz of each probe; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.probes); }, .why = "as probes says"}},
        .outputs = {{.name = "support", .at = &View::support, .meaning = "index of a probe, the nearest first; -1: none"},
                    {.name = "weight", .at = &View::weight, .meaning = "w(distance / radius); 0: none"}},
        .uniforms = {{"probes", 1, most_probes}, {"radius", 1e-15, 1e15}},
        .refuses =
            [](const View&, glm::ivec2 size) {
                return std::string(size.x > most_overlaps ? "more than 16 probes of a receiver" : "");
            },
        .cost = {0.5, "pairs"},
    };
}

// One dispatch: receivers [first, first + count) of at most receivers_a_dispatch.
StageData data_of(const SupportsInputs& in, int first, int count);

// What supports receivers, in their order.
struct Supports {
    int overlaps = 0;
    Buffer<std::int32_t> probe;   // [receiver][overlaps]: the nearest first, ties by the lower index; -1: none
    Buffer<float> weight;         // [receiver][overlaps]: w(distance / radius); 0: none
    std::int64_t unsupported = 0;  // receivers without any probe: no radiance reaches them
    std::int64_t incomplete = 0;   // receivers with some, but fewer than `overlaps`
};

// Throws InputError for empty lists, more than most_probes, `overlaps` out of range, or a radius that is not a positive
// number.
Supports run(const SupportsInputs& in, const RunOptions& options);

}  // namespace plumb::probes
