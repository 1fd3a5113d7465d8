// Lights that are none, many, too strong or too weak, or in the wrong place; and what they fall on.
#include <fmt/format.h>

#include "core/host_math.h"
#include "gi/stability/cases_parts.h"

namespace plumb::stability {

namespace {

using Change = std::function<void(Scene&)>;

Case lit(const std::string& name, const std::string& group, const std::string& meaning, const Change& change,
         const std::function<void(frame::Settings&)>& settings = nullptr) {
    return {name, group, meaning,
            [change] {
                Scene s = room();
                change(s);
                return s;
            },
            settings};
}

void no_pruning(frame::Settings& settings) { settings.pruning = false; }

Change intensities(double by) {
    return [=](Scene& s) {
        for (Light& l : s.lights) l.intensity = glm::vec3(glm::dvec3(l.intensity) * by);
    };
}

// The key is so many times as bright as the lamp; the sun keeps between them.
Change ratio(double by) {
    return [=](Scene& s) { s.lights[key].intensity = glm::vec3(glm::dvec3(s.lights[lamp].intensity) * by); };
}

void thousand(Scene& s) {
    s.frame_size = {12, 8};
    s.lights.clear();
    for (int i = 0; i < 1000; ++i) {
        Light l;
        l.name = fmt::format("l{}", i);
        l.type = i % 2 ? LightType::spot : LightType::directional;
        l.position = {float(i % 10) / 8 - 0.5f, 1.75f + float(i % 7) / 32, float(i / 10 % 10) / 8 - 0.5f};
        l.direction = {float(i % 5 - 2) / 8, -1, float(i % 3 - 1) / 8};
        l.intensity = glm::vec3(0.01f, 0.012f, 0.009f);
        l.rsm_size = 2;
        s.lights.push_back(l);
    }
}

void lights_inside(Scene& s) {
    s.lights[key].position = {0.25f, 0.375f, -0.125f}, s.lights[lamp].position = {0.25f, 0.25f, -0.125f};
}
// The spot lies on the floor and looks along it, the lamp on the left wall.
void lights_on_surfaces(Scene& s) {
    s.lights[key].position = {-0.5f, 0, 0.5f}, s.lights[key].direction = {0, 0.25f, -1};
    s.lights[lamp].position = {-1, 1, 0};
}
void lights_on_a_corner(Scene& s) { s.lights[key].position = s.lights[lamp].position = {-1, 0, -1}; }

Change cone(float inner, float outer) {
    return [=](Scene& s) { s.lights[key].cone_inner_deg = inner, s.lights[key].cone_outer_deg = outer; };
}

// Sun and spot graze the floor under that angle; the walls that they would meet first are taken away.
Change grazing_light(double angle) {
    return [=](Scene& s) {
        const float height = float(host::sin(angle)), along = float(host::cos(angle));
        s.meshes.erase(s.meshes.begin() + left_mesh, s.meshes.begin() + right_mesh + 1);
        s.lights[sun].direction = {along, -height, 0};
        s.lights[key].position = glm::vec3(-3 * along, 3 * height, 0), s.lights[key].direction = {along, -height, 0};
        s.lights[lamp].position = glm::vec3(0.5f, height, 0.5f);
    };
}

// The camera sees the floor under that angle, give or take two thirds.
Change grazing_view(double angle) {
    return [=](Scene& s) {
        s.camera.position = {0, host::sin(angle), 1}, s.camera.look_at = {0, 0, 0};
        s.camera.fov_y_deg = 1.3 * angle * 180 / host::pi;
        s.meshes.erase(s.meshes.begin() + box_mesh);
    };
}
// The camera looks along the floor, from within its plane.
void view_in_plane(Scene& s) { s.camera.position = {0, 0, 0.75}, s.camera.look_at = {0, 0, 0}; }

Change reflectance(float rho) {
    return [=](Scene& s) {
        for (Material& m : s.materials) m.reflectance = glm::vec3(rho), m.texture = -1;
    };
}

}  // namespace

std::vector<Case> light_cases() {
    std::vector<Case> list = {
        lit(
            "no light", "light", "there is none, and nothing is left out for it", [](Scene& s) { s.lights.clear(); },
            no_pruning),
        lit("black light", "light", "every intensity is 0, and nothing is left out for it", intensities(0), no_pruning),
        lit("1000 lights", "light", "spots and suns with maps of 2 x 2 texels", thousand),
        lit("light inside geometry", "light", "spot and lamp are inside the box", lights_inside),
        lit("light on a surface", "light", "the spot lies on the floor, the lamp on a wall, exactly",
            lights_on_surfaces),
        lit("light on a corner", "light", "spot and lamp lie where three surfaces meet: a vertex is at the light",
            lights_on_a_corner),
        lit("cone without border", "light", "the spot's inner cone is its outer", cone(30, 30)),
        lit("cone of 0.001 degrees", "light", "cosines of the spot's cones are 1 in a float", cone(5e-4f, 1e-3f)),
        lit("cone of 89 degrees", "light", "the spot's map is 115 m wide at 1 m", cone(0, 89)),
    };
    for (const double by : {1e-6, 1e-3, 1e4, 1e8})
        list.push_back(lit("light ratio " + power_text(by), "light",
                           fmt::format("the spot is {:g} times as bright as the lamp", by), ratio(by)));
    list.push_back(lit("intensity 1e-30", "light", "all lights are that much weaker", intensities(1e-30)));
    list.push_back(lit("intensity 1e30", "light", "all lights are that much stronger", intensities(1e30)));
    list.push_back(lit("denormal intensity", "denormal", "all lights are weaker by 1e-40", intensities(1e-40)));
    for (const double angle : {1e-3, 1e-6}) {
        list.push_back(lit("light grazing " + power_text(angle), "grazing",
                           fmt::format("sun, spot and lamp meet the floor under {:g} rad", angle),
                           grazing_light(angle)));
        list.push_back(lit("view grazing " + power_text(angle), "grazing",
                           fmt::format("the camera sees the floor under {:g} rad", angle), grazing_view(angle)));
    }
    list.push_back(
        lit("light at 90 degrees", "grazing", "sun, spot and lamp lie in the floor's plane", grazing_light(0)));
    list.push_back(lit("view at 90 degrees", "grazing", "the camera lies in the floor's plane", view_in_plane));
    list.push_back(lit("reflectance 0", "reflectance", "nothing reflects, and nothing is left out for it",
                       reflectance(0), no_pruning));
    list.push_back(lit("reflectance 0.999999", "reflectance", "a spectral radius near 1", reflectance(0.999999f)));
    list.push_back(lit("reflectance 1", "reflectance", "all light is reflected", reflectance(1)));
    return list;
}

}  // namespace plumb::stability
