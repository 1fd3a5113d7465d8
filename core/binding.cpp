#include "core/binding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error.h"
#include "core/fields.h"
#include "core/nearest_known.h"
#include "core/parallel.h"

namespace plumb {

namespace {

constexpr int largest_side = 32767;
// Of what is written as a list of rows: 65,535 groups of 8, which every Vulkan device can.
constexpr int most_rows = 524280;

[[noreturn]] void refuse(const StageData& data, const std::string& cause) {
    throw InputError((data.label.empty() ? data.stage : data.label) + ": " + cause);
}

int components(const std::string& type) { return type.starts_with("vec") ? type[3] - '0' : 1; }

const UniformMember& find_member(const StageBinding& binding, const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const UniformMember& m : binding.uniforms) {
        if (m.name == name) return m;
        names.push_back(m.name);
    }
    throw InputError(fmt::format("{}: {} has no uniform \"{}\"{}", place, binding.info.name, name,
                                 nearest_known(name, names, "\"\"")));
}

// What a shape must be, for messages: "[1080, 1920, 4]".
Shape expected_shape(const Slot& slot, const StageData& data) {
    const std::int64_t w = slot.frame ? data.size.x : any_extent, h = slot.frame ? data.size.y : any_extent;
    if (slot.kind == SlotKind::buffer) return {any_extent, slot.channels};
    if (slot.kind == SlotKind::storage_buffer) return {std::int64_t(data.size.x) * data.size.y, slot.channels};
    if (slot.kind == SlotKind::image_array) return {any_extent, h, w};
    if (slot.channels == 1) return {h, w};
    return {h, w, slot.channels};
}

void check_shape(const Slot& slot, const StageData& data, const Array& array) {
    if (array.dtype != slot.dtype)
        refuse(data, fmt::format("input \"{}\" holds {}: expected {}", slot.name, dtype_name(array.dtype),
                                 dtype_name(slot.dtype)));
    // Buffers may have any shape of whole elements: [samples][rotations] is one of int32.
    if (slot.kind == SlotKind::buffer) {
        const std::size_t n = element_count(slot.name, array.shape);
        if (n == 0 || n % std::size_t(slot.channels) != 0)
            refuse(data, fmt::format("input \"{}\" has {} numbers: expected elements of {}", slot.name, n, slot.channels));
        return;
    }
    const Shape expected = expected_shape(slot, data);
    bool fits = array.shape.size() == expected.size();
    for (std::size_t i = 0; fits && i < expected.size(); ++i)
        fits = (expected[i] == any_extent || expected[i] == array.shape[i]) && array.shape[i] >= 1 &&
               array.shape[i] <= largest_side;
    if (!fits)
        refuse(data, fmt::format("input \"{}\" is {}: expected {}", slot.name, shape_text(array.shape),
                                 shape_text(expected)));
    // Kernels count the texels of all layers by one index of 32 bits.
    if (slot.kind == SlotKind::image_array && element_count(slot.name, array.shape) > 0x7fffffff)
        refuse(data, fmt::format("input \"{}\" has {} layers: too many", slot.name, array.shape[0]));
}

}  // namespace

void check_slots(const StageBinding& binding, const StageData& data) {
    // A list has no side that an image would be.
    const auto lists = [](const std::vector<Slot>& slots) {
        return std::all_of(slots.begin(), slots.end(), [](const Slot& s) { return s.kind == SlotKind::storage_buffer; });
    };
    const int most = lists(binding.outputs) && data.size.y == 1 ? 0x7fffffff : largest_side;
    const int rows = lists(binding.outputs) ? most_rows : largest_side;
    if (data.size.x < 1 || data.size.y < 1 || data.size.x > most || data.size.y > rows)
        refuse(data, fmt::format("size {} x {}: expected 1 to {}{}", data.size.x, data.size.y, most,
                                 rows > most ? fmt::format(", and at most {} rows", rows) : ""));
    if (data.uniforms.size() != binding.uniform_bytes)
        refuse(data, fmt::format("the uniform block has {} bytes: expected {}", data.uniforms.size(),
                                 binding.uniform_bytes));
    for (const Slot& slot : binding.inputs) {
        const Array* array = find(data.inputs, slot.name);
        if (!array && (slot.optional || (!slot.instead.empty() && find(data.inputs, slot.instead)))) continue;
        if (!array) refuse(data, fmt::format("input \"{}\" is missing", slot.name));
        check_shape(slot, data, *array);
    }
}

std::vector<double> uniform_value(const StageBinding& binding, const StageData& data, const std::string& member) {
    const UniformMember& m = find_member(binding, member, binding.info.name);
    std::vector<double> value;
    for (int c = 0; c < components(m.type); ++c) {
        const unsigned char* p = data.uniforms.data() + m.offset + 4 * c;
        std::uint32_t bits;
        std::memcpy(&bits, p, 4);
        float f;
        std::memcpy(&f, p, 4);
        value.push_back(m.type == "int" ? double(std::int32_t(bits)) : m.type == "uint" ? double(bits) : double(f));
    }
    return value;
}

