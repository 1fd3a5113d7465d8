#include "tools/plumb/case_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

namespace {

std::vector<float> given_weights(const StageData& data, std::size_t n) {
    const Array* weights = find(data.inputs, "weights");
    if (!weights || weights->dtype != DType::f32 || weights->bytes.size() != n * sizeof(float)) return {};
    const float* w = floats(data, "weights");
    return {w, w + n};
}

// The side of the light's map: of the images that are not of the frame's size.
double map_side(const StageBinding& binding, const StageData& data, const std::string& place) {
    for (const Slot& slot : binding.inputs) {
        const Array* map = slot.kind == SlotKind::image && !slot.frame ? find(data.inputs, slot.name) : nullptr;
        if (map) return double(map->shape.at(1));
    }
    throw InputError(place + ": unit = \"map\": the map's images were not dumped; expected them, or texels");
}

// What to say of an offset that lies between texels: another stage may take it.
std::string continuous_stage(const StageBinding& binding) {
    const std::string name = binding.info.name + "_continuous";
    const std::vector<StageBinding>& all = parity::bindings();
    const bool there = std::any_of(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == name; });
    return there ? fmt::format("; where a shader samples between texels, stage = \"{}\"", name) : "";
}

}  // namespace

const Slot* pattern_slot(const StageBinding& binding) {
    const auto has = [&](const std::string& member) {
        return std::any_of(binding.uniforms.begin(), binding.uniforms.end(),
                           [&](const UniformMember& m) { return m.name == member; });
    };
    if (!has("reach") || !has("rotations")) return nullptr;
    for (const Slot& slot : binding.inputs)
        if (slot.name == "offsets" || slot.name == "positions") return &slot;
    return nullptr;
}

void set_pattern(const StageBinding& binding, const io::DumpSpec& spec, const std::string& place, StageData& data) {
    const Array pattern = io::read_dump(spec).array;
    const bool shaped = pattern.shape.size() == 2 && (pattern.shape[1] == 2 || pattern.shape[1] == 3);
    if (!shaped || pattern.shape[0] < 1 || pattern.shape[0] > 1 << 20)
        throw InputError(fmt::format("{}: is {}: expected [N, 2] (dx, dy in texels) or [N, 3] (and the weight)", place,
                                     shape_text(pattern.shape)));
    const std::size_t n = std::size_t(pattern.shape[0]), columns = std::size_t(pattern.shape[1]);
    const std::vector<double> values = numbers(pattern, place);
    std::vector<float> weights = columns == 3 ? std::vector<float>(n) : given_weights(data, n);
    if (weights.empty())
        throw InputError(fmt::format("{}: has no third column, and there is no input \"weights\" of {}: expected the "
                                     "texels that each sample stands for", place, n));
    const bool whole = pattern_slot(binding)->name == "offsets";
    const double texels = spec.radius * (spec.of_map ? map_side(binding, data, place) : 1);
    std::vector<std::int32_t> offsets(n);
    std::vector<float> positions(2 * n);
    double reach = 0;
    for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t c = 0; c < 2; ++c) {
            const double d = values[k * columns + c] * texels;
            if (!((!whole || d == std::floor(d)) && std::abs(d) <= 32767))
                throw InputError(fmt::format("{}: row {}: {}: expected {}texels of at most 32767{}", place, k, d,
                                             whole ? "whole " : "", whole ? continuous_stage(binding) : ""));
            reach = std::max(reach, whole ? std::abs(d) : std::floor(std::abs(d)) + 2);
            if (whole) offsets[k] |= std::int32_t((std::uint32_t(std::int32_t(d)) & 0xffffu) << (16 * c));
            positions[2 * k + c] = float(d);
        }
        const double weight = columns == 3 ? values[k * columns + 2] : double(weights[k]);
        weights[k] = float(weight * spec.weight_scale);
        if (!std::isfinite(weights[k]))
            throw InputError(fmt::format("{}: row {}: the weight is not finite", place, k));
    }
    Bundle made;
    if (whole)
        replace(data.inputs, add(made, "offsets", {std::int64_t(n), 1}, offsets.data()));
    else
        replace(data.inputs, add(made, "positions", {std::int64_t(n), 1, 2}, positions.data()));
    replace(data.inputs, add(made, "weights", {std::int64_t(n)}, weights.data()));
    const double samples = double(n), rotations = 1;
    const bool counted = std::any_of(binding.uniforms.begin(), binding.uniforms.end(),
                                     [](const UniformMember& m) { return m.name == "samples"; });
    if (counted) set_uniform(binding, data, "samples", {&samples, 1}, place);
    set_uniform(binding, data, "rotations", {&rotations, 1}, place);
    set_uniform(binding, data, "reach", {&reach, 1}, place);
}

}  // namespace plumb::cli
