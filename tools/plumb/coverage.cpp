#include "tools/plumb/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

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

// As the manifest says; else as a depth buffer does of which positions of the frame are made.
io::CoverageSpec coverage_of(const io::ManifestStage& stage, const StageBinding& binding) {
    if (!stage.coverage.dump.file.empty()) return stage.coverage;
    for (const Slot& slot : binding.inputs) {
        const auto input = stage.inputs.find(slot.name);
        if (!slot.frame || input == stage.inputs.end() || !input->second.from_depth) continue;
        io::CoverageSpec spec{input->second};
        spec.above = input->second.from_depth->reversed_z ? 0 : -std::numeric_limits<double>::infinity();
        if (!input->second.from_depth->reversed_z) spec.below = 1;
        return spec;
    }
    return {};
}

}  // namespace

std::vector<bool> read_coverage(const io::ManifestStage& stage, const StageBinding& binding, glm::ivec2 expected) {
    const io::CoverageSpec spec = coverage_of(stage, binding);
    if (spec.dump.file.empty()) return {};
    const std::string place = stage.place + ": coverage";
    const Array array = io::read_dump(spec.dump).array;
    const glm::ivec2 size = image_size(array, place);
    if (size != expected)
        throw InputError(fmt::format("{}: is {} x {}: the stage's outputs are {} x {}", place, size.x, size.y, expected.x,
                                     expected.y));
    const std::vector<double> values = numbers(array, place);
    std::vector<bool> covered(std::size_t(size.x) * std::size_t(size.y));
    const std::size_t channels = values.size() / covered.size();
    for (std::size_t i = 0; i < covered.size(); ++i)
        covered[i] = values[i * channels] > spec.above && values[i * channels] < spec.below;
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
    // What is seen is what such a stage makes: its outputs say it themselves. Indices have a code of their own for nothing.
    const bool makes_it = out.binding->raster;
    for (parity::Dumped& output : out.dumped) {
        if (!makes_it || stage.outputs.at(output.output).encoding == "plain" || output.array.dtype != DType::f32) continue;
        clear(output.array, 1, covered);
        if (!output.rounding.bytes.empty()) clear(output.rounding, 1, covered);
    }
    const std::ptrdiff_t masked = std::count(covered.begin(), covered.end(), false);
    out.notes.push_back(fmt::format("coverage: nothing is seen at {} of {} pixels{}", masked, covered.size(),
                                    makes_it ? "" : ", which are left out"));
    if (makes_it) out.covered.clear();
}

}  // namespace plumb::cli
