#include "core/kernel_stage.h"

namespace plumb {

namespace {

// "normal" is the twin's normal_image, or its normal.
bool stands_for(const std::string& name, const std::string& variable) {
    return variable == name || variable == name + "_image";
}

const TwinBinding& find_variable(const TwinLayout& twin, const std::string& name) {
    for (const TwinBinding& b : twin.bindings)
        if (stands_for(name, b.name)) return b;
    throw std::logic_error(fmt::format("{}: \"{}\" is no binding of the twin", twin.path, name));
}

void set_element(Slot& slot, const std::string& element) {
    slot.dtype = element.starts_with("i") ? DType::i32 : element.starts_with("u") ? DType::u32 : DType::f32;
    const std::size_t vec = element.find("vec");
    slot.channels = element.empty() ? 4 : vec == std::string::npos ? 1 : element[vec + 3] - '0';
}

Slot slot_of(const NamedSlot& named, const TwinBinding& b, bool output) {
    Slot s{.name = named.name, .binding = b.binding, .channels = named.channels, .frame = named.frame, .unit = named.unit,
           .meaning = named.meaning, .fixed = named.fixed, .unwritten = named.unwritten, .optional = named.optional,
           .instead = named.instead};
    switch (b.kind) {
        case TwinKind::sampled_image: s.kind = SlotKind::image; break;
        case TwinKind::sampled_array: s.kind = SlotKind::image_array, s.channels = 1; break;
        case TwinKind::storage_image: s.kind = SlotKind::storage_image, set_element(s, b.element); break;
        case TwinKind::target: s.kind = SlotKind::target, set_element(s, b.element); break;
        case TwinKind::buffer: s.kind = SlotKind::buffer, s.frame = false, set_element(s, b.element); break;
        case TwinKind::storage_buffer: s.kind = SlotKind::storage_buffer, set_element(s, b.element); break;
    }
    const bool writable = b.kind == TwinKind::storage_image || b.kind == TwinKind::storage_buffer || b.kind == TwinKind::target;
    if (writable != output) throw std::logic_error(fmt::format("{}: the twin {} it", named.name, writable ? "writes" : "reads"));
    return s;
}

// "image rgba32f", "image r32f", "image array r32f", "buffer i32", "buffer f32 x 2".
Port port_of(const Slot& s) {
    std::string type;
    if (s.kind == SlotKind::buffer || s.kind == SlotKind::storage_buffer) {
        type = fmt::format("buffer {}", dtype_name(s.dtype));
        if (s.channels > 1) type += fmt::format(" x {}", s.channels);
    } else {
        const char* of = s.dtype == DType::f32 ? "f" : s.dtype == DType::i32 ? "i" : "ui";
        type = fmt::format("image {}{}32{}", s.kind == SlotKind::image_array ? "array " : "",
                           s.channels == 1 ? "r" : s.channels == 2 ? "rg" : "rgba", of);
    }
    return {s.name, type, s.unit, s.meaning};
}

}  // namespace

void add_slots(StageBinding& binding, const TwinLayout& twin, const std::vector<NamedSlot>& inputs,
               const std::vector<NamedSlot>& outputs,
               const std::vector<std::pair<std::string, std::uint32_t>>& fixed_uniforms) {
    binding.twin = binding.info.twin = twin.path;
    binding.raster = twin.raster;
    binding.uniform_bytes = twin.block_bytes;
    for (const TwinMember& m : twin.members) {
        UniformMember member{m.name, m.type, m.offset};
        for (const auto& [name, fixed] : fixed_uniforms)
            if (name == m.name) member.fixed = fixed;
        binding.uniforms.push_back(member);
    }
    for (const NamedSlot& s : inputs) binding.inputs.push_back(slot_of(s, find_variable(twin, s.name), false));
    for (const NamedSlot& s : outputs) binding.outputs.push_back(slot_of(s, find_variable(twin, s.name), true));
    for (const Slot& s : binding.inputs) binding.info.inputs.push_back(port_of(s));
    for (const Slot& s : binding.outputs) binding.info.outputs.push_back(port_of(s));
    if (inputs.size() + outputs.size() != twin.bindings.size())
        throw std::logic_error(fmt::format("{}: the twin binds {} images and buffers, the description names {}", twin.path,
                                           twin.bindings.size(), inputs.size() + outputs.size()));
}

void check_uniforms(const StageBinding& binding, const StageData& data, const std::vector<Within>& ranges) {
    for (const Within& range : ranges) {
        const double value = uniform_value(binding, data, range.member)[0];
        if (!(value >= range.low && value <= range.high))
            throw InputError(fmt::format("{}: {} = {}: expected {} to {}", data.label, range.member, value, range.low,
                                         range.high));
    }
}

void check_size(const StageData& data, const std::string& input, glm::ivec2 size, const std::string& why) {
    const Shape& shape = at(data.inputs, input).shape;
    if (size != glm::ivec2(0) && (shape[0] != size.y || shape[1] != size.x))
        throw InputError(fmt::format("{}: input \"{}\" is {} x {}: expected {} x {}{}", data.label, input, shape[1],
                                     shape[0], size.x, size.y, why.empty() ? "" : ", " + why));
}

void check_count(const StageData& data, const Slot& slot, std::size_t count, const std::string& why) {
    const std::size_t there = element_count(slot.name, at(data.inputs, slot.name).shape) / std::size_t(slot.channels);
    if (there < count)
        throw InputError(fmt::format("{}: input \"{}\" has {} elements: expected {}{}", data.label, slot.name, there, count,
                                     why.empty() ? "" : ", " + why));
}

bool is_lent(const StageData& data, const std::string& name, DType dtype) {
    const Array* array = find(data.inputs, name);
    return array && array->dtype == dtype;
}

void check_lent(const StageData& data, const std::string& name, std::size_t count, const std::string& why) {
    const Array& array = at(data.inputs, name);
    const std::size_t there = array.bytes.size() / dtype_size(array.dtype);
    if (there < count)
        throw InputError(fmt::format("{}: input \"{}\" has {} numbers: expected {}{}", data.label, name, there, count,
                                     why.empty() ? "" : ", " + why));
}

}  // namespace plumb
