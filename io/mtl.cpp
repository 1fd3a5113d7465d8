#include "io/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.h"
#include "io/file.h"
#include "io/mtl_map.h"
#include "io/scene_model.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

constexpr float no_limit = std::numeric_limits<float>::max();

// The rest of a line that waits for others to say what it means.
struct Waiting {
    std::string_view text;
    std::int64_t line = 0;  // 0: was not there
};

// What the lines of one material say.
struct Described {
    Waiting kd, ke, ks, ns, illum, d, tr, pr, pm;
    MtlMap map_kd, map_ke, map_d, bump, norm;  // line 0: was not there
};

// Statements that would change the picture and have no part here. All others that the format has are silent.
constexpr std::string_view unread[] = {"map_Ks", "map_Ns", "refl", "disp", "decal", "Tf", "Ps", "Pc", "Pcr",
                                       "aniso", "anisor", "map_Pr", "map_Pm", "map_Ps", "map_refl"};
constexpr std::string_view silent[] = {"Ka", "Ni", "sharpness", "map_Ka", "map_aat", "Km", "bump_multiplier"};

class MtlReader {
  public:
    MtlReader(const std::string& path, const std::string& second_folder, ObjModel& model, Findings& findings)
        : path_(path), model_(model), findings_(findings), maps_(path, second_folder, model.textures, findings) {}

    std::vector<MtlMaterial> read(const std::string& text) {
        LineScanner lines(text);
        for (std::string_view line; lines.next(line);) {
            line_ = lines.number();
            const std::string_view key = next_word(line);
            if (!key.empty() && key[0] != '#') read(key, line);
        }
        finish_material();
        if (materials_.empty())
            findings_.add("empty library", path_, 0, "holds no material (newmtl)", "it is passed over");
        say_changes();
        return std::move(materials_);
    }

  private:
    [[noreturn]] void fail(std::int64_t line, const std::string& cause) const {
        throw InputError(shown(path_), fmt::format("line {}", line), cause);
    }
    void found(std::string_view kind, const std::string& cause, const std::string& instead) {
        findings_.add(kind, path_, line_, cause, instead);
    }

    void read(std::string_view key, std::string_view rest) {
        if (key == "newmtl") return begin_material(rest);
        const std::pair<std::string_view, Waiting*> values[] = {
            {"Kd", &now_.kd}, {"Ke", &now_.ke}, {"Ks", &now_.ks},       {"Ns", &now_.ns},
            {"d", &now_.d},   {"Tr", &now_.tr}, {"illum", &now_.illum}, {"Pr", &now_.pr}, {"Pm", &now_.pm},
        };
        const std::pair<std::string_view, MtlMap*> maps[] = {
            {"map_Kd", &now_.map_kd}, {"map_Ke", &now_.map_ke}, {"map_d", &now_.map_d}, {"map_opacity", &now_.map_d},
            {"bump", &now_.bump},     {"map_bump", &now_.bump}, {"map_Bump", &now_.bump}, {"norm", &now_.norm},
            {"map_Kn", &now_.norm},
        };
        for (const auto& [name, waiting] : values)
            if (key == name) {
                if (is_in_material(key)) *waiting = {rest, line_};
                return;
            }
        for (const auto& [name, map] : maps)
            if (key == name) {
                if (is_in_material(key)) *map = parse_map(path_, line_, key, rest);
                return;
            }
        if (std::find(std::begin(unread), std::end(unread), key) != std::end(unread)) return void(not_read_.insert(std::string(key)));
        if (std::find(std::begin(silent), std::end(silent), key) != std::end(silent) || findings_.counted("mtl statement")) return;
        found("mtl statement", "\"" + printable(key) + "\" is not a statement of MTL", "it is passed over");
    }

    bool is_in_material(std::string_view key) {
        if (has_material_) return true;
        found("no newmtl", std::string(key) + " before the first newmtl", "it is passed over");
        return false;
    }

    void begin_material(std::string_view rest) {
        finish_material();
        const std::string name(trimmed(rest));
        if (name.empty()) found("no name", "newmtl has no name", "no face can name it");
        if (!names_.insert(name).second)
            found("twice", "material \"" + printable(name) + "\" is there already", "the first of the name is taken");
        materials_.push_back({});
        materials_.back().material.name = name;
        has_material_ = true;
    }

