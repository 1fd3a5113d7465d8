#include "tools/plumb/export_files.h"

#include <algorithm>
#include <cmath>

#include "core/content_hash.h"
#include "io/file.h"
#include "io/filling.h"
#include "tools/plumb/export_readme.h"
#include "tools/plumb/stage_case.h"

namespace plumb::cli {

std::string ExportFiles::write(const std::string& name, const void* data, std::size_t bytes) {
    outputs_.write(name, [&](const std::string& path) { io::write_file(path, {{static_cast<const char*>(data), bytes}}); });
    hashes_[name] = hash_text(content_hash(data, bytes));
    bytes_ += bytes;
    return folder_ + "/" + name;
}

io::DumpSpec ExportFiles::input(const std::string& id, const Slot& slot, const Array& array) {
    const std::pair key(content_hash(array.bytes.data(), array.bytes.size()), array.bytes.size());
    std::string& name = inputs_[key];
    if (name.empty()) {
        name = id + "/in/" + slot.name + ".bin";
        write(name, array.bytes.data(), array.bytes.size());
    }
    return spec(name, slot, array);
}

io::DumpSpec ExportFiles::output(const std::string& id, const Slot& slot, const Array& expected, const Array* device) {
    const std::string file = slot.name + ".bin", name = id + "/out/" + file;
    io::DumpSpec spec = this->spec(name, slot, expected);
    spec.expected = write(id + "/expected/" + file, expected.bytes.data(), expected.bytes.size());
    if (device) {
        write(name, device->bytes.data(), device->bytes.size());
        return spec;
    }
    std::uint32_t word = filling_;
    while (io::holds_word(expected.bytes.data(), expected.bytes.size(), word)) word = io::next_filling(word);
    const std::vector<unsigned char> nothing = io::filled_bytes(word, expected.bytes.size());
    write(name, nothing.data(), nothing.size());
    spec.filling = word;
    return spec;
}

io::DumpSpec ExportFiles::choices(const std::string& id, const MadeOutputs& made, glm::ivec2 size) {
    if (made.choices_a_pixel != 2) return {};
    io::DumpSpec spec;
    spec.vk_format = "R32G32_SINT";
    spec.width = size.x, spec.height = size.y;
    spec.file = write(id + "/out/choices.bin", made.choices.data(), made.choices.size() * sizeof made.choices[0]);
    return spec;
}

io::DumpSpec ExportFiles::spec(const std::string& name, const Slot& slot, const Array& array) const {
    io::DumpSpec spec;
    spec.file = folder_ + "/" + name;
    spec.vk_format = vk_format(slot);
    const std::int64_t texels = std::int64_t(array.bytes.size()) / (4 * slot.channels);
    if (slot.kind == SlotKind::buffer || slot.kind == SlotKind::storage_buffer) {
        spec.count = int(texels);
    } else {
        spec.width = int(slot.kind == SlotKind::image_array ? array.shape[2] : array.shape[1]);
        spec.height = int(texels / spec.width);  // layers lie one below the other
    }
    return spec;
}

io::ManifestStage export_stage(const StageBinding& binding, const StageData& data, const std::string& light,
                               const Bundle& expected, const MadeOutputs& made, ExportFiles& files) {
    io::ManifestStage stage;
    stage.stage = data.stage;
    stage.label = data.label;
    stage.light = light;
    stage.face = face_of(data);
    stage.width = data.size.x;
    stage.height = data.size.y;
    stage.block = files.write(data.id + "/block.bin", data.uniforms.data(), data.uniforms.size());
    // By name, for people to read and to change; only the file holds what is not finite.
    for (const UniformMember& member : binding.uniforms) {
        const std::vector<double> value = uniform_value(binding, data, member.name);
        if (!std::all_of(value.begin(), value.end(), [](double v) { return std::isfinite(v); })) stage.uniforms_file = stage.block;
        stage.uniforms[member.name] = value;
    }
    if (!stage.uniforms_file.empty()) stage.uniforms.clear();
    if (data.reversed_z) stage.params["reversed_z"] = {"true"};
    for (const Slot& slot : binding.inputs) stage.inputs[slot.name] = files.input(data.id, slot, at(data.inputs, slot.name));
    for (const Slot& slot : binding.outputs)
        stage.outputs[slot.name] = files.output(data.id, slot, at(expected, slot.name), find(made.outputs, slot.name));
    stage.choices = files.choices(data.id, made, data.size);
    return stage;
}

}  // namespace plumb::cli
