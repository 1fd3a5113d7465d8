// radiosity.reduce: irradiance from a drawn hemicube, as a device sums it (HEM 6.7.1).
#pragma once

#include "core/binding.h"
#include "core/formats.h"
#include "core/stage_description.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/reduce_kernel.h"
#include "gi/radiosity/texel_weights.h"

namespace plumb::radiosity {

struct ReduceInputs {
    using Kernel = ReduceKernel;
    const Buffer<glm::vec4>* texels = nullptr;  // [hemicubes rows][columns]: xyz B, W/m2, w share of a front
    int columns = 0, rows = 0;                  // of a hemicube; 3 x as many rows as columns before the last pass
    const Buffer<float>* weights = nullptr;     // [rows][columns]; null: 1
    glm::ivec2 box{2, 2};                       // texels that become one
    float gain = 1;                             // by which each box's sum is multiplied
};

inline StageDescription<ReduceView> describe(ReduceKernel) {
    using View = ReduceView;
    return {
        .name = "radiosity.reduce",
        .source = "HEM 6.7.1 (multiplier maps and sums by shaders), 5.5, 5.6.6",
        .domain = "box of texels of hemicubes",
        .inputs = {{.name = "texels", .at = &View::texels, .unit = "W/m2", .meaning = "hemicubes, one below the other: xyz radiosity, w 1 where it is a front's",
                    .count = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.across) * std::size_t(v.u.height) * std::size_t(v.u.down); },
                    .why = "width across x height down"},
                   {.name = "weights", .at = &View::weights, .meaning = "of a hemicube's texels: form factors, all together 1",
                    .count = [](const View& v) { return v.u.weighted != 0 ? std::size_t(v.u.width) * std::size_t(v.u.across) * std::size_t(v.u.rows) : 1; },
                    .why = "width across x rows; one where weighted is 0"}},
        .outputs = {{.name = "sums", .at = &View::sums, .unit = "W/m2", .meaning = "of boxes; w: of fronts' weights"}},
        .uniforms = {{"across", 1, largest_hemicube}, {"down", 1, largest_hemicube}, {"rows", 1, rows_of_hemicube(largest_hemicube)}, {"weighted", 0, 1}},
        .refuses =
            [](const View& v, glm::ivec2 size) {
                const std::int64_t lines = std::int64_t(size.y) * v.u.down;
                return std::string(v.u.rows % v.u.down != 0                              ? "rows: a multiple of down: no box is of two hemicubes"
                                   : lines % v.u.rows != 0                               ? "height: whole hemicubes of rows / down"
                                   : lines > rows_a_dispatch                             ? "height down: at most 524288 rows"
                                   : std::int64_t(size.x) * v.u.across > largest_hemicube ? "width across: at most 1024"
                                                                                         : "");
            },
        .cost = {0.5, "texels"},
    };
}

// One dispatch. Throws InputError where the lists do not fit each other.
StageData data_of(const ReduceInputs& in);

// The boxes by which a hemicube becomes one number: each the largest up to `most` texels a side that divides what is left (a larger
// one where none does), and at last the three rows of one texel.
std::vector<glm::ivec2> reduction_boxes(int size, int most);

// How a device is asked to sum.
struct Reduction {
    int box = 0;                      // texels a side, 2 to largest_hemicube; 0: none, texels in their order, in double
    bool means = false;               // weights times a hemicube's texels, and means of boxes in place of sums
    Format store = Format::rgba32f;   // of what each pass writes
};

// Irradiance of hemicubes, W/m2, from what their texels show; w: the share of fronts.
Buffer<glm::vec4> reduced_irradiance(int size, const Buffer<glm::vec4>& texels, const std::vector<double>& weights, const Reduction& how,
                                     const RunOptions& options);

}  // namespace plumb::radiosity
