#include "tools/plumb/validate_init.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "io/file.h"
#include "io/manifest.h"
#include "tools/plumb/case_pattern.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/init_files.h"
#include "tools/plumb/init_formats.h"
#include "tools/plumb/init_stub.h"
#include "tools/plumb/slot_array.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

struct Guess {
    std::string file, stage, slot, format;
};

struct Start {
    io::Manifest manifest;
    std::vector<Guess> guesses;
    std::vector<std::string> missing, unused;
    std::map<std::string, std::string> why;      // of what is not used
    std::map<std::string, std::string> refused;  // of a file that is named like a slot: which, and why it cannot be that
};

// ---- One stage ----------------------------------------------------------------------------------------------------

// The binding that a folder is named after: "shadow.key" after "shadow".
const StageBinding* named_after(const std::string& name) {
    const StageBinding* best = nullptr;
    for (const StageBinding& binding : parity::bindings()) {
        const std::string& stage = binding.info.name;
        const bool fits = name == stage || (name.starts_with(stage) &&
                                            std::string("._- ").find(name[stage.size()]) != std::string::npos);
        if (fits && (!best || stage.size() > best->info.name.size())) best = &binding;
    }
    return best;
}

// The file of the slot: the one whose name is most like it.
const DumpFile* file_of(const Slot& slot, bool output, const std::vector<const DumpFile*>& files, const StageBinding& binding) {
    const DumpFile* best = nullptr;
    double most = 0;
    for (const DumpFile* file : files) {
        if (output ? file->in : file->out) continue;
        const double score = likeness(file->words, slot.name);
        if (score <= most) continue;
        // Another slot of that side that the name fits better has it.
        double other = 0;
        for (const Slot& s : output ? binding.outputs : binding.inputs)
            if (s.name != slot.name) other = std::max(other, likeness(file->words, s.name));
        if (other >= score) continue;
        best = file;
        most = score;
    }
    return best;
}

// The light of a folder: ".key" of "shadow.key".
std::string light_of(const std::string& group) {
    const StageBinding* binding = named_after(group);
    return binding ? group.substr(binding->info.name.size()) : "";
}

// What several stages read may lie with one of them; a light's map with one of the same light.
const DumpFile* shared_file(const Slot& slot, const std::vector<DumpFile>& files, const StageBinding& binding,
                        const std::string& group) {
    std::vector<const DumpFile*> near, far;
    for (const DumpFile& file : files)
        if (file.in && named_after(file.group)) (light_of(file.group) == light_of(group) ? near : far).push_back(&file);
    if (slot.frame || slot.kind == SlotKind::buffer) near.insert(near.end(), far.begin(), far.end());
    return file_of(slot, false, near, binding);
}

std::vector<unsigned char> block_of(const fs::path& folder, const StageBinding& binding,
                                    const std::vector<const DumpFile*>& files, fs::path& path) {
    for (const DumpFile* file : files) {
        const bool named = likeness(file->words, "block") > 0 || likeness(file->words, "uniforms") > 0;
        if (!file->raw || !named || file->bytes != binding.uniform_bytes) continue;
        path = folder / file->path;
        return io::read_bytes(path.string());
    }
    return {};
}

glm::ivec2 picture_size(const fs::path& folder, const DumpFile& file) {
    io::DumpSpec spec;
    spec.file = folder / file.path;
    return image_size(io::read_dump(spec).array, spec.file.string());
}

// The size of the outputs: of the block, of a picture, or one that is known from another stage.
glm::ivec2 frame_size(const fs::path& folder, const StageBinding& binding, const std::vector<unsigned char>& block,
                      const std::vector<const DumpFile*>& files, const std::vector<glm::ivec2>& known) {
    StageData data;
    data.uniforms = block;
    std::map<std::string, double> sides;
    for (const UniformMember& m : binding.uniforms)
        if (!block.empty() && (m.name == "width" || m.name == "height"))
            sides[m.name] = uniform_value(binding, data, m.name).at(0);
    if (sides.size() == 2) return {int(sides["width"]), int(sides["height"])};
    for (const Slot& slot : binding.outputs) {
        const DumpFile* file = file_of(slot, true, files, binding);
        if (!file) continue;
        if (!file->raw) return picture_size(folder, *file);
        const std::size_t texels = file->bytes / (4 * std::size_t(slot.channels));
        for (const glm::ivec2 size : known)
            if (file->bytes % (std::size_t(size.x) * std::size_t(size.y)) == 0) return size;
        for (const Slot& input : binding.inputs) {
            const DumpFile* picture = input.frame ? file_of(input, false, files, binding) : nullptr;
            if (picture && !picture->raw) return picture_size(folder, *picture);
        }
        if (square(texels).x > 0) return square(texels);
    }
    return glm::ivec2(0);
}

