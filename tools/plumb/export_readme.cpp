#include "tools/plumb/export_readme.h"

#include <fmt/format.h>

#include <filesystem>

#include "io/file.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

// The last line's end before it, and two empty lines.
const std::string section_start = "\n\n\n";

const char* kind_text(SlotKind kind) {
    switch (kind) {
        case SlotKind::image: return "sampled image, texelFetch";
        case SlotKind::image_array: return "sampled array of images";
        case SlotKind::buffer: return "storage buffer, read only";
        case SlotKind::storage_image: return "storage image, write only";
        case SlotKind::target: return "colour target";
        case SlotKind::depth: return "depth buffer";
    }
    return "";
}

bool is_image(const Slot& slot) { return slot.kind != SlotKind::buffer; }

std::vector<std::string> slot_row(const Slot& slot, const io::DumpSpec& spec, const Array* array,
                                  const std::string& folder) {
    const std::string size = is_image(slot) ? fmt::format("{} {} x {}", vk_format(slot), spec.width, spec.height)
                                            : fmt::format("{} {}", dtype_name(slot.dtype),
                                                          array ? shape_text(array->shape) : "");
    const std::string place = slot.kind == SlotKind::depth ? "-" : fmt::format("{}", slot.binding);
    return {place, slot.name, kind_text(slot.kind), size, spec.file.lexically_relative(folder).string(),
            slot.unit.empty() || slot.meaning.ends_with(slot.unit) ? slot.meaning : fmt::format("{}, {}", slot.meaning, slot.unit)};
}

std::string raster_text(const StageData& data) {
    return fmt::format(
        "  Draw 3 vertices a triangle with the vertex stage that pulls them from the buffers, no vertex input; cull\n"
        "  nothing; depth test {}, cleared to {}; colour cleared to 0, indices to -1; viewport {} x {}.\n",
        data.reversed_z ? "greater" : "less", data.reversed_z ? 0 : 1, data.size.x, data.size.y);
}

}  // namespace

std::string vk_format(const Slot& slot) {
    const char* names[] = {"", "R32", "R32G32", "R32G32B32", "R32G32B32A32"};
    const char* type = slot.dtype == DType::f32 ? "_SFLOAT" : slot.dtype == DType::i32 ? "_SINT" : "_UINT";
    return std::string(names[slot.channels]) + type;
}

ExportReadme::ExportReadme(const std::string& scene, const std::string& device) {
    head_ = fmt::format(
        "Exported from {} by `plumb export`.\n\n"
        "Every file is raw, little-endian, rows from the top without padding: what a GPU binds. All of it is set 0.\n"
        "in/ holds what a pass reads, expected/ what it should write, out/ {}. Bind in/ and\n"
        "block.bin, run your pass, write its outputs over those in out/ (or name your own files and their formats in\n"
        "manifest.toml), then\n\n"
        "    plumb validate manifest.toml\n\n",
        scene, device.empty() ? "what no pass writes" : "what the GLSL twin wrote on " + device);
    head_ += device.empty()
                 ? "out/ is filled with one 32-bit word, `filling` in manifest.toml, which is in no expected output: read as\n"
                   "a float it is a NaN that no arithmetic makes, as an integer it is less than -1. Where it still stands,\n"
                   "where a file is missing, empty or ends early, the pixel was never written, and is wrong.\n"
                 : "What the twin wrote is judged where you write nothing over it: `plumb validate` notes it.\n";
    head_ +=
        "Each export has a word of its own, so that out/ of another one is told. Told by their hashes are inputs and\n"
        "blocks that have changed since. Not told is what an earlier run of your program wrote for this same export, if\n"
        "the last one wrote nothing: before each run\n\n"
        "    plumb validate --refill manifest.toml\n\n"
        "fills out/ anew. A file in out/ whose time is before its export's is named in a note, and decides nothing: copies\n"
        "and caches need not keep times. To see a pass agree, copy expected/ over out/.\n";
}

void ExportReadme::add(const StageBinding& binding, const StageData& data, const io::ManifestStage& stage,
                       const std::string& folder) {
    std::string text = fmt::format("\n\n{}\n{}\n{}\n", data.label, std::string(data.label.size(), '-'), binding.info.source);
    text += fmt::format("  GLSL twin {}{}\n", binding.twin, binding.raster ? ".vert, .frag" : "");
    text += binding.raster ? raster_text(data)
                           : fmt::format("  Dispatch {} x {} x 1 groups of 8 x 8 x 1 for {} x {} pixels.\n",
                                         (data.size.x + 7) / 8, (data.size.y + 7) / 8, data.size.x, data.size.y);

    std::vector<std::vector<std::string>> rows = {
        {"0", "block", "uniform buffer, std140", fmt::format("{} bytes", data.uniforms.size()), data.id + "/block.bin", ""}};
    for (const Slot& slot : binding.inputs)
        rows.push_back(slot_row(slot, stage.inputs.at(slot.name), find(data.inputs, slot.name), folder));
    for (const Slot& slot : binding.outputs) rows.push_back(slot_row(slot, stage.outputs.at(slot.name), nullptr, folder));
    text += "\n" + format_table({{"binding"}, {"name"}, {"kind"}, {"format"}, {"file"}, {"meaning"}}, rows, 2);
    if (binding.raster) text += "  (of a colour target: its location)\n";

    rows.clear();
    for (const UniformMember& m : binding.uniforms)
        rows.push_back({fmt::format("{}", m.offset), m.type, m.name, exact_text(uniform_value(binding, data, m.name))});
    stages_ += text + "\n" + format_table({{"byte", Align::right}, {"type"}, {"uniform"}, {"value"}}, rows, 2);
}

void ExportReadme::keep(const std::string& earlier, const std::vector<std::string>& labels) {
    std::error_code error;
    const std::string text = std::filesystem::is_regular_file(earlier, error) ? io::read_text(earlier) : "";
    for (const std::string& label : labels) {
        const std::size_t at = text.find(section_start + label + "\n---");
        if (at == text.npos) {
            kept_ += fmt::format("{}{}\n{}\nmanifest.toml has its files.\n", section_start.substr(1), label,
                                 std::string(label.size(), '-'));
            continue;
        }
        const std::size_t end = text.find(section_start, at + section_start.size());
        kept_ += text.substr(at + 1, end == text.npos ? end : end - at);
    }
}

}  // namespace plumb::cli
