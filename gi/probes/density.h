// probes.density: the kernel density of candidates for probes (IPR 3.2.2.1).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/density_kernel.h"

namespace plumb::probes {

inline constexpr int most_candidates = 1 << 24;

struct DensityInputs {
    using Kernel = DensityKernel;
    const Buffer<glm::vec4>* positions = nullptr;  // xyz, in any unit
    float radius = 1;                              // of the kernel, in the same
};

// Fills `own` with the bounds of each block of candidates.
void bound_blocks(DensityView& view, Buffer<float>& own);

inline StageDescription<DensityView> describe(DensityKernel) {
    using View = DensityView;
    return {
        .name = "probes.density",
        .source = "IPR 3.2.2.1: K_i, the sum of w(|p_j - p_i| / r) over j != i",
        .domain = "candidate",
        .inputs = {{.name = "positions", .at = &View::positions, .unit = "cells", .meaning = "xyz of each candidate; w unused",
                    .fixed = 8, .count = [](const View& v) { return std::size_t(v.u.count); }, .why = "count of them"}},
        .outputs = {{.name = "density", .at = &View::density, .meaning = "K_i of each candidate"}},
        .uniforms = {{"count", 1, most_candidates}, {"inverse_radius", 1e-15, 1e15}},
        .refuses =
            [](const View& v, glm::ivec2 size) {
                return std::string(std::int64_t(size.x) * size.y < v.u.count ? "fewer items than candidates" : "");
            },
        .prepare = bound_blocks,
        .cost = {0.5, "pairs"},
    };
}

StageData data_of(const DensityInputs& in);

// K_i of each candidate. Throws InputError for an empty list, one above most_candidates, or a radius that is not a
// positive number.
void run(const DensityInputs& in, const RunOptions& options, Buffer<float>& density);

}  // namespace plumb::probes