// Pixels that nothing covers tell what the depth buffer was cleared to: 0 where z is reversed, 1 otherwise.
void guess_reversed_z(const std::string& label, io::ManifestStage& stage, Start& start) {
    const auto depth = stage.outputs.find("depth");
    if (depth == stage.outputs.end()) return;
    const Array dump = io::read_dump(depth->second).array;
    std::int64_t zeros = 0, ones = 0;
    const std::vector<double> values = numbers(dump, depth->second.file.string());
    const std::size_t channels = dump.shape.size() == 3 ? std::size_t(dump.shape[2]) : 1;
    for (std::size_t i = 0; i < values.size(); i += channels) zeros += values[i] == 0, ones += values[i] == 1;
    if (zeros == 0 && ones == 0) start.missing.push_back(label + ": params.reversed_z = true, if z is reversed");
    if (zeros <= ones) return;
    stage.params["reversed_z"] = {"true"};
    start.guesses.push_back({depth->second.file.lexically_relative(start.manifest.file.parent_path()).string(), label,
                             "params.reversed_z", "cleared to 0"});
}

// Files of maps, as far as they are raw, of one side.
int side_of_maps(const StageBinding& binding, const std::vector<const DumpFile*>& files) {
    std::vector<std::pair<const Slot*, std::size_t>> maps;
    for (const Slot& slot : binding.inputs) {
        const DumpFile* file = !slot.frame && slot.kind == SlotKind::image ? file_of(slot, false, files, binding) : nullptr;
        if (file && file->raw && file->bytes > 0) maps.emplace_back(&slot, file->bytes);
    }
    return map_side(maps);
}

// What nothing covers holds what a depth buffer was cleared to, or a stencil of 0.
void guess_coverage(const fs::path& folder, const std::string& label, const std::vector<const DumpFile*>& files,
                    std::set<const DumpFile*>& used, io::ManifestStage& stage, Start& start) {
    const std::size_t texels = std::size_t(stage.width) * std::size_t(stage.height);
    for (const DumpFile* file : files) {
        const bool depth = likeness(file->words, "depth") > 0, stencil = likeness(file->words, "stencil") > 0;
        if (used.count(file) || file->out || (!depth && !stencil) || texels == 0 || file->bytes == 0) continue;
        io::CoverageSpec coverage;
        coverage.dump.file = folder / file->path;
        if (file->raw) {
            const std::size_t each = file->bytes / texels;
            if (file->bytes % texels != 0 || (each != 1 && each != 2 && each != 4)) continue;
            coverage.dump.vk_format = each == 1 ? "R8_UINT" : each == 2 ? "D16_UNORM" : "D32_SFLOAT";
            coverage.dump.width = stage.width, coverage.dump.height = stage.height;
        }
        Array dump = io::read_dump(coverage.dump).array;
        if (image_size(dump, file->path.string()) != glm::ivec2(stage.width, stage.height)) continue;
        std::int64_t zeros = 0, ones = 0, beyond = 0;
        const std::vector<double> values = numbers(dump, file->path.string());
        for (std::size_t i = 0; i < values.size(); i += values.size() / texels)
            zeros += values[i] == 0, ones += values[i] == 1, beyond += !(values[i] >= 0 && values[i] <= 1);
        if (!stencil && (beyond > 0 || zeros + ones == 0)) continue;
        const bool far_is_one = !stencil && ones >= zeros;
        if (far_is_one) coverage.above = -std::numeric_limits<double>::infinity(), coverage.below = 1;
        stage.coverage = coverage;
        used.insert(file);
        start.guesses.push_back({file->path.string(), label, "coverage", far_is_one ? "cleared to 1" : "cleared to 0"});
        return;
    }
}

