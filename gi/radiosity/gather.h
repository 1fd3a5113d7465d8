// radiosity.gather: irradiance of elements from what leaves all others (HEM (4.30), (4.32)).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/radiosity/gather_kernel.h"
#include "gi/radiosity/rows.h"

namespace plumb::radiosity {

struct GatherInputs {
    using Kernel = GatherKernel;
    const RowBlock* block = nullptr;
    const Buffer<glm::vec4>* own = nullptr;        // H0 of all elements, W/m2
    const Buffer<glm::vec4>* radiosity = nullptr;  // B of all elements, W/m2
    const Buffer<float>* planes = nullptr;         // planes_of(*radiosity); null: made where it is needed
    bool decoded = false;                          // weights as floats, which a device reads
};

// B as three lists, with row_lanes zeros behind each.
Buffer<float> planes_of(const Buffer<glm::vec4>& radiosity);

inline StageDescription<GatherView> describe(GatherKernel) {
    using View = GatherView;
    return {
        .name = "radiosity.gather",
        .source = "HEM 4.5.3 (4.30), 4.5.4 (4.32)",
        .domain = "element",
        .inputs = {{.name = "rows", .at = &View::rows, .meaning = "of each element first run, runs, first weight, weights",
                    .count = [](const View& v) { return std::size_t(v.u.count); }, .why = "one an element"},
                   {.name = "runs", .at = &View::runs, .meaning = "first element, elements"},
                   {.name = "weights", .at = &View::weights, .meaning = "form factors over the row's scale, run by run", .instead = "half_weights"},
                   {.name = "scale", .at = &View::scale, .meaning = "of a row",
                    .count = [](const View& v) { return std::size_t(v.u.count); }, .why = "one an element"},
                   {.name = "own", .at = &View::own, .unit = "W/m2", .meaning = "irradiance of lamps and the sky",
                    .count = [](const View& v) { return std::size_t(v.u.count); }, .why = "one an element"},
                   {.name = "radiosity", .at = &View::radiosity, .unit = "W/m2", .meaning = "of all elements",
                    .count = [](const View& v) { return std::size_t(v.u.elements); }, .why = "as elements says"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "of the block's elements"}},
        .lends = {{.name = "half_weights", .at = &View::half_weights, .dtype = DType::f16, .count = [](const View&) { return std::size_t(0); }, .why = "as weights"},
                  {.name = "planes", .at = &View::planes, .dtype = DType::f32,
                   .count = [](const View& v) { return 3 * (std::size_t(v.u.elements) + row_lanes); }, .why = "radiosity as three lists"}},
        .uniforms = {{"count", 1, 1 << 26}, {"elements", 1, 1 << 26}},
        .cost = {0.15, "form factors"},
    };
}

// One dispatch: the block. Throws InputError where the lists do not fit each other.
StageData data_of(const GatherInputs& in);

// H of all elements. `own` null: 0.
void gather(const FormFactors& f, const Buffer<glm::vec4>& own, const Buffer<glm::vec4>& radiosity, const RunOptions& options,
            Buffer<glm::vec4>& irradiance);

}  // namespace plumb::radiosity
