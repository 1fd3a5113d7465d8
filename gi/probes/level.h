// probes.level: levels of detail of clusters and probes (IPR 4.2.1, 4.2.2).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/level_kernel.h"
#include "gi/probes/lightmap_kernel.h"

namespace plumb::probes {

inline constexpr int most_boxes = 1 << 24;

// What levels are measured from, as the kernels have it; rule_at() of lod.h makes it.
struct LevelRule {
    int levels = 1;
    glm::vec4 eye{0}, forward{0, 0, -1, 0};  // m; unit
    glm::vec4 zones{-1, 0, -1, 0};           // cosine, sine of the front's half angle; of the side's
    glm::vec4 scales{1};                     // xyz: of distances in front, at the side, behind; ascending
    glm::vec4 distances{0};                  // xyz m: where levels 1, 2, 3 begin; ascending
    glm::vec4 widths{0};                     // xyz m: over which a fragment changes to them
    glm::vec4 margins{1};                    // xyz: what a box's margin is multiplied by at each of them; ascending
};

// Boxes of no size are points.
struct LevelInputs {
    using Kernel = LevelKernel;
    const Buffer<glm::vec4>* low = nullptr;   // xyz m; w the margin, m: 0 or more
    const Buffer<glm::vec4>* high = nullptr;  // xyz m
    LevelRule rule;
};

// Refuses boxes that are not, and rules that a level does not follow from. Throws InputError.
void check_levels(LevelView& view, Buffer<float>& own);

inline StageDescription<LevelView> describe(LevelKernel) {
    using View = LevelView;
    const auto count = [](const View& v) { return std::size_t(v.u.count); };
    return {
        .name = "probes.level",
        .source = "IPR 4.2.1, 4.2.2, figures 4.4, 4.7, 4.8",
        .domain = "cluster or probe",
        .inputs = {{.name = "low", .at = &View::low, .unit = "m",
                    .meaning = "xyz the low corner of each box; w its margin: what reads it lies within that", .count = count,
                    .why = "count of them"},
                   {.name = "high", .at = &View::high, .unit = "m", .meaning = "xyz the high corner; w unused", .fixed = 8,
                    .count = count, .why = "count of them"}},
        .outputs = {{.name = "level", .at = &View::level, .meaning = "level of detail, 0 the finest"}},
        .uniforms = {{"count", 1, most_boxes}, {"levels", 1, most_levels}},
        .fixed_uniforms = {{"scales", 15}, {"distances", 15}, {"margins", 15}},  // settings: they ascend
        .refuses =
            [](const View& v, glm::ivec2 size) {
                return std::string(std::int64_t(size.x) * size.y < v.u.count ? "fewer items than boxes" : "");
            },
        .prepare = check_levels,
        .cost = {10, "boxes"},
    };
}

StageData data_of(const LevelInputs& in);

// The level of each box. Throws InputError for an empty list, lists of different length, corners that are not finite or not in
// order, margins below 0.
void run(const LevelInputs& in, const RunOptions& options, std::vector<std::int32_t>& levels);

// The same of one point, without a list: level, and the share of the next coarser one.
struct PointLevel {
    int level = 0;
    float share = 0;
};
PointLevel level_at(const LevelRule& rule, const glm::vec3& point);

}  // namespace plumb::probes
