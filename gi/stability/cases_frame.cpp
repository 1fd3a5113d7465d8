// Frames and maps of unusual sizes, formats at their ends, and parameters at theirs.
#include "gi/stability/cases_parts.h"

namespace plumb::stability {

namespace {

using Setup = std::function<void(frame::Settings&)>;

Case sized(const std::string& name, const std::string& meaning, glm::ivec2 size) {
    return {name, "size", meaning, [=] {
                Scene s = room();
                s.frame_size = size;
                return s;
            }};
}

Case stored(const std::string& name, const std::string& meaning, const raster::Layout& layout,
            const std::function<void(Scene&)>& change = nullptr) {
    return {name, "storage", meaning,
            [=] {
                Scene s = room();
                if (change) change(s);
                return s;
            },
            [=](frame::Settings& settings) { settings.layout = layout; }};
}

// A strip from the room to that coordinate, and a camera that sees as far as a half holds depths. Lamp and sun would
// see farther than that.
std::function<void(Scene&)> reaching(float x) {
    return [=](Scene& s) {
        s.meshes.push_back(quad("strip", {{{0, -0.0625f, 1}, {x, -0.0625f, 1}, {x, -0.0625f, -1}, {0, -0.0625f, -1}}},
                                tiles));
        s.camera.far = 65504;
        s.lights.erase(s.lights.begin() + lamp, s.lights.end());
    };
}

// One kilometre along each axis: halves are 0.5 m apart there.
void at_1_km(Scene& s) { move(s, {1000, 1000, 1000}); }

void strong_lights(Scene& s) {
    for (Light& l : s.lights) l.intensity *= 1e8f;
}
void strong_emission(Scene& s) { s.materials[glow].emission = glm::vec3(1e5f); }
void no_far_end(Scene& s) { s.camera.far = __builtin_inf(); }

Case set(const std::string& name, const std::string& meaning, const Setup& setup) {
    return {name, "settings", meaning, room, setup};
}

}  // namespace

std::vector<Case> frame_cases() {
    using raster::Layout;
    return {
        {"empty scene", "scene", "no mesh at all, and nothing is left out for it",
         [] {
             Scene s = room();
             s.meshes.clear();
             return s;
         },
         [](frame::Settings& settings) { settings.pruning = false; }},
        sized("one pixel", "a frame of 1 x 1", {1, 1}),
        sized("16384 x 1", "a frame of one row", {16384, 1}),
        sized("67 x 45", "sizes that are no multiple of a tile", {67, 45}),
        {"map of 512 texels", "size", "262,144 texels are added up: a frame of 3 x 2 and the spot alone",
         [] {
             Scene s = room();
             s.frame_size = {3, 2};
             s.lights.resize(1);
             s.lights[key].rsm_size = 512;
             return s;
         }},
        {"maps of one texel", "size", "each light's map has one texel a side",
         [] {
             Scene s = room();
             for (Light& l : s.lights) l.rsm_size = 1;
             return s;
         }},
        stored("rgba16f", "all targets in halves", Layout::rgba16f),
        stored("vrsm", "the G-buffer of VRSM", Layout::vrsm),
        stored("isr", "the G-buffer of ISR: positions from depth", Layout::isr),
        stored("lra", "the G-buffer of LRA", Layout::lra),
        stored("isr, far infinite", "depth divided by a far plane that is infinite", Layout::isr, no_far_end),
        stored("rgba16f at 65504", "coordinates up to the largest half", Layout::rgba16f, reaching(65504)),
        stored("rgba16f at 65520", "coordinates that round to infinity in a half", Layout::rgba16f, reaching(65520)),
        stored("rgba16f at 1 km", "halves are half a metre apart there", Layout::rgba16f, at_1_km),
        stored("rgba16f, flux", "lights whose flux does not fit a half", Layout::rgba16f, strong_lights),
        stored("rgba16f, emission", "emission of 1e5 W/m2, which does not fit a half", Layout::rgba16f,
               strong_emission),
        set("published", "gather, shadow and direct light as printed",
            [](frame::Settings& s) {
                s.rsm.variant = rsm::Variant::published, s.shadow.variant = direct::ShadowVariant::published;
                s.direct.variant = direct::DirectVariant::published;
            }),
        set("projection clamped", "points outside of a map gather from its border",
            [](frame::Settings& s) { s.rsm.projection = rsm::Projection::clamped; }),
        set("min distance 1e-15", "the floor of the distance between point and texel is near what a float squares",
            [](frame::Settings& s) { s.rsm.min_distance = 1e-15f; }),
        set("min distance 1e18", "the floor of the distance is near what a float squares, from above",
            [](frame::Settings& s) { s.rsm.min_distance = 1e18f; }),
        set("no bias", "the shadow test without any bias",
            [](frame::Settings& s) { s.shadow.bias = 0, s.shadow.slope_bias = 0; }),
        set("one sample", "a disc of one sample, one path of one",
            [](frame::Settings& s) { s.rsm.samples = s.rsm.directions = s.rsm.steps = 1; }),
        set("slots meet at 0", "an edge of the micro linear buffer lies where a floor is seen from itself",
            [](frame::Settings& s) { s.rsm.slots = 4; }),
        set("exposure 1e-6", "a picture that is nearly black", [](frame::Settings& s) { s.tonemap.exposure = 1e-6f; }),
        set("exposure 1e6", "a picture that is white", [](frame::Settings& s) { s.tonemap.exposure = 1e6f; }),
    };
}

}  // namespace plumb::stability