// The shader's own samples: a .npy named after them. Where they lie between texels the stage is the one that reads such.
void guess_pattern(const fs::path& folder, const std::string& label, const std::vector<const DumpFile*>& files,
                   std::set<const DumpFile*>& used, io::ManifestStage& stage, Start& start) {
    for (const DumpFile* file : files) {
        const bool named = likeness(file->words, "pattern") > 0 || likeness(file->words, "samples") > 0 ||
                           likeness(file->words, "kernel") > 0;
        if (!named || io::extension_of(file->path.string()) != "npy" || used.count(file)) continue;
        io::DumpSpec spec;
        spec.file = folder / file->path;
        const Array rows = io::read_dump(spec).array;
        if (rows.shape.size() != 2 || (rows.shape[1] != 2 && rows.shape[1] != 3)) {
            start.missing.push_back(fmt::format("{}: input.pattern: {} is {}: expected [N, 2] or [N, 3]", label,
                                                file->path.string(), shape_text(rows.shape)));
            continue;
        }
        const std::vector<double> values = numbers(rows, file->path.string());
        bool between = false;
        for (std::size_t i = 0; i < values.size(); ++i)
            between |= i % std::size_t(rows.shape[1]) < 2 && values[i] != std::floor(values[i]);
        const std::string continuous = stage.stage + "_continuous";
        const std::vector<StageBinding>& all = parity::bindings();
        if (between && std::any_of(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == continuous; }))
            stage.label.replace(stage.label.size() - stage.stage.size(), stage.stage.size(), continuous), stage.stage = continuous;
        stage.inputs["pattern"] = spec;
        used.insert(file);
        start.guesses.push_back({file->path.string(), label, "input.pattern",
                                 fmt::format("{} samples{}", rows.shape[0], between ? ", between texels" : "")});
        return;
    }
}

// What the pattern takes the place of.
bool given_by_pattern(const io::ManifestStage& stage, const Slot& slot) {
    const auto pattern = stage.inputs.find("pattern");
    if (pattern == stage.inputs.end()) return false;
    if (slot.name == "offsets" || slot.name == "positions") return true;
    return slot.name == "weights" && io::read_dump(pattern->second).array.shape[1] == 3;
}

std::string format_text(const io::DumpSpec& spec) {
    if (spec.vk_format.empty()) return "";
    const std::string size = spec.count > 0 ? fmt::format("{} elements", spec.count) : fmt::format("{} x {}", spec.width, spec.height);
    return fmt::format("{}, {}{}", spec.vk_format, size, spec.encoding == "plain" ? "" : ", " + spec.encoding);
}

void add_slot(const fs::path& folder, const Slot& slot, bool output, const std::string& label, const DumpFile* file,
              glm::ivec2 frame, int map, std::set<const DumpFile*>& used, io::ManifestStage& stage, Start& start) {
    const std::string name = (output ? "output." : "input.") + slot.name;
    io::DumpSpec spec;
    const std::string refused = !file ? "no file is named like it" : !file->raw ? "" : guess_raw(slot, file->bytes, frame, map, spec);
    if (!refused.empty()) {
        if (slot.optional && !file) return;
        if (file) start.refused[file->path.string()] = fmt::format("as {} of {} it {}", name, stage.stage, refused);
        start.missing.push_back(fmt::format("{}: {}{}", label, name, file ? ": " + file->path.string() + " " + refused : ""));
        return;
    }
    spec.file = folder / file->path;
    used.insert(file);
    start.guesses.push_back({file->path.string(), label, name, format_text(spec)});
    (output ? stage.outputs : stage.inputs)[slot.name] = spec;
}

void add_stage(const fs::path& folder, const StageBinding& binding, const std::string& label,
               const std::vector<const DumpFile*>& files, const std::vector<DumpFile>& all, std::vector<glm::ivec2>& known,
               std::set<const DumpFile*>& used, Start& start) {
    io::ManifestStage stage;
    stage.stage = binding.info.name;
    stage.label = label;
    const std::vector<unsigned char> block = block_of(folder, binding, files, stage.uniforms_file);
    const glm::ivec2 frame = frame_size(folder, binding, block, files, known);
    const int map = side_of_maps(binding, files);
    if (frame.x > 0) known.push_back(frame);
    stage.width = frame.x;
    stage.height = frame.y;
    for (const DumpFile* file : files)
        if (!block.empty() && folder / file->path == stage.uniforms_file) used.insert(file);
    if (block.empty() && !binding.uniforms.empty())
        start.missing.push_back(label + ": the uniforms: fill in [stage.uniforms], or name a scene");
    if (pattern_slot(binding)) guess_pattern(folder, label, files, used, stage, start);
    for (const bool output : {false, true})
        for (const Slot& slot : output ? binding.outputs : binding.inputs) {
            if (!output && given_by_pattern(stage, slot)) continue;
            const DumpFile* file = file_of(slot, output, files, binding);
            if (!file && !output) file = shared_file(slot, all, binding, label);
            add_slot(folder, slot, output, label, file, frame, map, used, stage, start);
        }
    if (const Slot* slot = pattern_slot(binding); slot && !stage.inputs.count("pattern") && !stage.inputs.count(slot->name))
        start.missing.push_back(fmt::format("{}: or input.pattern in place of {}: the shader's own samples, a .npy [N, 3] of dx, dy, "
                                            "weight; where they lie between texels, the stage {}_continuous", label, slot->name,
                                            stage.stage));
    if (binding.raster)
        guess_reversed_z(label, stage, start);
    else
        guess_coverage(folder, label, files, used, stage, start);
    if (!stage.outputs.empty()) start.manifest.stages.push_back(std::move(stage));
}

