#include "tools/shared/light_sets.h"

#include <fmt/format.h>

#include <charconv>

#include "core/error.h"
#include "core/nearest_known.h"

namespace plumb::cli {

namespace {

struct Switch {
    std::size_t light;
    bool on;
};

Switch switch_of(const Assignment& set, const Scene& scene) {
    const std::size_t dot = set.key.rfind('.');
    const auto on = std::get_if<bool>(&set.value);
    if (dot == std::string::npos || dot == 0 || set.key.substr(dot + 1) != "on" || !on)
        throw InputError(set.place + ": expected light.N.on=true or false, N its number or name; all else of a light is set in the scene file alone");
    const std::string which = set.key.substr(0, dot);
    std::vector<std::string> names;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        if (scene.lights[l].name == which) return {l, *on};
        names.push_back(scene.lights[l].name);
    }
    if (names.empty()) throw InputError(set.place + ": the scene has no light");
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(which.data(), which.data() + which.size(), number);
    if (error == std::errc() && end == which.data() + which.size()) {
        if (number >= 1 && number <= names.size()) return {number - 1, *on};
        throw InputError(fmt::format("{}: expected 1 to {}, or a name", set.place, names.size()));
    }
    throw InputError(fmt::format("{}: unknown light{}", set.place, nearest_known(which, names)));
}

}  // namespace

void switch_lights(const std::vector<std::string>& sets, Scene& scene) {
    for (const std::string& text : sets) {
        const Assignment set = parse_assignment(text);
        if (set.table != "light") continue;
        const auto [light, on] = switch_of(set, scene);
        scene.lights[light].on = on;
        for (LightTracks& tracks : scene.animation.lights)
            if (tracks.light == int(light)) tracks.on.clear();
    }
}

void check_switched(const Assignment& set, const Scene& scene) {
    const auto [light, on] = switch_of(set, scene);
    if (scene.lights[light].on != on) throw InputError(set.place + ": this command does not switch lights: expected it in the scene file");
}

}  // namespace plumb::cli
