// Exported stages for tests to change: raw files, and the manifest as text.
#pragma once

#include <cstring>
#include <filesystem>

#include "tests/program/program.h"

namespace plumb::program {

// A renderer that gets everything right: expected/ over out/, in every stage of an export.
inline void write_expected(const std::string& folder) {
    namespace fs = std::filesystem;
    for (const std::string& name : files_in(folder)) {
        const std::size_t at = name.find("expected/");
        if (at == std::string::npos) continue;
        const std::string out = folder + "/" + name.substr(0, at) + "out/" + name.substr(at + 9);
        fs::create_directories(fs::path(out).parent_path());
        fs::copy_file(folder + "/" + name, out, fs::copy_options::overwrite_existing);
    }
}

// What `plumb export --stage all` writes of the small Cornell box, into a fresh folder, and a right answer to it.
inline std::string export_all(const std::string& name, const Words& more = {}) {
    const std::string folder = fresh_folder(name);
    Words words = {"export", small_scene(folder), "--stage", "all", "-o", folder + "/dumps"};
    words.insert(words.end(), more.begin(), more.end());
    const Result r = run(words);
    if (r.exit != 0) throw std::runtime_error(r.err);
    write_expected(folder + "/dumps");
    return folder + "/dumps";
}

// One 32-bit word of a raw file.
template <class T>
T word(const std::string& bytes, std::size_t index) {
    T value;
    std::memcpy(&value, bytes.data() + index * sizeof value, sizeof value);
    return value;
}
template <class T>
void set_word(const std::string& path, std::size_t index, T value) {
    std::string bytes = read(path);
    std::memcpy(bytes.data() + index * sizeof value, &value, sizeof value);
    write(path, bytes);
}

// The text with the first `from` replaced, which is there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error("no " + from + " in\n" + text);
    return text.replace(at, from.size(), to);
}

// Of a manifest: its head and the one stage of that label.
inline std::string only_stage(const std::string& manifest, const std::string& label) {
    const std::string mark = "[[stage]]\n";
    const std::size_t line = manifest.find("label = \"" + label + "\"");
    if (line == std::string::npos) throw std::runtime_error("no stage " + label);
    const std::size_t first = manifest.rfind(mark, line);
    return manifest.substr(0, manifest.find(mark)) + manifest.substr(first, manifest.find(mark, line) - first);
}

// The stage of that label in what `plumb validate --json` printed.
inline Json stage_of(const Json& report, const std::string& label) {
    for (const Json& stage : report["stages"])
        if (stage["name"] == label) return stage;
    throw std::runtime_error("no stage " + label);
}

}  // namespace plumb::program
