#include "gi/radiosity/reduce.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/lend.h"

namespace plumb::radiosity {

namespace {

const char* const name = "radiosity.reduce";

// The largest divisor of `size` from 2 to `most`; the smallest above where there is none.
int divisor(int size, int most) {
    for (int d = std::min(size, most); d >= 2; --d)
        if (size % d == 0) return d;
    int d = most + 1;
    while (size % d != 0) ++d;
    return d;
}

}  // namespace

StageData data_of(const ReduceInputs& in) {
    if (!in.texels || in.texels->empty()) throw InputError(fmt::format("{}: texels must be bound", name));
    if (in.columns < 1 || in.rows < 1 || in.box.x < 1 || in.box.y < 1 || in.columns % in.box.x != 0 || in.rows % in.box.y != 0)
        throw InputError(fmt::format("{}: hemicubes of {} x {} texels: expected boxes that divide them, not {} x {}", name, in.columns, in.rows, in.box.x, in.box.y));
    const std::size_t texels = std::size_t(in.columns) * std::size_t(in.rows), hemicubes = in.texels->size() / texels;
    if (hemicubes * texels != in.texels->size() || hemicubes * std::size_t(in.rows) > std::size_t(rows_a_dispatch))
        throw InputError(fmt::format("{}: {} texels: expected whole hemicubes of {}, and at most {} at once", name, in.texels->size(), texels, rows_a_dispatch / in.rows));
    if (in.weights && in.weights->size() != texels) throw InputError(fmt::format("{}: {} weights of {} texels", name, in.weights->size(), texels));
    const glm::ivec2 left(in.columns / in.box.x, int(hemicubes) * in.rows / in.box.y);
    StageData d = begin_data<ReduceKernel>(left, ReduceUniforms{left.x, left.y, in.box.x, in.box.y, in.rows, in.weights ? 1 : 0, in.gain, 0});
    lend(d.inputs, "texels", {std::int64_t(in.texels->size()), 4}, &(*in.texels)[0].x);
    static const float one = 1;
    lend(d.inputs, "weights", {in.weights ? std::int64_t(texels) : 1, 1}, in.weights ? in.weights->data() : &one);
    return d;
}

std::vector<glm::ivec2> reduction_boxes(int size, int most) {
    if (size < 2 || size > largest_hemicube || size % 2 != 0)
        throw InputError(fmt::format("{}: size = {}: expected an even number of 2 to {} texels", name, size, largest_hemicube));
    if (most < 2 || most > largest_hemicube) throw InputError(fmt::format("{}: box = {}: expected 2 to {} texels", name, most, largest_hemicube));
    std::vector<glm::ivec2> boxes;
    for (int left = size; left > 1;) {
        const int side = divisor(left, most);
        boxes.push_back({side, side}), left /= side;
    }
    boxes.push_back({1, 3});
    return boxes;
}

Buffer<glm::vec4> reduced_irradiance(int size, const Buffer<glm::vec4>& texels, const std::vector<double>& weights, const Reduction& how,
                                     const RunOptions& options) {
    const float whole = how.means ? float(weights.size()) : 1.0f;
    Buffer<float> scaled;
    for (const double w : weights) scaled.push_back(float(w) * whole);
    Buffer<glm::vec4> before, after;
    const Buffer<glm::vec4>* from = &texels;
    const Buffer<float>* first = &scaled;
    int columns = size, rows = rows_of_hemicube(size);
    for (const glm::ivec2 box : reduction_boxes(size, how.box)) {
        const float gain = how.means ? 1.0f / float(box.x * box.y) : 1.0f;
        const StageData d = data_of(ReduceInputs{from, columns, rows, first, box, gain});
        after.assign(std::size_t(d.size.x) * std::size_t(d.size.y), glm::vec4(0));
        Bundle outputs;
        lend(outputs, "sums", {std::int64_t(after.size()), 4}, &after[0].x);
        stage<ReduceKernel>().bind(d)->run(options, {}, outputs);
        if (how.store != Format::rgba32f)
            parallel_bands(int(after.size()), 4096, options.threads, [&](int a, int z) {
                for (int i = a; i < z; ++i) quantise(how.store, after[std::size_t(i)]);
            });
        before.swap(after);
        from = &before, first = nullptr, columns /= box.x, rows /= box.y;
    }
    return before;
}

}  // namespace plumb::radiosity
