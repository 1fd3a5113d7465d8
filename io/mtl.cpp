#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/obj.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

struct MtlReader {
    const std::string& path;
    std::vector<Texture>& textures;
    std::vector<Material> materials{};
    std::map<std::string, int> texture_of_file{};
    std::set<std::string> names{};
    std::int64_t line = 0;
    bool has_kd = false;

    [[noreturn]] void fail(const std::string& cause) const {
        throw InputError(shown(path), fmt::format("line {}", line), cause);
    }

    // One number for grey or three.
    glm::vec3 colour(std::string_view key, std::string_view rest, float max) const {
        rest = rest.substr(0, rest.find('#'));
        std::vector<float> values;
        for (std::string_view word = next_word(rest); !word.empty() && values.size() < 4; word = next_word(rest)) {
            const auto value = parse_float(word);
            if (!value) fail(fmt::format("{}: \"{}\" is not a number", key, printable(word)));
            if (!(*value >= 0 && *value <= max))
                fail(fmt::format("{} = {}: expected {}", key, *value,
                                 max == 1 ? "0 to 1" : "a finite number from 0 on"));
            values.push_back(*value);
        }
        if (values.size() == 1) return glm::vec3(values[0]);
        if (values.size() != 3) fail(fmt::format("{} has {} numbers; expected three", key, values.size()));
        return {values[0], values[1], values[2]};
    }

    int texture(std::string_view rest) {
        const std::string name(trimmed(rest));
        if (name.empty()) fail("map_Kd names no file");
        if (name[0] == '-') fail("map_Kd: options such as " + printable(name) + " are not read");
        const auto known = texture_of_file.find(name);
        if (known != texture_of_file.end()) return known->second;
        try {
            textures.push_back(read_texture(beside(path, name)));
        } catch (const InputError& e) {
            fail(std::string("map_Kd: ") + e.what());
        }
        return texture_of_file[name] = int(textures.size()) - 1;
    }

    void begin_material(std::string_view rest) {
        const std::string name(trimmed(rest));
        if (name.empty()) fail("newmtl has no name");
        if (!names.insert(name).second) fail("material \"" + printable(name) + "\" is there already");
        materials.push_back({});
        materials.back().name = name;
        has_kd = false;
    }

    void read(std::string_view key, std::string_view rest) {
        if (key == "newmtl") return begin_material(rest);
        // Shininess, opacity and the like have no meaning for a diffuse surface.
        if (key != "Kd" && key != "Ke" && key != "map_Kd") return;
        if (materials.empty()) fail(std::string(key) + " before the first newmtl");
        Material& material = materials.back();
        if (key == "Kd") {
            material.reflectance = colour(key, rest, 1);
            has_kd = true;
        } else if (key == "Ke") {
            material.emission = colour(key, rest, std::numeric_limits<float>::max());
        } else {
            material.texture = texture(rest);
            if (!has_kd) material.reflectance = glm::vec3(1);
        }
    }
};

}  // namespace

std::vector<Material> parse_mtl(const std::string& path, const std::string& text, std::vector<Texture>& textures) {
    MtlReader reader{path, textures};
    LineScanner lines(text);
    for (std::string_view line; lines.next(line);) {
        reader.line = lines.number();
        const std::string_view key = next_word(line);
        if (!key.empty() && key[0] != '#') reader.read(key, line);
    }
    if (reader.materials.empty()) throw InputError(shown(path), "", "holds no material (newmtl)");
    return std::move(reader.materials);
}

}  // namespace plumb::io
