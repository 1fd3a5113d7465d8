// probes.coefficients: alpha_ij of receivers, from what their rays met.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/coefficients_kernel.h"

namespace plumb::probes {

struct CoefficientsInputs {
    using Kernel = CoefficientsKernel;
    int receivers = 0, rays = 0, slots = 0, degree = sh::kernel_degrees - 1;
    const std::int32_t* rows = nullptr;     // coefficient_rows(slots, degree)
    const glm::vec4* supporting = nullptr;  // [slots][receivers]
    const glm::vec4* seen = nullptr;        // [rays][receivers]
    const std::int32_t* visible = nullptr;  // [rays][receivers]
    const float* shares = nullptr;          // [rays][receivers]
};

// [slots x (degree + 1)^2][4]: slot, l, |m|, 1 where m < 0.
std::vector<std::int32_t> coefficient_rows(int slots, int degree);

inline constexpr float most_coordinate = 0x1p60f;  // m: squares of differences stay within a float's range

// Refuses coordinates beyond most_coordinate, and shares that are not finite. Throws InputError.
void check_coefficients(CoefficientsView& view, Buffer<float>& own);

inline StageDescription<CoefficientsView> describe(CoefficientsKernel) {
    using View = CoefficientsView;
    const auto pairs = [](const View& v) { return std::size_t(v.u.rays) * std::size_t(v.u.width); };
    const std::string why = "rays of each receiver";
    return {
        .name = "probes.coefficients",
        .source = "IPR 3.2.3.2, (9)",
        .domain = "coefficient of a receiver",
        .inputs = {{.name = "rows", .at = &View::rows, .meaning = "[coefficient] slot, degree, |m|, 1 where m < 0",
                    .count = [](const View& v) { return std::size_t(v.u.height); }, .why = "one a row"},
                   {.name = "recurrence", .at = &View::recurrence, .meaning = "factors of the harmonics, core/sh_kernel.h",
                    .count = [](const View&) { return std::size_t(sh::recurrence_size); }, .why = "8 x 8 twice"},
                   {.name = "supporting", .at = &View::supporting, .unit = "m",
                    .meaning = "[slot][receiver] xyz the supporting probe; w its weight, 0: none",
                    .count = [](const View& v) { return std::size_t(v.u.slots) * std::size_t(v.u.width); },
                    .why = "slots of each receiver"},
                   {.name = "seen", .at = &View::seen, .unit = "m",
                    .meaning = "[ray][receiver] xyz what the ray met, w 1; or its direction, w 0", .fixed = 8, .count = pairs,
                    .why = why},
                   {.name = "visible", .at = &View::visible, .meaning = "[ray][receiver] bit i: probe i sees what was met",
                    .count = pairs, .why = why},
                   {.name = "shares", .at = &View::shares, .unit = "sr", .meaning = "[ray][receiver] of probes.share",
                    .count = pairs, .why = why}},
        .outputs = {{.name = "alpha", .at = &View::alpha, .unit = "sr",
                     .meaning = "[slot][coefficient][receiver] alpha_ij of the supporting probe"}},
        .uniforms = {{"rays", 0, 1 << 15}, {"slots", 1, 16}},
        .prepare = check_coefficients,
        .cost = {40, "rays x slots"},
    };
}

StageData data_of(const CoefficientsInputs& in);

}  // namespace plumb::probes