void set_uniform(const StageBinding& binding, StageData& data, const std::string& member, std::span<const double> value,
                 const std::string& place) {
    const UniformMember& m = find_member(binding, member, place);
    if (int(value.size()) != components(m.type))
        throw InputError(fmt::format("{}: {} takes {} number{}, {} given", place, member, components(m.type),
                                     components(m.type) == 1 ? "" : "s", value.size()));
    for (std::size_t c = 0; c < value.size(); ++c) {
        const double v = value[c], low = m.type == "int" ? -0x1p31 : 0, high = m.type == "int" ? 0x1p31 : 0x1p32;
        const bool whole = m.type == "int" || m.type == "uint";
        if (whole && !(v == std::floor(v) && v >= low && v < high))
            throw InputError(fmt::format("{}: {} = {}: expected a whole number of 32 bits", place, member, v));
        const std::uint32_t bits = m.type == "int" ? std::uint32_t(std::int32_t(v)) : whole ? std::uint32_t(v) : 0;
        const float f = float(v);
        if (!whole && !std::isfinite(f))
            throw InputError(fmt::format("{}: {} = {}: {}", place, member, v,
                                         std::isfinite(v) ? "is too large for a float" : "expected a finite number"));
        std::memcpy(data.uniforms.data() + m.offset + 4 * int(c), whole ? (const void*)&bits : (const void*)&f, 4);
    }
}

const float* floats(const StageData& data, const std::string& input) {
    return reinterpret_cast<const float*>(at(data.inputs, input).bytes.data());
}
const std::int32_t* ints(const StageData& data, const std::string& input) {
    return reinterpret_cast<const std::int32_t*>(at(data.inputs, input).bytes.data());
}

StageData begin_data(const StageBinding& binding, glm::ivec2 size, std::vector<unsigned char> uniforms) {
    StageData d;
    d.stage = d.label = binding.info.name;
    d.size = size;
    d.uniforms = std::move(uniforms);
    return d;
}

StageData owned(const StageBinding& binding, const StageData& data) {
    StageData copy = data;
    Bundle inputs;
    for (const Slot& slot : binding.inputs) {
        if (const Array* array = find(data.inputs, slot.name)) {
            inputs.arrays.push_back(*array);
            inputs.arrays.back().bytes.own();
        } else {
            if (!slot.optional) refuse(data, fmt::format("input \"{}\" is missing", slot.name));
            // How long a buffer would be, or how large an image that is not the frame's, the stage alone knows: it stays missing.
            if (slot.kind != SlotKind::buffer && slot.frame) add(inputs, slot.name, slot.dtype, expected_shape(slot, data));
        }
    }
    copy.inputs = std::move(inputs);
    copy.tiles = {};
    return copy;
}

namespace {

bool reads(const StageData& data, const void* memory) {
    for (const Array& array : data.inputs.arrays)
        if (array.bytes.data() == memory) return true;
    return false;
}

// Runs into memory that is lent to the bundle.
void run_bound(const StageBinding& binding, const StageData& data, const BoundStage& bound, const RunOptions& options,
               float* output) {
    const Slot& slot = binding.outputs.at(0);
    Bundle outputs;
    lend(outputs, slot.name, expected_shape(slot, data), output);
    bound.run(options, {}, outputs);
}

// Into what `output` holds already where that fits and is not read, since
// memory that is new to a process costs more than small stages.
template <class T>
void run_into(const StageBinding& binding, const StageData& data, const RunOptions& options, Image<T>& output, T fill) {
    const std::unique_ptr<BoundStage> bound = binding.bind(data);
    const std::size_t texels = std::size_t(data.size.x) * std::size_t(data.size.y);
    const bool fits = output.width == data.size.x && output.height == data.size.y && output.size() == texels &&
                      !reads(data, output.data());
    Image<T> result = fits ? std::move(output) : Image<T>(data.size.x, data.size.y, fill);
    if (fits && data.tiles.any) std::fill(result.texels.begin(), result.texels.end(), fill);
    run_bound(binding, data, *bound, options, reinterpret_cast<float*>(result.data()));
    output = std::move(result);
}

}  // namespace

void run(const StageBinding& binding, const StageData& data, const RunOptions& options, Image4& output) {
    run_into(binding, data, options, output, binding.outputs.at(0).unwritten);
}
void run(const StageBinding& binding, const StageData& data, const RunOptions& options, Image1& output) {
    run_into(binding, data, options, output, binding.outputs.at(0).unwritten.x);
}
void run(const StageBinding& binding, const StageData& data, const RunOptions& options, float* output) {
    run_bound(binding, data, *binding.bind(data), options, output);
}

std::vector<TapValue> explain(const StageBinding& binding, const StageData& data, glm::ivec2 pixel) {
    return binding.bind(data)->explain(pixel);
}

void run_double(const StageBinding& binding, const StageData& data, const RunOptions& options, Image<glm::dvec4>& output) {
    const std::unique_ptr<BoundStage> bound = binding.bind(data);
    output = Image<glm::dvec4>(data.size.x, data.size.y);
    parallel_bands(data.size.y, 1, options, [&](int y, int) {
        std::vector<double> value;
        for (int x = 0; x < data.size.x; ++x) {
            value.clear();
            bound->in_double({x, y}, value);
            for (std::size_t c = 0; c < std::min<std::size_t>(value.size(), 4); ++c) output(x, y)[int(c)] = value[c];
        }
    });
}

void BoundStage::in_double(glm::ivec2, std::vector<double>&) const {
    throw std::logic_error("this stage has no form in double");
}

Bundle make_outputs(const StageBinding& binding, const StageData& data) {
    Bundle outputs;
    for (const Slot& slot : binding.outputs) {
        Array& array = add(outputs, slot.name, slot.dtype, expected_shape(slot, data));
        if (slot.dtype == DType::i32) std::fill(array.bytes.begin(), array.bytes.end(), 0xff);
        if (slot.dtype == DType::f32 && slot.unwritten != glm::vec4(0)) {
            float* p = reinterpret_cast<float*>(array.bytes.data());
            for (std::size_t i = 0; i < array.bytes.size() / 4; ++i) p[i] = slot.unwritten[int(i % std::size_t(slot.channels))];
        }
    }
    return outputs;
}

}  // namespace plumb