// Whether no stage before it in the list writes an output of that name.
bool writes_first(const StageBinding& binding, const std::string& output) {
    for (const StageBinding& other : parity::bindings()) {
        if (&other == &binding) return true;
        for (const Slot& slot : other.outputs)
            if (slot.name == output) return false;
    }
    return true;
}

bool any_of_slots(const std::vector<Slot>& slots, bool output, const std::vector<const DumpFile*>& files,
                  const StageBinding& binding) {
    return std::any_of(slots.begin(), slots.end(),
                       [&](const Slot& slot) { return file_of(slot, output, files, binding) != nullptr; });
}

// Whether the file is rather an input of another stage, of which outputs lie there: nothing else of this one does.
bool read_by_another(const DumpFile& file, const StageBinding& binding, const std::vector<const DumpFile*>& files) {
    if (any_of_slots(binding.inputs, false, files, binding)) return false;
    const std::vector<StageBinding>& all = parity::bindings();
    return std::any_of(all.begin(), all.end(), [&](const StageBinding& other) {
        return &other != &binding && !other.raster && any_of_slots(other.outputs, true, files, other) &&
               std::any_of(other.inputs.begin(), other.inputs.end(),
                           [&](const Slot& slot) { return file_of(slot, false, files, other) == &file; });
    });
}

// Whether dumps that lie together hold what the stage writes. Of stages whose outputs have the same name a file is the first
// one's, but where it names another.
bool written_by(const StageBinding& binding, const std::vector<const DumpFile*>& files) {
    if (binding.raster) return false;
    for (const Slot& slot : binding.outputs) {
        const DumpFile* file = file_of(slot, true, files, binding);
        if (!file || read_by_another(*file, binding, files)) continue;
        auto names = [&](const StageBinding& b) {
            return std::find(file->words.begin(), file->words.end(), b.info.name) != file->words.end();
        };
        const std::vector<StageBinding>& all = parity::bindings();
        if (names(binding) || (writes_first(binding, slot.name) && std::none_of(all.begin(), all.end(), names))) return true;
    }
    return false;
}

Start guess(const fs::path& folder) {
    std::map<std::string, std::string> unread;
    const std::vector<DumpFile> files = find_files(folder, unread);
    if (files.empty()) throw InputError(io::shown(folder.string()), "", "holds no dumps that a manifest could name");
    Start start;
    start.manifest.file = folder / "manifest.toml";
    std::map<std::string, std::vector<const DumpFile*>> groups;
    for (const DumpFile& file : files) groups[file.group].push_back(&file);

    // A folder named after a stage is one dispatch of it; stages that know their size come first.
    std::vector<glm::ivec2> known;
    std::set<const DumpFile*> used;
    for (const bool raster : {false, true})
        for (const auto& [group, members] : groups)
            if (const StageBinding* binding = named_after(group); binding && binding->raster == raster)
                add_stage(folder, *binding, group, members, files, known, used, start);
    for (const auto& [group, members] : groups) {
        if (named_after(group)) continue;
        for (const StageBinding& binding : parity::bindings())
            if (written_by(binding, members))
                add_stage(folder, binding, (group.empty() ? "" : group + ": ") + binding.info.name, members, files,
                          known, used, start);
    }
    for (const DumpFile& file : files)
        if (!used.count(&file)) {
            start.unused.push_back(file.path.string());
            const auto refused = start.refused.find(file.path.string());
            start.why[file.path.string()] = file.bytes == 0                ? "it is empty"
                                            : refused != start.refused.end() ? refused->second
                                                                             : "no input or output of these stages is named like it";
        }
    for (const auto& [name, why] : unread) start.unused.push_back(name), start.why[name] = why;
    std::vector<std::string> order;
    for (const StageBinding& binding : parity::bindings()) order.push_back(binding.info.name);
    std::stable_sort(start.manifest.stages.begin(), start.manifest.stages.end(),
                     [&](const io::ManifestStage& a, const io::ManifestStage& b) {
                         return std::find(order.begin(), order.end(), a.stage) <
                                std::find(order.begin(), order.end(), b.stage);
                     });
    return start;
}

