#include "io/ipr_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

// A command that has numbers alone, and the key that it becomes.
struct Numeric {
    std::size_t numbers;
    const char *table, *key;
};
const std::map<std::string, Numeric>& numeric_commands() {
    static const std::map<std::string, Numeric> commands = {
        {"DOBJ_SCALE", {1, "object", "scale"}},
        {"DOBJ_INIT_TRANSLATE", {3, "object", "translate"}},
        {"DOBJ_INIT_ROTATE", {4, "object", "turn_deg"}},
        {"DOBJ_ANIM_TRANSLATE", {3, "motion", "translate"}},
        {"DOBJ_ANIM_ROTATE", {4, "motion", "turn_deg"}},
        {"DOBJ_BEZIER_SPEED", {1, "motion", "speed"}},
        {"BACKGROUND_COLOR", {3, "environment", "radiance"}},
        {"SCREEN_RESOLUTION", {2, "frame", "size"}},
        {"LIGHT_INIT_TRANSLATE", {3, "light", "position"}},
        {"LIGHT_INIT_YAW", {1, "light", "yaw_deg"}},
        {"LIGHT_INIT_PITCH", {1, "light", "pitch_deg"}},
        {"LIGHT_INIT_COLOR", {3, "light", "intensity"}},
        {"CAMERA_INIT_TRANSLATE", {3, "camera", "position"}},
        {"CAMERA_INIT_YAW", {1, "camera", "yaw_deg"}},
        {"CAMERA_INIT_PITCH", {1, "camera", "pitch_deg"}},
        {"CAMERA_FOV", {1, "camera", "fov_y_deg"}},
        {"TONE_MAPPING_GAMMA", {1, "tonemap", "gamma"}},
        {"TONE_MAPPING_EXPOSURE", {1, "tonemap", "exposure"}},
        {"TONE_MAPPING_CONTRAST", {1, "tonemap", "contrast"}},
        {"TONE_MAPPING_DIMMER", {1, "tonemap", "dimmer"}},
    };
    return commands;
}
const std::vector<std::string> other_commands = {"SSF", "DOBJ", "DOBJ_GRID_INSERT", "DOBJ_BEZIER", "MAT_EMIS", "LIGHT_MODE",
                                                 "TONE_MAPPING", "SCREENSHOT_FOLDER", "LOD_DISTANCE", "LOD_SH_DEGREE"};

// Basic strings of TOML hold anything but quotes, backslashes and control characters as they are.
std::string toml_string(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (static_cast<unsigned char>(c) < 32 || c == 127)
            out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
        else
            out += c;
    }
    return out + '"';
}

std::string list(const std::vector<float>& numbers) {
    if (numbers.size() == 1) return fmt::format("{}", numbers[0]);
    return fmt::format("[{}]", fmt::join(numbers, ", "));
}

class Converter {
  public:
    Converter(const std::string& path, const std::string& static_scene) : path_(path), static_scene_(static_scene) {}

    std::string convert(const std::string& text) {
        LineScanner lines(text);
        for (std::string_view line; lines.next(line);) {
            line_ = lines.number();
            line = trimmed(line.substr(0, line.find('#')));
            if (line.empty()) continue;
            if (line.front() != '!') fail("expected a command, which begins with '!', or a comment, which begins with '#'");
            line.remove_prefix(1);
            command_ = std::string(next_word(line));
            read(trimmed(line));
        }
        return write();
    }

  private:
    using Keys = std::vector<std::pair<std::string, std::string>>;  // in the order of the file
    struct Object {
        Keys mesh, motion;
    };

    void read(std::string_view rest) {
        const auto numeric = numeric_commands().find(command_);
        if (numeric != numeric_commands().end()) {
            const auto& [count, table, key] = numeric->second;
            set(keys_of(table), key, list(numbers(rest, count)));
        } else if (command_ == "SSF") {
            set(tables_["static"], "file", toml_string(word(rest)));
        } else if (command_ == "DOBJ") {
            objects_.push_back({{{"file", toml_string(word(rest))}, {"dynamic", "true"}}, {}});
        } else if (command_ == "DOBJ_GRID_INSERT") {
            Keys& keys = keys_of("object");
            keys[1].second = choice(rest, {{"0", "false"}, {"1", "true"}});
        } else if (command_ == "DOBJ_BEZIER") {
            set(keys_of("motion"), "bezier", points(rest));
        } else if (command_ == "MAT_EMIS") {
            const std::vector<float> n = numbers(rest, 2);
            if (!(n[0] >= 0) || n[0] != std::floor(n[0]) || n[0] > 1e6f) fail("expected the number of a material, from 0");
            emissions_.emplace_back(fmt::format("{:.0f}", n[0]), list({n[1]}));
        } else if (command_ == "LIGHT_MODE") {
            set(tables_["light"], "type", choice(rest, {{"AREA", "\"directional\""}, {"FLASH", "\"spot\""}, {"POINT", "\"point\""}}));
        } else if (command_ == "TONE_MAPPING") {
            set(tables_["tonemap"], "operator", choice(rest, {{"E", "\"exposure\""}, {"F", "\"filmic\""}, {"R", "\"reinhard\""}}));
        } else if (command_ == "SCREENSHOT_FOLDER") {
            set(tables_["comment"], "plumb render -o", std::string(word(rest)));
        } else if (command_ == "LOD_DISTANCE") {
            const std::vector<float> n = numbers(rest, 4);
            if (n[0] != 0) fail("expected 0 for level 0");
            set(tables_["lod"], "levels", "4");
            for (int k = 1; k < 4; ++k) set(tables_["lod"], fmt::format("distance_{}", k), list({n[std::size_t(k)]}));
        } else if (command_ == "LOD_SH_DEGREE") {
            const std::vector<float> n = numbers(rest, 4);
            for (int k = 0; k < 4; ++k) set(tables_["lod"], fmt::format("degree_{}", k), list({n[std::size_t(k)]}));
        } else {
            std::vector<std::string> names = other_commands;
            for (const auto& [name, command] : numeric_commands()) names.push_back(name);
            for (std::string& name : names) name.insert(0, "!");
            fail("unknown command" + nearest_known("!" + command_, names));
        }
    }