    void finish_material() {
        if (!has_material_) return;
        MtlMaterial& m = materials_.back();
        if (now_.ke.line != 0) m.material.emission = colour("Ke", now_.ke, no_limit, m.material.emission);
        if (now_.kd.line != 0) m.material.reflectance = colour("Kd", now_.kd, 1, m.material.reflectance);
        read_pictures(m);
        read_gloss(m.material);
        read_opacity();
        now_ = {};
    }

    // One number for grey or three; at most `max`. A spectrum or a colour of CIE is none of these: `otherwise`.
    glm::vec3 colour(std::string_view key, const Waiting& given, float max, const glm::vec3& otherwise) {
        std::string_view rest = given.text.substr(0, given.text.find('#'));
        std::vector<float> values;
        for (std::string_view word = next_word(rest); !word.empty() && values.size() < 4; word = next_word(rest)) {
            if (values.empty() && (word == "spectral" || word == "xyz")) {
                findings_.add("spectrum", path_, given.line, fmt::format("{}: colours by \"{}\" are not read", key, word),
                              "it is passed over");
                return otherwise;
            }
            const auto value = parse_float(word);
            if (!value) fail(given.line, fmt::format("{}: \"{}\" is not a number", key, printable(word)));
            if (!(*value >= 0 && *value <= no_limit))
                fail(given.line, fmt::format("{} = {}: expected {}", key, *value,
                                             max == 1 ? "0 to 1" : "a finite number from 0 on"));
            if (*value > max)
                findings_.add("above 1", path_, given.line, fmt::format("{} = {}: expected 0 to 1", key, *value), "1 is taken");
            values.push_back(std::min(*value, max));
        }
        if (values.size() == 1) return glm::vec3(values[0]);
        if (values.size() != 3) fail(given.line, fmt::format("{} has {} numbers; expected three", key, values.size()));
        return {values[0], values[1], values[2]};
    }

    void read_pictures(MtlMaterial& m) {
        const bool cut_out = now_.map_d.line != 0;
        // All pictures of a material lie on its faces alike; the first that there is says how.
        const MtlMap* first = nullptr;
        for (const MtlMap* map : {&now_.map_kd, &now_.map_d, &now_.map_ke, &now_.norm, &now_.bump}) {
            if (map->line == 0) continue;
            if (!first) first = map;
            if (!map->unread.empty()) options_.insert(map->unread);
            if (!(map->mapping == first->mapping))
                findings_.add("mapping", path_, map->line, map->key + ": other -s or -o than " + first->key, "it lies as that does");
        }
        if (first) m.mapping = first->mapping;

        int texture = cut_out ? maps_.masked(now_.map_kd, now_.map_d) : -1;
        if (texture >= 0) m.material.alpha_cutoff = 0.5f;
        if (texture < 0 && now_.map_kd.line != 0) texture = maps_.colour(now_.map_kd);
        m.material.texture = texture;
        if (texture >= 0 && now_.kd.line == 0 && now_.map_kd.line != 0) m.material.reflectance = glm::vec3(1);
        if (now_.map_ke.line != 0) m.material.emission_texture = maps_.colour(now_.map_ke);
        if (m.material.emission_texture >= 0 && now_.ke.line == 0) m.material.emission = glm::vec3(1);
        const MtlMap& normals = now_.norm.line != 0 ? now_.norm : now_.bump;
        bool is_heights = false;
        if (normals.line != 0) m.material.normal_texture = maps_.normals(normals, is_heights);
        heights_ += is_heights;
        taken_for_normals_ += m.material.normal_texture >= 0 && now_.norm.line == 0;
    }

    // Roughness and metalness are those of glTF, 1 and 0 where only the other is given. Else Ks is used where illum asks for
    // it: files carry numbers there that nothing was meant to show.
    void read_gloss(Material& material) {
        if (now_.pr.line != 0 || now_.pm.line != 0) {
            material.microfacet = true;
            material.roughness = now_.pr.line != 0 ? share("Pr", now_.pr) : 1;
            material.metalness = now_.pm.line != 0 ? share("Pm", now_.pm) : 0;
            return;
        }
        const int model = now_.illum.line == 0 ? 0 : read_illum();
        if (model >= 2 && now_.ks.line != 0) reflect(material, model == 3);
    }

