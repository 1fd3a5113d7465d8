#include "tools/mutants/mutant.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "io/document.h"

namespace plumb::mutants {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kind_names{"wrong", "legal", "scale"};

std::string text_of(const fs::path& file, const std::string& place) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(fmt::format("{}: cannot read {}", place, file.string()));
    std::ostringstream text;
    text << in.rdbuf();
    return std::move(text).str();
}

std::string required(io::DocumentReader& reader, const std::string& key) {
    if (!reader.has(key)) throw InputError(reader.place() + ": a mutant needs " + key);
    return reader.filled(key, "");
}

Mutant read_mutant(const io::DocumentValue& table, const std::string& path) {
    io::DocumentReader reader(table, path, "mutant");
    Mutant m;
    m.name = required(reader, "name");
    reader.rename(m.name);
    m.stage = required(reader, "stage");
    const std::string kind = required(reader, "kind");
    const auto known = std::find(kind_names.begin(), kind_names.end(), kind);
    if (known == kind_names.end()) reader.fail("kind", "must be wrong, legal or scale");
    m.kind = Kind(known - kind_names.begin());
    m.file = required(reader, "file");
    m.find = required(reader, "find");
    m.replace = reader.word("replace", "");
    m.all = reader.flag("all", false);
    m.place = reader.place();
    reader.finish();
    return m;
}

// The twin's text with the helpers that an edit may call: after the line that allows to include them.
std::string with_prelude(const std::string& text) {
    const std::string include = "#include \"tools/mutants/prelude.glsl\"\n";
    const std::size_t extension = text.rfind("#extension");
    if (extension == std::string::npos) return include + text;
    return std::string(text).insert(text.find('\n', extension) + 1, include);
}

std::string quoted(const std::string& word) {
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

fs::path write_into(const fs::path& overlay, const std::string& name, const std::string& text) {
    const fs::path file = overlay / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
}

std::string main_file(const StageBinding& binding) { return binding.raster ? binding.twin + ".frag" : binding.twin; }

}  // namespace

const char* kind_name(Kind kind) { return kind_names[std::size_t(kind)].c_str(); }

std::vector<Mutant> read_mutants(const fs::path& folder) {
    if (!fs::is_directory(folder)) throw InputError(folder.string() + ": is no folder");
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::sort(files.begin(), files.end());

    std::vector<Mutant> mutants;
    for (const fs::path& file : files) {
        const std::string path = file.filename().string();
        const io::DocumentValue document = io::parse_document(path, text_of(file, path));
        io::DocumentReader reader(document, path, "");
        for (const io::DocumentValue* table : reader.tables("mutant")) mutants.push_back(read_mutant(*table, path));
        reader.finish();
    }
    for (std::size_t i = 0; i < mutants.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (mutants[i].name == mutants[j].name)
                throw InputError(fmt::format("{}: {} is also at {}", mutants[i].place, mutants[i].name,
                                             mutants[j].place));
    return mutants;
}

std::string edited(const Mutant& mutant, const std::string& text, double scale) {
    std::string replace = mutant.replace;
    for (std::size_t at; (at = replace.find("{s}")) != std::string::npos;)
        replace.replace(at, 3, fmt::format("{:.12g}", scale) + (scale == 1 ? ".0" : ""));

    std::string out;
    std::size_t from = 0;
    int count = 0;
    for (std::size_t at; (at = text.find(mutant.find, from)) != std::string::npos; ++count) {
        out += text.substr(from, at - from) + replace;
        from = at + mutant.find.size();
    }
    if (count == 0 || (count > 1 && !mutant.all))
        throw InputError(fmt::format("{}: {}: its text is {} times in {}: expected {}", mutant.place, mutant.name, count,
                                     mutant.file, mutant.all ? "at least one" : "one"));
    return out + text.substr(from);
}

TwinCompiler::TwinCompiler(std::string glslang, fs::path source) : glslang_(std::move(glslang)), source_(source) {
    directory_ = fs::temp_directory_path() / fmt::format("plumb_mutants_{}", getpid());
    fs::remove_all(directory_);
    fs::create_directories(directory_);
}

TwinCompiler::~TwinCompiler() {
    std::error_code ignored;
    fs::remove_all(directory_, ignored);
}

fs::path TwinCompiler::new_overlay() const {
    const fs::path overlay = directory_ / std::to_string(overlays_++);
    fs::create_directories(overlay);
    return overlay;
}

std::vector<std::uint32_t> TwinCompiler::compile(const StageBinding& binding) const {
    return compile_file(new_overlay(), source_ / main_file(binding), binding.info.name);
}

// The mutated file lies in an overlay of its own, which is searched before the source.
std::vector<std::uint32_t> TwinCompiler::compile(const StageBinding& binding, const Mutant& mutant, double scale) const {
    const std::string text = with_prelude(edited(mutant, text_of(source_ / mutant.file, mutant.place), scale));
    const fs::path overlay = new_overlay(), file = write_into(overlay, mutant.file, text);
    const bool is_main = mutant.file == main_file(binding);
    return compile_file(overlay, is_main ? file : source_ / main_file(binding), mutant.place + ": " + mutant.name);
}

std::vector<std::uint32_t> TwinCompiler::compile_text(const std::string& file, const std::string& text,
                                                      const std::string& name) const {
    const fs::path overlay = new_overlay();
    return compile_file(overlay, write_into(overlay, file, text), name);
}

std::vector<std::uint32_t> TwinCompiler::compile_with_lines(const std::string& file) const {
    return compile_file(new_overlay(), source_ / file, file, "-g");
}

std::vector<std::uint32_t> TwinCompiler::compile_file(const fs::path& overlay, const fs::path& file,
                                                      const std::string& name, const std::string& more) const {
    const fs::path spirv = overlay / "out.spv", log = overlay / "log";
    const std::string command =
        fmt::format("{} -V --quiet --target-env vulkan1.1 {} {} {} -o {} {} > {} 2>&1", quoted(glslang_), more,
                    quoted("-I" + overlay.string()), quoted("-I" + source_.string()), quoted(spirv.string()),
                    quoted(file.string()), quoted(log.string()));
    if (std::system(command.c_str()) != 0 || !fs::exists(spirv))
        throw InputError(fmt::format("{}: does not compile: {}", name, text_of(log, name)));
    const std::string bytes = text_of(spirv, name);
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), words.size() * 4);
    return words;
}

}  // namespace plumb::mutants
