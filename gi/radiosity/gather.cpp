#include "gi/radiosity/gather.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "gi/lend.h"

namespace plumb::radiosity {

namespace {

constexpr int fold = 64;  // elements in a row of the domain

}  // namespace

Buffer<float> planes_of(const Buffer<glm::vec4>& radiosity) {
    const std::size_t n = radiosity.size(), stride = n + row_lanes;
    Buffer<float> planes(3 * stride, 0.0f);
    for (std::size_t i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c) planes[std::size_t(c) * stride + i] = radiosity[i][c];
    return planes;
}

StageData data_of(const GatherInputs& in) {
    const char* stage = "radiosity.gather";
    if (!in.block || !in.own || !in.radiosity || in.block->count < 1)
        throw InputError(fmt::format("{}: block, own and radiosity must be bound", stage));
    const RowBlock& b = *in.block;
    const int elements = int(in.radiosity->size());
    if (in.own->size() != in.radiosity->size() || b.first < 0 || b.first > elements - b.count)
        throw InputError(fmt::format("{}: rows {} to {} of {} elements, {} of them with irradiance of their own", stage, b.first,
                                     b.first + b.count, elements, in.own->size()));
    const glm::ivec2 size(std::min(b.count, fold), (b.count + fold - 1) / fold);
    StageData d = begin_data<GatherKernel>(size, GatherUniforms{size.x, size.y, b.count, elements});
    lend(d.inputs, "rows", {b.count, 4}, &b.rows[0].x);
    if (b.runs.empty())
        add(d.inputs, "runs", DType::i32, {1, 2});
    else
        lend(d.inputs, "runs", {std::int64_t(b.runs.size()), 2}, &b.runs[0].x);
    if (in.decoded) {
        Array& weights = add(d.inputs, "weights", DType::f32, {std::int64_t(b.weights.size()), 1});
        float* to = reinterpret_cast<float*>(weights.bytes.data());
        for (const Half h : b.weights) *to++ = half_to_float(h);
    } else {
        lend(d.inputs, "half_weights", {std::int64_t(b.weights.size()), 1}, b.weights.data());
    }
    lend(d.inputs, "scale", {b.count, 1}, b.scale.data());
    lend(d.inputs, "own", {b.count, 4}, &(*in.own)[std::size_t(b.first)].x);
    lend(d.inputs, "radiosity", {elements, 4}, &(*in.radiosity)[0].x);
    if (in.planes) lend(d.inputs, "planes", {std::int64_t(in.planes->size()), 1}, in.planes->data());
    return d;
}

void gather(const FormFactors& f, const Buffer<glm::vec4>& own, const Buffer<glm::vec4>& radiosity, const RunOptions& options,
            Buffer<glm::vec4>& irradiance) {
    irradiance.resize(radiosity.size());
    const Buffer<float> planes = planes_of(radiosity);
    f.each_block([&](const RowBlock& block) {
        GatherInputs in{&block, &own, &radiosity, &planes};
        run(stage<GatherKernel>(), data_of(in), options, &irradiance[std::size_t(block.first)].x);
    });
}

}  // namespace plumb::radiosity
