// isr.gather: one bounce of indirect light between what the camera sees (ISR 4.4).
#pragma once

#include <fmt/format.h>

#include "core/binding.h"
#include "gi/isr/gather_kernel.h"
#include "gi/isr/isr_params.h"
#include "raster/covered.h"

namespace plumb::isr {

// Says what is wrong with the samples of a block, or nothing.
inline std::string refuse_samples(const SampleUniforms& u, glm::ivec2 size) {
    if (u.rotations < 1 || (u.rotations & (u.rotations - 1)) != 0)
        return fmt::format("rotations = {}: expected a power of two", u.rotations);
    if (u.tile != 0 && !(u.tile > 0 && u.tile <= 32 && u.tile * u.tile == u.rotations))
        return fmt::format("tile = {}, rotations = {}: expected 0, or a tile of which they are the square", u.tile, u.rotations);
    if (u.margin < 0 || u.margin > u.source_width - size.x || u.margin > u.source_height - size.y)
        return fmt::format("margin = {}: expected 0 or more, and sources of {} x {} around it", u.margin, size.x, size.y);
    return "";
}

struct GatherInputs {
    using Kernel = GatherKernel;
    const Image4* surface = nullptr;           // of the receivers, [coarse]
    const Image4* source_surface = nullptr;    // where light comes from: the same image, one with a guard band, a layer
    const Image4* source_radiosity = nullptr;  // of source_surface's size
    const Image4* before = nullptr;            // what other sources sent, as this stage makes it; null: nothing
    CoarseCamera camera;                       // of the receivers
    int margin = 0;                            // coarse pixels of the sources left of and above pixel (0, 0)
    const Pattern* pattern = nullptr;          // gather_pattern()
    std::uint32_t seed = 1;                    // of the rotations
    const raster::Covered* tiles = nullptr;    // of `surface`
};

inline StageDescription<GatherInputsView> describe(GatherKernel) {
    using View = GatherInputsView;
    const auto sources = [](const View& v) { return glm::ivec2(v.u.source_width, v.u.source_height); };
    const std::string why = "as source_width and source_height say";
    return {
        .name = "isr.gather",
        .source = "ISR 4.4, (25) and (6): one bounce between what the camera sees",
        .domain = "coarse pixel",
        .inputs = {{.name = "surface", .at = &View::surface, .unit = "m", .meaning = "receivers: xyz unit normal, w depth"},
                   {.name = "source_surface", .at = &View::source_surface, .unit = "m",
                    .meaning = "where light comes from: xyz unit normal, w depth", .size = sources, .why = why},
                   {.name = "source_radiosity", .at = &View::source_radiosity, .unit = "W/m2",
                    .meaning = "w: radiation mask", .size = sources, .why = why},
                   {.name = "before", .at = &View::before, .unit = "W/m2",
                    .meaning = "what other sources sent; w: sum of form factors", .optional = true},
                   {.name = "offsets", .at = &View::offsets, .unit = "coarse pixels", .meaning = "[samples][rotations]",
                    .count = [](const View& v) { return std::size_t(sample_count(v.u.rings)) * std::size_t(v.u.rotations); },
                    .why = "samples x rotations"},
                   {.name = "weights", .at = &View::weights, .meaning = "[samples]: how many patches of area a sample stands for",
                    .count = [](const View& v) { return std::size_t(sample_count(v.u.rings)); }, .why = "one for each sample", .optional = true}},
        .outputs = {{.name = "gathered", .at = &View::gathered, .unit = "W/m2",
                     .meaning = "irradiance; w: sum of form factors"}},
        .params = params_of({"variant", "solid_angle", "pattern", "rings", "reach", "growth", "spacing", "rotations", "turn", "far_rings", "full_depth", "position",
                             "least_cosine"}),
        .uniforms = {{"rings", 0, 127}, {"source_width", 1, 32767}, {"source_height", 1, 32767}},
        .refuses = [](const View& v, glm::ivec2 size) { return refuse_samples(v.u, size); },
        .cost = {1, "samples"},
    };
}

StageData data_of(const IsrParams& params, const GatherInputs& in);

}  // namespace plumb::isr
