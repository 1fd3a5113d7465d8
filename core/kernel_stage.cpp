#include "core/kernel_stage.h"

#include <algorithm>

namespace plumb {

namespace {

// "normal" is the twin's normal_image, or its normal.
bool stands_for(const std::string& name, const std::string& variable) {
    return variable == name || variable == name + "_image";
}

// What the twin binds. No shader declares the depth buffer that a raster stage writes.
std::vector<TwinBinding> bindings_of(const TwinLayout& twin) {
    std::vector<TwinBinding> all(twin.bindings.begin(), twin.bindings.end());
    if (twin.raster) all.push_back({"depth", TwinKind::depth, 0, "float"});
    return all;
}

template <class... Args>
[[noreturn]] void refuse(const TwinLayout& twin, fmt::format_string<Args...> text, Args&&... args) {
    throw std::logic_error(fmt::format("{}: {}", twin.path, fmt::format(text, std::forward<Args>(args)...)));
}

const TwinBinding& find_variable(const std::vector<TwinBinding>& bindings, const TwinLayout& twin,
                                 const std::string& name) {
    for (const TwinBinding& b : bindings)
        if (stands_for(name, b.name)) return b;
    refuse(twin, "\"{}\" is no binding of the twin", name);
}

// Every binding has its one place in the description.
void check_all_named(const std::vector<TwinBinding>& bindings, const TwinLayout& twin, const NamedStage& stage) {
    for (const TwinBinding& b : bindings) {
        const auto named = [&](const NamedSlot& s) { return stands_for(s.name, b.name); };
        const auto times = std::count_if(stage.inputs.begin(), stage.inputs.end(), named) +
                           std::count_if(stage.outputs.begin(), stage.outputs.end(), named);
        if (times != 1)
            refuse(twin, "the twin binds \"{}\", which the description names {}", b.name,
                   times == 0 ? "nowhere" : "more than once");
    }
}

void set_element(Slot& slot, const std::string& element) {
    slot.dtype = element.starts_with("i") ? DType::i32 : element.starts_with("u") ? DType::u32 : DType::f32;
    const std::size_t vec = element.find("vec");
    slot.channels = element.empty() ? 4 : vec == std::string::npos ? 1 : element[vec + 3] - '0';
}

Slot slot_of(const NamedSlot& named, const TwinLayout& twin, const TwinBinding& b, bool output) {
    Slot s{.name = named.name, .binding = b.binding, .channels = named.channels, .frame = named.frame, .unit = named.unit,
           .meaning = named.meaning, .fixed = named.fixed, .unwritten = named.unwritten, .optional = named.optional,
           .instead = named.instead};
    switch (b.kind) {
        case TwinKind::sampled_image: s.kind = SlotKind::image; break;
        case TwinKind::sampled_array: s.kind = SlotKind::image_array, s.channels = 1; break;
        case TwinKind::storage_image: s.kind = SlotKind::storage_image, set_element(s, b.element); break;
        case TwinKind::target: s.kind = SlotKind::target, set_element(s, b.element); break;
        case TwinKind::buffer: s.kind = SlotKind::buffer, s.frame = false, set_element(s, b.element); break;
        case TwinKind::depth: s.kind = SlotKind::depth, set_element(s, b.element); break;
        case TwinKind::storage_buffer: s.kind = SlotKind::storage_buffer, set_element(s, b.element); break;
    }
    const bool readable = b.kind == TwinKind::sampled_image || b.kind == TwinKind::sampled_array ||
                          b.kind == TwinKind::buffer;
    if (readable == output)
        refuse(twin, "the twin {} \"{}\", the description has it among its {}", readable ? "reads" : "writes", named.name,
               output ? "outputs" : "inputs");
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

StageBinding binding_of(const NamedStage& stage, const TwinLayout& twin) {
    StageBinding binding;
    binding.info.name = stage.name, binding.info.source = stage.source;
    binding.info.params = stage.params, binding.info.budget = stage.budget;
    binding.domain = stage.domain, binding.cost = stage.cost;
    binding.twin = twin.path;
    binding.info.twin = binding.twin + (twin.raster ? ".frag" : "");
    binding.raster = twin.raster;
    binding.uniform_bytes = twin.block_bytes;
    for (const TwinMember& m : twin.members) binding.uniforms.push_back({m.name, m.type, m.offset});
    for (const auto& [name, fixed] : stage.fixed_uniforms) {
        const auto member = std::find_if(binding.uniforms.begin(), binding.uniforms.end(),
                                         [&, &name = name](const UniformMember& m) { return m.name == name; });
        if (member == binding.uniforms.end())
            refuse(twin, "\"{}\" is no member of the twin's uniform block", name);
        member->fixed = fixed;
    }
    const std::vector<TwinBinding> bindings = bindings_of(twin);
    auto slot = [&](const NamedSlot& s, bool output) {
        return slot_of(s, twin, find_variable(bindings, twin, s.name), output);
    };
    for (const NamedSlot& s : stage.inputs) binding.inputs.push_back(slot(s, false));
    for (const NamedSlot& s : stage.outputs) binding.outputs.push_back(slot(s, true));
    check_all_named(bindings, twin, stage);
    for (const Slot& s : binding.inputs) binding.info.inputs.push_back(port_of(s));
    for (const Slot& s : binding.outputs) binding.info.outputs.push_back(port_of(s));
    return binding;
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
