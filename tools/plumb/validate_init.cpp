#include "tools/plumb/validate_init.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "io/file.h"
#include "io/manifest.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/slot_array.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_files = 2000;

// Other words for the words of slots' names.
const std::vector<std::pair<std::string, std::vector<std::string>>> synonyms = {
    {"position", {"pos", "wpos", "worldpos", "world"}},
    {"normal", {"norm", "nrm", "nml"}},
    {"albedo", {"diffuse", "basecolor", "base", "reflectance"}},
    {"emission", {"emissive"}},
    {"irradiance", {"gi", "gather", "bounce", "lighting"}},
    {"visibility", {"shadow", "shadows", "lit"}},
    {"radiance", {"hdr", "color", "colour", "scene"}},
    {"display", {"ldr", "tonemapped", "final", "backbuffer"}},
    {"indirect", {"gi", "bounce"}},
    {"depth", {"zbuffer"}},
    {"map", {"rsm", "light"}},
    {"rsm", {"map"}},
    {"id", {"ids", "object", "objects"}},
};

// "GBuffer_worldPos0" is gbuffer, world, pos.
std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words(1);
    bool lower = false;
    for (char c : text) {
        const bool upper = c >= 'A' && c <= 'Z';
        const bool letter = upper || (c >= 'a' && c <= 'z');
        if (!letter || (upper && lower)) words.emplace_back();
        if (letter) words.back() += upper ? char(c - 'A' + 'a') : c;
        lower = letter && !upper;
    }
    std::erase_if(words, [](const std::string& w) { return w.empty(); });
    return words;
}

// The same word, a plural, or the start of one: "pos" of "position".
bool alike(const std::string& word, const std::string& term) {
    return word == term || (term.size() >= 3 && word.starts_with(term)) || (word.size() >= 3 && term.starts_with(word));
}

bool means(const std::string& word, const std::string& term) {
    if (alike(word, term)) return true;
    for (const auto& [name, others] : synonyms)
        if (name == term && std::find(others.begin(), others.end(), word) != others.end()) return true;
    return false;
}

// How well a file's words name something: 0 where a word of the name is not among them, more for longer names, less for
// words that are left over.
double likeness(const std::vector<std::string>& words, const std::string& name) {
    const std::vector<std::string> terms = words_of(name);
    double score = 0;
    for (const std::string& term : terms) {
        double best = 0;
        for (const std::string& word : words)
            best = std::max(best, word == term ? 1.0 : means(word, term) ? 0.75 : 0.0);
        if (best == 0) return 0;
        score += best;
    }
    return score - 0.01 * double(words.size());
}

struct File {
    fs::path path;                   // in the folder
    std::string group;               // its first subfolder, or ""
    std::vector<std::string> words;  // of its name
    bool in = false, out = false;    // lies in a folder of that name
    bool raw = false;
    std::size_t bytes = 0;
    glm::ivec2 size{0};              // of a picture
};

struct Guess {
    std::string file, stage, slot, format;
};

struct Start {
    io::Manifest manifest;
    std::vector<Guess> guesses;
    std::vector<std::string> missing, unused;
};

// ---- What is there ------------------------------------------------------------------------------------------------

std::vector<File> find_files(const fs::path& folder) {
    const std::set<std::string> pictures = {"exr", "pfm", "hdr", "tif", "tiff", "dds", "png", "npy"};
    const std::set<std::string> raws = {"bin", "raw", "dat"};
    std::vector<File> files;
    std::error_code error;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
    for (; !error && at != end; at.increment(error)) {
        // Nor is anything dumped in expected/, where an export keeps the answer.
        if (at.depth() > 2 || at->path().filename() == "expected") at.disable_recursion_pending();
        const std::string extension = io::extension_of(at->path().string());
        std::error_code ignored;
        if (!at->is_regular_file(ignored) || (!pictures.count(extension) && !raws.count(extension))) continue;
        if (files.size() == most_files)
            throw InputError(io::shown(folder.string()), "", fmt::format("holds more than {} dumps", most_files));
        File file;
        file.path = at->path().lexically_relative(folder);
        file.words = words_of(file.path.stem().string());
        file.raw = raws.count(extension) > 0;
        file.bytes = std::size_t(at->file_size(ignored));
        std::vector<std::string> folders;
        for (const fs::path& part : file.path.parent_path()) folders.push_back(part.string());
        if (!folders.empty()) file.group = folders.front();
        for (const std::string& name : folders) {
            file.in |= name == "in" || name == "input" || name == "inputs";
            file.out |= name == "out" || name == "output" || name == "outputs";
        }
        files.push_back(std::move(file));
    }
    if (error) throw InputError(io::shown(folder.string()), "", "cannot be read: " + error.message());
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.path < b.path; });
    return files;
}

