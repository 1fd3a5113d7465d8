#include "tools/plumb/case_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

namespace {

std::vector<float> given_weights(const StageData& data) {
    const Array* weights = find(data.inputs, "weights");
    if (!weights || weights->dtype != DType::f32) return {};
    const float* w = floats(data, "weights");
    return {w, w + weights->bytes.size() / sizeof(float)};
}

// The side of the light's map: of the images that are not of the frame's size.
double map_side(const StageBinding& binding, const StageData& data, const std::string& place) {
    for (const Slot& slot : binding.inputs) {
        const Array* map = slot.kind == SlotKind::image && !slot.frame ? find(data.inputs, slot.name) : nullptr;
        if (map) return double(map->shape.at(1));
    }
    throw InputError(place + ": unit = \"map\": the map's images were not dumped; expected them, or texels");
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

std::string continuous_stage(const StageBinding& binding) {
    const std::string name = binding.info.name + "_continuous";
    const std::vector<StageBinding>& all = parity::bindings();
    const bool there = std::any_of(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == name; });
    return there ? fmt::format("; where a shader samples between texels, stage = \"{}\"", name) : "";
}

std::string texels_fault(const std::string& place, std::size_t row, double d, bool whole) {
    return fmt::format("{}: row {}: {}: expected {}texels of at most 32767", place, row, d, whole ? "whole " : "");
}

namespace {

// The samples of a manifest: one pattern, or one for each pixel of a tile.
struct PatternFile {
    std::size_t tiles = 1, samples = 0, columns = 0;
    std::vector<double> values;  // [tiles][samples][columns]

    PatternFile(const io::DumpSpec& spec, const std::string& place) {
        const Array pattern = io::read_dump(spec).array;
        const std::size_t of_tile = std::size_t(spec.tile[0]) * std::size_t(spec.tile[1]);
        Shape shape = pattern.shape;
        if (of_tile > 0 && shape.size() == 4 && shape[0] == spec.tile[1] && shape[1] == spec.tile[0])
            shape = {shape[0] * shape[1], shape[2], shape[3]};
        const std::size_t first = of_tile > 0 ? 1 : 0;
        const bool shaped = shape.size() == first + 2 && (shape.back() == 2 || shape.back() == 3) && shape[first] >= 1 &&
                            shape[first] <= 1 << 20 && (first == 0 || shape[0] == std::int64_t(of_tile));
        if (!shaped)
            throw InputError(fmt::format("{}: is {}: expected {}", place, shape_text(pattern.shape),
                                         of_tile > 0 ? fmt::format("[{}, N, 2] or [{}, N, 3]: for each pixel of the tile, row "
                                                                   "by row, what else is [N, 2] or [N, 3]", of_tile, of_tile)
                                                     : "[N, 2] (dx, dy in texels) or [N, 3] (and the weight)"));
        tiles = std::max<std::size_t>(of_tile, 1), samples = std::size_t(shape[first]), columns = std::size_t(shape.back());
        values = numbers(pattern, place);
    }
    double value(std::size_t tile, std::size_t k, std::size_t c) const { return values[(tile * samples + k) * columns + c]; }
};

// [tiles][samples]: the third column, or the input "weights", of one pattern or of all.
std::vector<double> weights_of(const PatternFile& file, const StageData& data, const std::string& place) {
    std::vector<double> all(file.tiles * file.samples);
    const std::vector<float> given = file.columns == 3 ? std::vector<float>{} : given_weights(data);
    if (file.columns == 2 && given.size() != file.samples && given.size() != all.size())
        throw InputError(fmt::format("{}: has no third column, and there is no input \"weights\" of {}: expected the "
                                     "texels that each sample stands for", place, file.samples));
    for (std::size_t i = 0; i < all.size(); ++i)
        all[i] = file.columns == 3 ? file.value(i / file.samples, i % file.samples, 2) : double(given[i % given.size()]);
    return all;
}

}  // namespace

void set_pattern(const StageBinding& binding, const io::DumpSpec& spec, const std::string& place, StageData& data) {
    const PatternFile file(spec, place);
    const std::size_t n = file.samples, tiles = file.tiles;
    const std::vector<double> given = weights_of(file, data, place);
    const bool whole = pattern_slot(binding)->name == "offsets";
    const double texels = spec.radius * (spec.of_map ? map_side(binding, data, place) : 1);
    std::vector<std::int32_t> offsets(n * tiles);
    std::vector<float> positions(2 * n * tiles), weights(n * tiles);
    double reach = 0;
    for (std::size_t i = 0; i < n * tiles; ++i) {
        const std::size_t k = i / tiles, tile = i % tiles;
        for (std::size_t c = 0; c < 2; ++c) {
            const double d = file.value(tile, k, c) * texels * (c == 1 && spec.y_up ? -1 : 1);
            if (!((!whole || d == std::floor(d)) && std::abs(d) <= 32767))
                throw InputError(texels_fault(place, tile * n + k, d, whole) + (whole ? continuous_stage(binding) : ""));
            reach = std::max(reach, whole ? std::abs(d) : std::floor(std::abs(d)) + 2);
            if (whole) offsets[i] |= std::int32_t((std::uint32_t(std::int32_t(d)) & 0xffffu) << (16 * c));
            positions[2 * i + c] = float(d);
        }
        weights[i] = float(given[tile * n + k] * spec.weight_scale);
        if (!std::isfinite(weights[i]))
            throw InputError(fmt::format("{}: row {}: the weight is not finite", place, tile * n + k));
    }
    const std::int64_t rows = std::int64_t(n), columns = std::int64_t(tiles);
    Bundle made;
    if (whole)
        replace(data.inputs, add(made, "offsets", {rows, columns}, offsets.data()));
    else
        replace(data.inputs, add(made, "positions", {rows, columns, 2}, positions.data()));
    const Shape of_weights = tiles > 1 ? Shape{rows, columns} : Shape{rows};
    replace(data.inputs, add(made, "weights", of_weights, weights.data()));
    const double samples = double(n), rotations = double(tiles);
    const bool counted = std::any_of(binding.uniforms.begin(), binding.uniforms.end(),
                                     [](const UniformMember& m) { return m.name == "samples"; });
    if (counted) set_uniform(binding, data, "samples", {&samples, 1}, place);
    set_uniform(binding, data, "rotations", {&rotations, 1}, place);
    set_uniform(binding, data, "reach", {&reach, 1}, place);
}

}  // namespace plumb::cli