std::string comment(const Start& start) {
    std::string text =
        "# What was dumped from a GPU, pass by pass: guessed from the names of the files. Look through all of it, "
        "then\n"
        "#     plumb validate manifest.toml\n"
        "# io/README.md lists the keys. What is often needed:\n"
        "#     scene = \"scene.toml\"       # gives uniforms, patterns and geometry that were not dumped\n"
        "#     channels = \"xyz\"           # of an output whose alpha means nothing\n"
        "#     encoding = \"biased\"        # of an input: normals stored as 0..1; or octahedral, reversed_depth, ...\n"
        "#     flip_y = true              # the first row is the lowest\n";
    for (const std::string& missing : start.missing) text += "# missing: " + io::printable(missing, 400) + "\n";
    for (const std::string& unused : start.unused)
        text += fmt::format("# not used: {}: {}\n", io::printable(unused, 400), start.why.at(unused));
    return text + "\n";
}

// The manifest's text with what is to be filled in of each stage that has no block.
std::string with_stubs(const io::Manifest& manifest) {
    const std::string text = io::manifest_text(manifest), mark = "\n[[stage]]\n";
    std::string out = text.substr(0, text.find(mark));
    std::size_t at = out.size();
    for (const io::ManifestStage& stage : manifest.stages) {
        const std::size_t next = text.find(mark, at + 1);
        std::string part = text.substr(at, next == text.npos ? next : next - at);
        const StageBinding& binding = parity::find_binding(stage.stage, stage.stage);
        int map = 0;
        for (const Slot& slot : binding.inputs)
            if (const auto input = stage.inputs.find(slot.name); !slot.frame && slot.kind == SlotKind::image && input != stage.inputs.end())
                map = std::max(map, input->second.width);
        if (stage.uniforms_file.empty()) {
            const std::size_t dumps = std::min(part.find("\n[stage.input"), part.find("\n[stage.output")) + 1;
            part.insert(dumps, uniforms_stub(binding, stage, map));
        }
        out += part;
        at = next;
    }
    return out;
}

}  // namespace

int init_manifest(const std::string& given, bool json) {
    const fs::path folder(given);
    std::error_code error;
    if (!fs::is_directory(folder, error)) throw InputError(io::shown(given), "", "is no folder");
    const std::string path = (folder / "manifest.toml").string();
    if (fs::exists(fs::symlink_status(path, error)))
        throw InputError(io::shown(path), "", "is there already, and is kept");
    const Start start = guess(folder);
    if (start.manifest.stages.empty() && !start.refused.empty()) {
        const auto& [file, why] = *start.refused.begin();
        throw InputError(io::shown((folder / file).string()), "", why + ": no stage is known that wrote it");
    }
    if (start.manifest.stages.empty())
        throw InputError(io::shown(given), "",
                         "no dump here is named like an output of a stage (`plumb stages` lists them): irradiance, "
                         "visibility, radiance, display");
    io::write_text(path, comment(start) + with_stubs(start.manifest));

    if (json) {
        Json guessed = Json::array();
        for (const Guess& g : start.guesses)
            guessed.push_back({{"file", g.file}, {"stage", g.stage}, {"slot", g.slot}, {"format", g.format}});
        const auto report = json_text(
            {{"manifest", path}, {"guessed", guessed}, {"missing", start.missing}, {"unused", start.unused}});
        std::fputs(report.c_str(), stdout);
        return success;
    }
    std::vector<std::vector<std::string>> rows;
    for (const Guess& g : start.guesses) rows.push_back({io::printable(g.file, 200), g.stage, g.slot, g.format});
    std::string text = format_table({{"file"}, {"stage"}, {"is"}, {"read as"}}, rows);
    if (!start.missing.empty()) text += "\nnot found:\n";
    for (const std::string& missing : start.missing) text += "  " + io::printable(missing, 400) + "\n";
    if (!start.unused.empty()) text += "\nnot used:\n";
    for (const std::string& unused : start.unused)
        text += fmt::format("  {}: {}\n", io::printable(unused, 400), start.why.at(unused));
    text += "\nwrote " + path + ": look through it, then run plumb validate " + path + "\n";
    std::fputs(text.c_str(), stdout);
    return success;
}

}  // namespace plumb::cli