// ---- Raw files say nothing about themselves -----------------------------------------------------------------------

std::string raw_format(const Slot& slot, std::size_t bytes_a_texel) {
    const bool integers = slot.dtype != DType::f32;
    switch (bytes_a_texel) {
        case 16: return integers ? "R32G32B32A32_SINT" : "R32G32B32A32_SFLOAT";
        case 12: return integers ? "" : "R32G32B32_SFLOAT";
        case 8: return integers ? "R32G32_SINT" : slot.channels == 2 ? "R32G32_SFLOAT" : "R16G16B16A16_SFLOAT";
        case 4: return integers ? "R32_SINT" : slot.channels == 1 ? "R32_SFLOAT" : "R8G8B8A8_UNORM";
        case 2: return slot.channels == 1 && !integers ? "R16_SFLOAT" : "";
        default: return "";
    }
}

glm::ivec2 square(std::size_t texels) {
    const int side = int(std::lround(std::sqrt(double(texels))));
    return std::size_t(side) * std::size_t(side) == texels ? glm::ivec2(side) : glm::ivec2(0);
}

// Fills in what the manifest says about a raw file; false where nothing fits.
bool guess_raw(const Slot& slot, const File& file, glm::ivec2 frame, io::DumpSpec& spec) {
    if (slot.kind == SlotKind::buffer) {
        const std::size_t element = 4 * std::size_t(slot.channels);
        const char* names[] = {"", "R32", "R32G32", "R32G32B32", "R32G32B32A32"};
        spec.vk_format = std::string(names[slot.channels]) + (slot.dtype == DType::f32 ? "_SFLOAT" : "_SINT");
        spec.count = int(file.bytes / element);
        return file.bytes > 0 && file.bytes % element == 0;
    }
    if (slot.kind == SlotKind::image_array) {
        spec.vk_format = slot.channels == 1 ? "R32_SFLOAT" : "R32G32B32A32_SFLOAT";
        const std::size_t row = std::size_t(frame.x) * 4 * std::size_t(slot.channels);
        spec.width = frame.x;
        spec.height = row > 0 ? int(file.bytes / row) : 0;
        return row > 0 && file.bytes > 0 && file.bytes % row == 0;
    }
    // Maps are square, of a format of so many bytes.
    for (std::size_t texel : {16, 8, 4, 12, 2}) {
        const std::string format = raw_format(slot, texel);
        if (format.empty() || file.bytes % texel != 0) continue;
        const std::size_t texels = file.bytes / texel;
        const bool fits = slot.frame && frame.x > 0 && texels == std::size_t(frame.x) * std::size_t(frame.y);
        const glm::ivec2 size = fits ? frame : slot.frame ? glm::ivec2(0) : square(texels);
        if (size.x == 0) continue;
        spec.vk_format = format;
        spec.width = size.x;
        spec.height = size.y;
        return true;
    }
    return false;
}

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
const File* file_of(const Slot& slot, bool output, const std::vector<const File*>& files, const StageBinding& binding) {
    const File* best = nullptr;
    double most = 0;
    for (const File* file : files) {
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
const File* shared_file(const Slot& slot, const std::vector<File>& files, const StageBinding& binding,
                        const std::string& group) {
    std::vector<const File*> near, far;
    for (const File& file : files)
        if (file.in && named_after(file.group)) (light_of(file.group) == light_of(group) ? near : far).push_back(&file);
    if (slot.frame || slot.kind == SlotKind::buffer) near.insert(near.end(), far.begin(), far.end());
    return file_of(slot, false, near, binding);
}

std::vector<unsigned char> block_of(const fs::path& folder, const StageBinding& binding,
                                    const std::vector<const File*>& files, fs::path& path) {
    for (const File* file : files) {
        const bool named = likeness(file->words, "block") > 0 || likeness(file->words, "uniforms") > 0;
        if (!file->raw || !named || file->bytes != binding.uniform_bytes) continue;
        path = folder / file->path;
        return io::read_bytes(path.string());
    }
    return {};
}

// The size of the outputs: of the block, of a picture, or one that is known from another stage.
glm::ivec2 frame_size(const fs::path& folder, const StageBinding& binding, const std::vector<unsigned char>& block,
                      const std::vector<const File*>& files, const std::vector<glm::ivec2>& known) {
    StageData data;
    data.uniforms = block;
    std::map<std::string, double> sides;
    for (const UniformMember& m : binding.uniforms)
        if (!block.empty() && (m.name == "width" || m.name == "height"))
            sides[m.name] = uniform_value(binding, data, m.name).at(0);
    if (sides.size() == 2) return {int(sides["width"]), int(sides["height"])};
    for (const Slot& slot : binding.outputs) {
        const File* file = file_of(slot, true, files, binding);
        if (!file) continue;
        if (!file->raw) {
            io::DumpSpec spec;
            spec.file = folder / file->path;
            return image_size(io::read_dump(spec).array, spec.file.string());
        }
        const std::size_t texels = file->bytes / (4 * std::size_t(slot.channels));
        for (const glm::ivec2 size : known)
            if (std::size_t(size.x) * std::size_t(size.y) == texels) return size;
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

void add_stage(const fs::path& folder, const StageBinding& binding, const std::string& label,
               const std::vector<const File*>& files, const std::vector<File>& all, std::vector<glm::ivec2>& known,
               std::set<const File*>& used, Start& start) {
    io::ManifestStage stage;
    stage.stage = binding.info.name;
    stage.label = label;
    const std::vector<unsigned char> block = block_of(folder, binding, files, stage.uniforms_file);
    const glm::ivec2 frame = frame_size(folder, binding, block, files, known);
    if (frame.x > 0) known.push_back(frame);
    stage.width = frame.x;
    stage.height = frame.y;
    for (const File* file : files)
        if (!block.empty() && folder / file->path == stage.uniforms_file) used.insert(file);
    if (block.empty() && !binding.uniforms.empty()) start.missing.push_back(label + ": the uniforms, or a scene");
    for (const bool output : {false, true}) {
        for (const Slot& slot : output ? binding.outputs : binding.inputs) {
            const std::string name = (output ? "output." : "input.") + slot.name;
            const File* file = file_of(slot, output, files, binding);
            if (!file && !output) file = shared_file(slot, all, binding, label);
            io::DumpSpec spec;
            const bool formatted = file && (!file->raw || guess_raw(slot, *file, frame, spec));
            if (!formatted) {
                const std::string why = file ? ": what format does " + file->path.string() + " have?" : "";
                start.missing.push_back(fmt::format("{}: {}{}", label, name, why));
                continue;
            }
            spec.file = folder / file->path;
            used.insert(file);
            start.guesses.push_back({file->path.string(), label, name,
                                     spec.vk_format.empty() ? "" : fmt::format("{}{}", spec.vk_format,
                                         spec.count > 0 ? fmt::format(", {} elements", spec.count)
                                                        : fmt::format(", {} x {}", spec.width, spec.height))});
            (output ? stage.outputs : stage.inputs)[slot.name] = spec;
        }
    }
    if (binding.raster) guess_reversed_z(label, stage, start);
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

bool any_of_slots(const std::vector<Slot>& slots, bool output, const std::vector<const File*>& files,
                  const StageBinding& binding) {
    return std::any_of(slots.begin(), slots.end(),
                       [&](const Slot& slot) { return file_of(slot, output, files, binding) != nullptr; });
}

// Whether the file is rather an input of another stage, of which outputs lie there: nothing else of this one does.
bool read_by_another(const File& file, const StageBinding& binding, const std::vector<const File*>& files) {
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
bool written_by(const StageBinding& binding, const std::vector<const File*>& files) {
    if (binding.raster) return false;
    for (const Slot& slot : binding.outputs) {
        const File* file = file_of(slot, true, files, binding);
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
    const std::vector<File> files = find_files(folder);
    if (files.empty()) throw InputError(io::shown(folder.string()), "", "holds no dumps that a manifest could name");
    Start start;
    start.manifest.file = folder / "manifest.toml";
    std::map<std::string, std::vector<const File*>> groups;
    for (const File& file : files) groups[file.group].push_back(&file);

    // A folder named after a stage is one dispatch of it; stages that know their size come first.
    std::vector<glm::ivec2> known;
    std::set<const File*> used;
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
    for (const File& file : files)
        if (!used.count(&file)) start.unused.push_back(file.path.string());
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
    for (const std::string& unused : start.unused) text += "# not used: " + io::printable(unused, 400) + "\n";
    return text + "\n";
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
    if (start.manifest.stages.empty())
        throw InputError(io::shown(given), "",
                         "no dump here is named like an output of a stage (`plumb stages` lists them): irradiance, "
                         "visibility, radiance, display");
    io::write_text(path, comment(start) + io::manifest_text(start.manifest));

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
    for (const std::string& unused : start.unused) text += "  " + io::printable(unused, 400) + "\n";
    text += "\nwrote " + path + ": look through it, then run plumb validate " + path + "\n";
    std::fputs(text.c_str(), stdout);
    return success;
}

}  // namespace plumb::cli