    Keys& keys_of(const std::string& table) {
        if (table != "object" && table != "motion") return tables_[table];
        if (objects_.empty()) fail("stands before any !DOBJ");
        return table == "object" ? objects_.back().mesh : objects_.back().motion;
    }
    void set(Keys& keys, const std::string& key, const std::string& value) {
        for (const auto& [name, other] : keys)
            if (name == key) fail("is given twice");
        keys.emplace_back(key, value);
    }

    std::string_view word(std::string_view rest) {
        if (rest.empty()) fail("expected a name");
        return rest;
    }
    std::string choice(std::string_view rest, const std::vector<std::pair<std::string, std::string>>& choices) {
        std::vector<std::string> names;
        for (const auto& [name, value] : choices) {
            if (name == rest) return value;
            names.push_back(name);
        }
        fail(fmt::format("expected {}", fmt::join(names, ", ")));
    }
    std::vector<float> numbers(std::string_view rest, std::size_t count) {
        std::vector<float> result;
        for (std::string_view w = next_word(rest); !w.empty(); w = next_word(rest)) {
            const auto n = parse_float(w);
            if (!n || !std::isfinite(*n)) fail(fmt::format("{}: expected a finite number", printable(std::string(w))));
            result.push_back(*n);
        }
        if (result.size() != count) fail(fmt::format("expected {} number{}, not {}", count, count == 1 ? "" : "s", result.size()));
        return result;
    }
    // "x y z; x y z;": the last semicolon may be missing.
    std::string points(std::string_view rest) {
        std::vector<std::string> result;
        while (!rest.empty()) {
            const std::size_t end = std::min(rest.find(';'), rest.size());
            result.push_back(list(numbers(rest.substr(0, end), 3)));
            rest = end < rest.size() ? trimmed(rest.substr(end + 1)) : std::string_view();
        }
        return fmt::format("[{}]", fmt::join(result, ", "));
    }

    static std::string written(const std::string& heading, const Keys& keys) {
        std::string out = "\n" + heading + "\n";
        for (const auto& [key, value] : keys) out += fmt::format("{} = {}\n", key, value);
        return out;
    }

    std::string write() {
        if (tables_["static"].empty()) throw InputError(shown(path_), "", "no !SSF, which is required");
        std::string out = fmt::format("# From {} (IPR figure A.1)\n", printable(path_));
        for (const auto& [name, folder] : tables_["comment"]) out += fmt::format("# {} {}\n", name, printable(folder));
        for (const char* table : {"frame", "camera"})
            if (!tables_[table].empty()) out += written(fmt::format("[{}]", table), tables_[table]);
        out += fmt::format("\n[[mesh]]  # {}\nfile = {}\n", tables_["static"][0].second, toml_string(static_scene_));
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            objects_[i].mesh.insert(objects_[i].mesh.begin(), {"name", fmt::format("\"object{}\"", i)});
            out += written("[[mesh]]", objects_[i].mesh);
        }
        for (const auto& [index, emission] : emissions_) out += fmt::format("\n[[material]]\nindex = {}\nemission = {}\n", index, emission);
        if (!tables_["light"].empty()) out += written("[[light]]", tables_["light"]);
        for (const char* table : {"environment", "tonemap", "lod"})
            if (!tables_[table].empty()) out += written(fmt::format("[{}]", table), tables_[table]);
        for (std::size_t i = 0; i < objects_.size(); ++i)
            if (!objects_[i].motion.empty()) {
                objects_[i].motion.insert(objects_[i].motion.begin(), {"mesh", fmt::format("\"object{}\"", i)});
                out += written("[[motion]]", objects_[i].motion);
            }
        return out;
    }

    [[noreturn]] void fail(const std::string& cause) const {
        throw InputError(shown(path_), fmt::format("line {}", line_),
                         command_.empty() ? cause : fmt::format("!{}: {}", printable(command_), cause));
    }

    const std::string &path_, &static_scene_;
    std::int64_t line_ = 0;
    std::string command_;
    std::map<std::string, Keys> tables_;
    std::vector<Object> objects_;
    Keys emissions_;
};

}  // namespace

std::string ipr_scene_toml(const std::string& path, const std::string& text, const std::string& static_scene) {
    return Converter(path, static_scene).convert(text);
}

}  // namespace plumb::io
