#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gi/lend.h"
#include "gi/probes/density.h"
#include "gi/probes/supports.h"

namespace plumb::probes {

namespace {

constexpr int fold = 1024;  // candidates in a row: a list of any length, and a device's 65535 groups a side

int length_of(const char* stage, const char* what, const Buffer<glm::vec4>* list, int most) {
    if (!list || list->empty()) throw InputError(fmt::format("{}: no {}", stage, what));
    if (list->size() > std::size_t(most))
        throw InputError(fmt::format("{}: {} {}: expected at most {}", stage, list->size(), what, most));
    for (std::size_t i = 0; i < list->size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (!std::isfinite((*list)[i][c]))
                throw InputError(fmt::format("{}: {}: number {} is not finite", stage, what, i));
    return int(list->size());
}

void check_radius(const char* stage, float radius) {
    if (!(radius > 0 && std::isfinite(radius) && std::isfinite(1 / radius)))
        throw InputError(fmt::format("{}: radius = {}: expected a positive number", stage, radius));
}

const float* numbers(const Buffer<glm::vec4>& list) { return &list[0].x; }

}  // namespace

void bound_blocks(DensityView& view, Buffer<float>& own) {
    const int count = view.u.count, blocks = (count + block - 1) / block;
    own.resize(6 * std::size_t(blocks));
    for (int b = 0; b < blocks; ++b) {
        float* bounds = own.data() + 6 * std::ptrdiff_t(b);
        for (int c = 0; c < 3; ++c) {
            bounds[c] = bounds[3 + c] = view.positions[4 * std::ptrdiff_t(b) * block + c];
            for (int j = b * block; j < std::min((b + 1) * block, count); ++j) {
                const float x = view.positions[4 * std::ptrdiff_t(j) + c];
                bounds[c] = std::min(bounds[c], x), bounds[3 + c] = std::max(bounds[3 + c], x);
            }
        }
    }
    view.blocks = own.data();
}

StageData data_of(const DensityInputs& in) {
    const int count = length_of("probes.density", "candidates", in.positions, most_candidates);
    check_radius("probes.density", in.radius);
    const glm::ivec2 size(std::min(count, fold), (count + fold - 1) / fold);
    StageData d = begin_data<DensityKernel>(size, DensityUniforms{size.x, size.y, count, 1 / in.radius});
    lend(d.inputs, "positions", {count, 4}, numbers(*in.positions));
    return d;
}

void run(const DensityInputs& in, const RunOptions& options, Buffer<float>& density) {
    const StageData data = data_of(in);
    density.assign(std::size_t(data.size.x) * std::size_t(data.size.y), 0.0f);
    run(stage<DensityKernel>(), data, options, density.data());
    density.resize(in.positions->size());
}

StageData data_of(const SupportsInputs& in, int first, int count) {
    const int receivers = length_of("probes.supports", "receivers", in.receivers, 0x7fffffff);
    const int probes = length_of("probes.supports", "probes", in.probes, most_probes);
    check_radius("probes.supports", in.radius);
    if (in.overlaps < 1 || in.overlaps > most_overlaps)
        throw InputError(fmt::format("probes.supports: overlaps = {}: expected 1 to {}", in.overlaps, most_overlaps));
    if (first < 0 || count < 1 || count > receivers_a_dispatch || first > receivers - count)
        throw InputError(fmt::format("probes.supports: receivers {} to {} of {}: expected at most {} at once", first,
                                     std::int64_t(first) + count, receivers, receivers_a_dispatch));
    StageData d = begin_data<SupportsKernel>({in.overlaps, count},
                                             SupportsUniforms{in.overlaps, count, probes, in.radius});
    lend(d.inputs, "receivers", {count, 4}, numbers(*in.receivers) + 4 * std::ptrdiff_t(first));
    lend(d.inputs, "probes", {probes, 4}, numbers(*in.probes));
    return d;
}

Supports run(const SupportsInputs& in, const RunOptions& options) {
    Supports s;
    const int receivers = length_of("probes.supports", "receivers", in.receivers, 0x7fffffff);
    (void)data_of(in, 0, 1);
    s.overlaps = in.overlaps;
    const std::size_t slots = std::size_t(receivers) * std::size_t(in.overlaps);
    s.probe.resize(slots), s.weight.resize(slots);
    for (int first = 0; first < receivers; first += std::min(receivers_a_dispatch, receivers - first)) {
        const int count = std::min(receivers_a_dispatch, receivers - first);
        const StageData data = data_of(in, first, count);
        const std::ptrdiff_t at = std::ptrdiff_t(first) * in.overlaps;
        Bundle outputs;
        lend(outputs, "support", {std::int64_t(count) * in.overlaps, 1}, s.probe.data() + at);
        lend(outputs, "weight", {std::int64_t(count) * in.overlaps, 1}, s.weight.data() + at);
        stage<SupportsKernel>().bind(data)->run(options, {}, outputs);
    }
    for (std::size_t i = 0; i < slots; i += std::size_t(in.overlaps)) {
        if (s.probe[i] < 0)
            ++s.unsupported;
        else if (s.probe[i + std::size_t(in.overlaps) - 1] < 0)
            ++s.incomplete;
    }
    return s;
}

}  // namespace plumb::probes