    float share(std::string_view key, const Waiting& given) const {
        std::string_view rest = given.text;
        const std::string_view word = next_word(rest);
        const auto value = parse_float(word);
        if (!value || !(*value >= 0 && *value <= 1))
            fail(given.line, fmt::format("{} = {}: expected 0 to 1", key, printable(word)));
        return *value;
    }

    int read_illum() const {
        std::string_view rest = now_.illum.text;
        const std::string_view word = next_word(rest);
        const auto model = parse_integer(word);
        if (!model || *model < 0 || *model > 10) fail(now_.illum.line, "illum = " + printable(word) + ": expected 0 to 10");
        return int(*model);
    }

    // Gives the material its Ks, as much of it as Kd leaves, in one factor: the colour stays.
    void reflect(Material& material, bool as_mirror) {
        const glm::vec3 wanted = colour("Ks", now_.ks, no_limit, glm::vec3(0));
        double factor = 1;
        for (int c = 0; c < 3; ++c) {
            const double room = 1 - double(material.reflectance[c]);
            if (double(wanted[c]) > room + 1e-6) factor = std::min(factor, room / double(wanted[c]));
        }
        scaled_ += factor < 1;
        glm::vec3& share = as_mirror ? material.mirror : material.specular;
        for (int c = 0; c < 3; ++c) share[c] = std::min(float(double(wanted[c]) * factor), 1 - material.reflectance[c]);
        if (!as_mirror && now_.ns.line != 0) material.exponent = read_exponent();
    }

    float read_exponent() {
        std::string_view rest = now_.ns.text;
        const std::string_view word = next_word(rest);
        const auto n = parse_float(word);
        if (!n || std::isnan(*n)) fail(now_.ns.line, "Ns: \"" + printable(word) + "\" is not a number");
        clamped_ += *n < 0 || *n > float(max_exponent);
        return std::clamp(*n, 0.0f, float(max_exponent));
    }

    // "d -halo 0.5" is less opaque where it is seen from the front.
    void read_opacity() {
        std::string_view d = now_.d.text, tr = now_.tr.text;
        std::string_view word = next_word(d);
        if (word == "-halo") word = next_word(d);
        const auto opaque = parse_float(word), clear = parse_float(next_word(tr));
        transparent_ += (opaque && *opaque < 1) || (!opaque && clear && *clear > 0);
    }

    void say(int count, const std::string& what) {
        if (count > 0) model_.notes.push_back(fmt::format("{}: {} in {} of {} materials", shown(path_), what, count, materials_.size()));
    }
    static std::string listed(const std::set<std::string>& names) {
        std::string text;
        for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
        return text;
    }
    void say_changes() {
        if (scaled_ > 0)
            model_.notes.push_back(fmt::format("{}: Kd + Ks is above 1 in {} of {} materials: their Ks is scaled down",
                                               shown(path_), scaled_, materials_.size()));
        if (clamped_ > 0)
            model_.notes.push_back(fmt::format("{}: Ns is not in 0 to 1e6 in {} of {} materials: the nearest is taken",
                                               shown(path_), clamped_, materials_.size()));
        say(transparent_, "what is transparent (d, Tr) is drawn opaque");
        say(heights_, "heights (bump) are not read");
        say(taken_for_normals_, "bump holds the colours of normals and is taken for a map of them");
        if (!not_read_.empty()) model_.notes.push_back(fmt::format("{}: not read: {}", shown(path_), listed(not_read_)));
        if (!options_.empty())
            model_.notes.push_back(fmt::format("{}: options of pictures that are not read: {}", shown(path_), listed(options_)));
    }

    const std::string& path_;
    ObjModel& model_;
    Findings& findings_;
    MtlMaps maps_;
    std::vector<MtlMaterial> materials_;
    std::set<std::string> names_;
    bool has_material_ = false;
    Described now_;  // the material that is being read
    std::int64_t line_ = 0;
    int scaled_ = 0, clamped_ = 0, transparent_ = 0, heights_ = 0, taken_for_normals_ = 0;  // materials
    std::set<std::string> not_read_, options_;
};

}  // namespace

std::vector<MtlMaterial> parse_mtl(const std::string& path, const std::string& text, const std::string& second_folder,
                                   ObjModel& model, Findings& findings) {
    return MtlReader(path, second_folder, model, findings).read(text);
}

}  // namespace plumb::io
