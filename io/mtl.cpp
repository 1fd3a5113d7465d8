#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/obj.h"
#include "io/scene_model.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

// The rest of a line that waits for others to say what it means.
struct Waiting {
    std::string_view text;
    std::int64_t line = 0;  // 0: was not there
};

struct MtlReader {
    const std::string& path;
    std::vector<Texture>& textures;
    std::vector<std::string>& notes;
    std::vector<Material> materials{};
    std::map<std::string, int> texture_of_file{};
    std::set<std::string> names{};
    std::int64_t line = 0;
    bool has_kd = false;
    Waiting ks{}, ns{}, illum{};  // of the material that is being read
    int scaled = 0, clamped = 0;  // materials

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

    // Ks is used where illum asks for it: files carry numbers there that nothing was meant to show.
    void finish_material() {
        const std::int64_t here = line;
        line = illum.line;
        const int model = illum.line == 0 ? 0 : read_illum();
        line = ks.line;
        if (model >= 2 && ks.line != 0) reflect(materials.back(), model == 3);
        ks = ns = illum = {};
        line = here;
    }

    int read_illum() const {
        std::string_view rest = illum.text;
        const std::string_view word = next_word(rest);
        const auto model = parse_integer(word);
        if (!model || *model < 0 || *model > 10) fail("illum = " + printable(word) + ": expected 0 to 10");
        return int(*model);
    }

    // Gives the material its Ks, as much of it as Kd leaves, in one factor: the colour stays.
    void reflect(Material& material, bool as_mirror) {
        const glm::vec3 wanted = colour("Ks", ks.text, std::numeric_limits<float>::max());
        double factor = 1;
        for (int c = 0; c < 3; ++c) {
            const double room = 1 - double(material.reflectance[c]);
            if (double(wanted[c]) > room + 1e-6) factor = std::min(factor, room / double(wanted[c]));
        }
        scaled += factor < 1;
        glm::vec3& share = as_mirror ? material.mirror : material.specular;
        for (int c = 0; c < 3; ++c)
            share[c] = std::min(float(double(wanted[c]) * factor), 1 - material.reflectance[c]);
        if (!as_mirror && ns.line != 0) material.exponent = read_exponent();
    }

    float read_exponent() {
        line = ns.line;
        std::string_view rest = ns.text;
        const std::string_view word = next_word(rest);
        const auto n = parse_float(word);
        if (!n || std::isnan(*n)) fail("Ns: \"" + printable(word) + "\" is not a number");
        clamped += *n < 0 || *n > float(max_exponent);
        return std::clamp(*n, 0.0f, float(max_exponent));
    }

    void say_changes() const {
        if (scaled > 0)
            notes.push_back(fmt::format("{}: Kd + Ks is above 1 in {} of {} materials: their Ks is scaled down",
                                        shown(path), scaled, materials.size()));
        if (clamped > 0)
            notes.push_back(fmt::format("{}: Ns is not in 0 to 1e6 in {} of {} materials: the nearest is taken",
                                        shown(path), clamped, materials.size()));
    }

    void begin_material(std::string_view rest) {
        if (!materials.empty()) finish_material();
        const std::string name(trimmed(rest));
        if (name.empty()) fail("newmtl has no name");
        if (!names.insert(name).second) fail("material \"" + printable(name) + "\" is there already");
        materials.push_back({});
        materials.back().name = name;
        has_kd = false;
    }

    void read(std::string_view key, std::string_view rest) {
        if (key == "newmtl") return begin_material(rest);
        // Opacity and the like have no meaning here.
        Waiting* const waiting = key == "Ks" ? &ks : key == "Ns" ? &ns : key == "illum" ? &illum : nullptr;
        if (key != "Kd" && key != "Ke" && key != "map_Kd" && !waiting) return;
        if (materials.empty()) fail(std::string(key) + " before the first newmtl");
        Material& material = materials.back();
        if (waiting) {
            *waiting = {rest, line};
        } else if (key == "Kd") {
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

std::vector<Material> parse_mtl(const std::string& path, const std::string& text, std::vector<Texture>& textures,
                                std::vector<std::string>& notes) {
    MtlReader reader{path, textures, notes};
    LineScanner lines(text);
    for (std::string_view line; lines.next(line);) {
        reader.line = lines.number();
        const std::string_view key = next_word(line);
        if (!key.empty() && key[0] != '#') reader.read(key, line);
    }
    if (reader.materials.empty()) throw InputError(shown(path), "", "holds no material (newmtl)");
    reader.finish_material();
    reader.say_changes();
    return std::move(reader.materials);
}

}  // namespace plumb::io
