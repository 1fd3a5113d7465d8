#include "tools/plumb/coverage.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/inexact_inputs.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

namespace {

// Whole texels of zeros, in each layer.
void clear(Array& array, std::size_t layers, const std::vector<bool>& covered) {
    const std::size_t pixels = covered.size(), texel = array.bytes.size() / (pixels * layers);
    for (std::size_t i = 0; i < pixels * layers; ++i)
        if (!covered[i % pixels]) std::fill_n(array.bytes.begin() + std::ptrdiff_t(i * texel), texel, 0);
}

}  // namespace

std::vector<bool> read_coverage(const io::ManifestStage& stage, glm::ivec2 expected) {
    if (stage.coverage.dump.file.empty()) return {};
    const std::string place = stage.place + ": coverage";
    const Array array = io::read_dump(stage.coverage.dump).array;
    const glm::ivec2 size = image_size(array, place);
    if (size != expected)
        throw InputError(fmt::format("{}: is {} x {}: the stage's outputs are {} x {}", place, size.x, size.y, expected.x,
                                     expected.y));
    const std::vector<double> values = numbers(array, place);
    std::vector<bool> covered(std::size_t(size.x) * std::size_t(size.y));
    const std::size_t channels = values.size() / covered.size();
    for (std::size_t i = 0; i < covered.size(); ++i)
        covered[i] = values[i * channels] > stage.coverage.above && values[i * channels] < stage.coverage.below;
    return covered;
}

void apply_coverage(const io::ManifestStage& stage, StageCase& out) {
    const std::vector<bool>& covered = out.covered;
    if (covered.empty()) return;
    for (const Slot& slot : out.binding->inputs)
        for (Array& input : out.data.inputs.arrays)
            if ((input.name == slot.name || input.name == moved_name(slot.name)) && slot.frame &&
                slot.kind != SlotKind::buffer)
                clear(input, slot.kind == SlotKind::image_array ? std::size_t(input.shape[0]) : 1, covered);
    // Indices have a code of their own for nothing.
    for (parity::Dumped& output : out.dumped) {
        if (stage.outputs.at(output.output).encoding == "plain" || output.array.dtype != DType::f32) continue;
        clear(output.array, 1, covered);
        if (!output.rounding.bytes.empty()) clear(output.rounding, 1, covered);
    }
    const std::ptrdiff_t masked = std::count(covered.begin(), covered.end(), false);
    out.notes.push_back(fmt::format("coverage: nothing is seen at {} of {} pixels", masked, covered.size()));
}

}  // namespace plumb::cli
