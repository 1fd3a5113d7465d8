#include "tools/shared/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/error.h"
#include "core/nearest_known.h"
#include "gi/frame/presets.h"
#include "io/file.h"
#include "io/sample_rows.h"
#include "tools/shared/light_sets.h"

namespace plumb::cli {

namespace {

template <class Number>
bool read_number(const std::string& text, Number& number) {
    const char* first = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(first, last, number);
    return error == std::errc() && end == last && !text.empty();
}

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

bool read_vector(std::string text, glm::vec3& v) {
    if (text.size() >= 2 && text.front() == '[' && text.back() == ']') text = text.substr(1, text.size() - 2);
    for (int i = 0; i < 3; ++i) {
        const std::size_t comma = text.find(',');
        double x = 0;
        if ((comma == std::string::npos) != (i == 2) || !read_number(trimmed(text.substr(0, comma)), x)) return false;
        v[i] = float(x);
        text = i < 2 ? text.substr(comma + 1) : "";
    }
    return true;
}

// --truth and the options that stand for a key of [reference].
void set_truth(const SceneOptions& options, frame::Settings& settings) {
    const bool reference = settings.method == frame::Method::reference;
    if (options.truth && reference)
        throw InputError("--truth: the method reference is the truth: expected the method direct or rsm");
    settings.truth = options.truth;
    const struct {
        const char *option, *key;
        const std::string& text;
    } shorthands[] = {{"--spp", "samples", options.samples},
                      {"--until-error", "until_error", options.until_error},
                      {"--rays", "rays", options.rays}};
    for (const auto& [option, key, text] : shorthands) {
        if (text.empty()) continue;
        if (!options.truth && !reference)
            throw InputError(fmt::format("{}: nothing is path traced: expected --truth or --method reference", option));
        const std::string place = fmt::format("{} {}", option, text);
        std::vector<Field> fields = reference::fields(settings.reference);
        set_field(find_field(fields, key, place), parse_value(text), option);
    }
    if (!options.samples.empty() && !options.until_error.empty())
        throw InputError("--until-error: --spp is given, too: expected one of them");
    // A number of samples on the command line is meant, whatever the scene file says.
    if (!options.samples.empty()) settings.reference.until_error = 0;
    if (!options.until_error.empty() && settings.reference.until_error == 0)
        throw InputError(fmt::format("--until-error {}: expected above 0", options.until_error));
    const reference::Mode mode = settings.reference.mode;
    if (options.truth && mode != reference::Mode::all && mode != reference::Mode::direct)
        throw InputError("--truth: reference.mode: expected \"all\" or \"direct\", which hold what color holds");
}

}  // namespace

FieldValue parse_value(const std::string& raw) {
    const std::string text = trimmed(raw);
    if (text == "true" || text == "false") return text == "true";
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') return text.substr(1, text.size() - 2);
    double number = 0;
    if (read_number(text, number)) return number;
    glm::vec3 v;
    if (read_vector(text, v)) return v;
    return text;
}

Assignment parse_assignment(const std::string& text) {
    const std::size_t equals = text.find('=');
    const std::size_t dot = text.substr(0, equals).find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 == equals)
        throw InputError(fmt::format("--set {}: expected table.key=value, as in --set rsm.samples=150", text));
    Assignment a;
    a.table = text.substr(0, dot);
    a.key = text.substr(dot + 1, equals - dot - 1);
    a.value = parse_value(text.substr(equals + 1));
    a.place = "--set " + text.substr(0, equals);
    return a;
}

glm::ivec2 parse_pixel(const std::string& text) {
    const std::size_t comma = text.find(',');
    glm::ivec2 pixel;
    if (comma == std::string::npos || !read_number(trimmed(text.substr(0, comma)), pixel.x) ||
        !read_number(trimmed(text.substr(comma + 1)), pixel.y) || pixel.x < 0 || pixel.y < 0)
        throw InputError(
            fmt::format("--pixel {}: expected X,Y in pixels from the top left, as in --pixel 120,80", text));
    return pixel;
}

glm::ivec2 parse_size(const std::string& option, const std::string& text, int least) {
    constexpr int most = 32767;
    const std::size_t x = text.find('x');
    const auto side = [&](const std::string& digits) {
        int n = 0;
        if (!read_number(digits, n) || digits[0] == '+' || n < least || n > most)
            throw InputError(fmt::format("{} {}: expected WxH in pixels, both {} to {}", option, io::printable(text),
                                         least, most));
        return n;
    };
    const glm::ivec2 size(side(text.substr(0, x)), side(x == std::string::npos ? "" : text.substr(x + 1)));
    if (std::int64_t(size.x) * size.y > std::int64_t(1) << 28)
        throw InputError(fmt::format("{} {}: more than 2^28 pixels", option, text));
    return size;
}

frame::Settings settings_of(const Scene& scene, const SceneOptions& options) {
    frame::Settings settings = frame::settings_of(scene);
    settings.pruning = !options.no_pruning;
    std::vector<Assignment> assignments;
    if (!options.preset.empty())
        for (const Setting& s : frame::find_preset(options.preset, "--preset " + io::printable(options.preset)).settings)
            assignments.push_back({s.table, s.key, s.value, fmt::format("--preset {}: {}.{}", options.preset, s.table, s.key)});
    for (const std::string& text : options.sets) assignments.push_back(parse_assignment(text));
    // The table of a scene file that chooses the method and the layout comes first: a custom layout can then be filled.
    for (const Assignment& a : assignments) {
        if (a.table != "render") continue;
        const auto word = std::get_if<std::string>(&a.value);
        if (a.key == "method" && word)
            settings.method = frame::parse_method(*word, a.place);
        else if (a.key == "layout" && word)
            settings.layout = *word == settings.layout.name ? settings.layout : frame::parse_layout(*word, a.place);
        else
            throw InputError(a.place + ": expected render.method or render.layout, and a word");
    }
    for (const Assignment& a : assignments) {
        if (a.table == "render") continue;
        if (a.table == "light") {
            check_switched(a, scene);
            continue;
        }
        const std::vector<std::string> scene_tables = {"frame", "camera", "mesh", "material", "environment"};
        if (std::count(scene_tables.begin(), scene_tables.end(), a.table))
            throw InputError(fmt::format("{}: [{}] is set in the scene file alone; --set takes [render] and the tables "
                                         "of stages", a.place, a.table));
        std::vector<Field> fields = frame::table_fields(settings, a.table, a.place);
        set_field(find_field(fields, a.key, a.place), a.value, a.place);
        if (a.table == "rsm" && a.key == "pattern")
            settings.rsm.own = io::read_sample_rows(settings.rsm.pattern, settings.rsm.pattern, a.place);
        if (a.table == "layout" && settings.layout.name != "custom") raster::validate(settings.layout, a.place);
    }
    raster::validate(settings.layout, "--set");
    if (!options.method.empty()) settings.method = frame::parse_method(options.method, "--method");
    set_truth(options, settings);
    return settings;
}

int find_light(const Scene& scene, const std::string& name) {
    std::vector<std::string> names;
    for (const Light& light : scene.lights) {
        if (light.name == name) return int(names.size());
        names.push_back(light.name);
    }
    if (names.empty()) throw InputError(fmt::format("--light {}: the scene has no light", name));
    throw InputError(fmt::format("--light {}: unknown light{}", name, nearest_known(name, names)));
}

std::string file_name(const std::string& text) {
    std::string name;
    for (char c : text) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
        name += plain ? c : '_';
    }
    return name.empty() ? "_" : name;
}

std::vector<std::string> light_file_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Light& light : scene.lights) {
        const std::string base = file_name(light.name);
        std::string name = base;
        for (int i = 2; std::find(names.begin(), names.end(), name) != names.end(); ++i)
            name = fmt::format("{}-{}", base, i);
        names.push_back(name);
    }
    return names;
}

}  // namespace plumb::cli
