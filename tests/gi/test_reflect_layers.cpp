// Mirrored rays in depth layers behind the picture: what the camera does not see and a mirror shows.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/frame/reflect_classes.h"
#include "tests/gi/open_room.h"

using namespace plumb;
using test::has;
using test::render;
using test::same;

namespace {

using frame::MirrorClass;
using screen::March;

constexpr double pi = 3.14159265358979;
constexpr double board_z = -1.5;  // m

// A mirror on the floor; panels that float before a board and hide it from the camera. Rays that leave the floor before the panels
// pass below them and meet the board:
//
//     camera          panels   board
//                       |        |
//     ___________________________           The ray from the floor at z = 1 is at 0.3 m below a panel's 0.5, at 0.75 m at the board.
//
// The board sends M = (6, 4, 2) W/m2, panels (1, 1, 1).
Scene hidden_board(int panels) {
    Scene s;
    s.name = "board";
    s.materials.resize(3);
    for (Material& m : s.materials) m.reflectance = glm::vec3(0);
    s.materials[0].mirror = {0.75f, 0.5f, 0.25f};
    s.materials[1].emission = glm::vec3(1), s.materials[2].emission = {6, 4, 2};
    Mesh& m = s.meshes.emplace_back();
    moving::add_quad(m, {-1, 0, 2}, {2, 0, 0}, {0, 0, -3}, 0);
    for (int i = 0; i < panels; ++i) moving::add_quad(m, {-0.6f, 0.5f, -0.25f * float(i)}, {1.2f, 0, 0}, {0, 0.6f, 0}, 1);
    moving::add_quad(m, {-0.35f, 0.55f, float(board_z)}, {0.7f, 0, 0}, {0, 0.3f, 0}, 2);
    s.camera.position = {0, 0.6, 3}, s.camera.look_at = {0, 0.6, -1}, s.camera.up = {0, 1, 0};
    s.camera.fov_y_deg = 45, s.camera.near = 0.1, s.camera.far = 20, s.frame_size = {120, 100};
    return s;
}

frame::Settings marching(March march, int layers) {
    frame::Settings settings;
    settings.method = frame::Method::direct;
    settings.reflect.march = march, settings.reflect.layers = layers;
    settings.reflect.step = 0.05f, settings.reflect.steps = 128;
    settings.reference.rays = Rays::exact;
    return settings;
}

// Where the ray of a mirror's pixel meets the board, m along it; 0: not.
double distance_of(const Scene& scene, const frame::Frame& f, int x, int y) {
    if (f.reflect.mirror(x, y).w == 0) return 0;
    const glm::dvec3 p(f.gbuffer.position(x, y));
    glm::dvec3 r = p - scene.camera.position;
    r = r / std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z);
    r.y = -r.y;
    const double t = (board_z - p.z) / r.z;
    const glm::dvec3 q = p + r * t;
    // A texel within its outline, and as far from where its two triangles meet: a neighbour is another one.
    const bool met = std::abs(q.x) < 0.33 && q.y > 0.56 && q.y < 0.84 && std::abs(q.x - (q.y - 0.7) * (0.7 / 0.3)) > 0.06;
    const double at_panel = p.y + r.y * (-p.z / r.z);
    return met && at_panel < 0.49 ? t : 0;
}

std::int64_t count(const frame::MirrorClasses& c, MirrorClass of) { return c.count[std::size_t(of)]; }

}  // namespace

TEST_CASE("reflect: what the picture hides is found in the layer that shows it", "[frame][reflect][layers][analytic]") {
    const March march = GENERATE(March::steps, March::hierarchical);
    const int panels = GENERATE(1, 2);
    CAPTURE(int(march), panels);
    const Scene scene = hidden_board(panels);
    // The board lies in layer panels + 1: in the layer of number `panels` behind the picture.
    const frame::Settings few = marching(march, panels - 1), enough = marching(march, panels);
    const frame::Frame without = render(scene, few), with = render(scene, enough);
    CHECK(with.reflect.hits.size() == std::size_t(panels) + 1);
    frame::Settings near = enough;  // rays that stop before the board
    near.reflect.steps = 16;
    const frame::MirrorClasses before = classify_mirrors(scene, few, without, {}), after = classify_mirrors(scene, enough, with, {});
    const frame::MirrorClasses stopped = classify_mirrors(scene, near, render(scene, near), {});
    int asked = 0;
    for (int y = 0; y < scene.frame_size.y; ++y)
        for (int x = 0; x < scene.frame_size.x; ++x) {
            const glm::vec4 hit = with.reflect.hits.back()(x, y), missed = without.reflect.hits.back()(x, y);
            // The camera's hit stands.
            const glm::vec4 first = with.reflect.hits.front()(x, y);
            if (first.w == 1) CHECK(hit == first);
            const double t = distance_of(scene, with, x, y);
            if (t == 0) continue;
            ++asked;
            CAPTURE(x, y, t);
            CHECK(missed.w == 0);
            CHECK(hit.w == float(panels + 1));
            CHECK(before.of_pixel(x, y) == float(int(MirrorClass::unseen)));
            CHECK(after.of_pixel(x, y) == float(int(MirrorClass::right_in_layer)));
            CHECK(stopped.of_pixel(x, y) == float(int(MirrorClass::missed_in_layer)));
            CHECK(double(hit.z) == Approx(t).margin(0.05 / 256 + 1e-5));
            for (int c = 0; c < 3; ++c)
                CHECK(double(with.reflect.reflection(x, y)[c]) ==
                      Approx(double(scene.materials[0].mirror[c]) * scene.materials[2].emission[c] / pi).epsilon(1e-6));
        }
    CHECK(asked > 100);
    CHECK(before.mirrors() == after.mirrors());
    CHECK(count(after, MirrorClass::right) == count(before, MirrorClass::right));
    CHECK(count(after, MirrorClass::unseen) < count(before, MirrorClass::unseen) - asked + 1);
    // Its bits are the same everywhere.
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = isa == Isa::scalar ? 1 : 3;
        CHECK(same(render(scene, enough, options).reflect.reflection, with.reflect.reflection));
    }
}

TEST_CASE("reflect: what is met in a layer is lit by all lights", "[frame][reflect][layers]") {
    // The board reflects, and is lit from the right by one of two lamps, which the other does not reach.
    Scene scene = hidden_board(1);
    scene.materials[2].reflectance = {0.5f, 0.25f, 0.125f};
    scene.lights.push_back(moving::spot("key", {1.5f, 0.7f, 0}, {-1.5f, 0, -1.5f}, 6));
    scene.lights.push_back(moving::spot("other", {0, 1, 2.5f}, {0, -0.2f, -1}, 4));
    for (Light& light : scene.lights) light.rsm_size = 256;
    const frame::Settings settings = marching(March::steps, 1);
    const frame::Plan plan = frame::plan(scene, settings);
    for (const char* label : {"gbuffer.layer (mirrored layer 2)", "screen.reflect", "screen.reflect (mirrored layer 2)",
                              "shadow (key, mirrored)", "direct (mirrored)", "screen.mirror"}) {
        CAPTURE(label);
        CHECK(has(plan, label));
    }
    CHECK_FALSE(has(plan, "gbuffer (key, map)"));
    CHECK_FALSE(has(plan, "direct (mirrored layer 2)"));
    const frame::Frame f = render(scene, settings);
    int asked = 0;
    for (int y = 0; y < scene.frame_size.y; ++y)
        for (int x = 0; x < scene.frame_size.x; ++x) {
            const double t = distance_of(scene, f, x, y);
            if (t == 0) continue;
            const glm::vec3 q(f.views.back().gbuffer.position(x, y));
            CHECK(q.z == Approx(board_z).margin(1e-4));
            if (q.x < -0.25f) continue;  // where the cone of the spot ends
            // I cos / d^2 of the key light alone; the panel is before the other.
            const glm::dvec3 to = glm::dvec3(scene.lights[0].position) - glm::dvec3(q);
            const double d2 = to.x * to.x + to.y * to.y + to.z * to.z, d = std::sqrt(d2);
            const double e = 6 * (to.z / d) / d2;
            if (double(f.views.back().direct(x, y).x) == 0) continue;
            ++asked;
            CHECK(double(f.views.back().direct(x, y).x) == Approx(e).epsilon(1e-3));
            const Material& m = scene.materials[2];
            for (int c = 0; c < 3; ++c)
                CHECK(double(f.reflect.reflection(x, y)[c]) ==
                      Approx(double(scene.materials[0].mirror[c]) * (double(m.reflectance[c]) * e + m.emission[c]) / pi).epsilon(1e-3));
        }
    CHECK(asked > 100);
}

TEST_CASE("reflect: layers for mirrors send no light and cost nothing where nothing mirrors", "[frame][reflect][layers]") {
    Scene scene = test::open_room({1, 0.1f, 0.6f, 0.7, {48, 40}});
    scene.materials.resize(2);
    scene.materials[1].reflectance = glm::vec3(0.3f), scene.materials[1].mirror = glm::vec3(0.5f);
    frame::Settings settings;
    settings.method = frame::Method::isr, settings.isr.layers = 2;
    settings.reflect.march = March::steps;
    const frame::Frame none = render(scene, settings);
    settings.reflect.layers = 2;
    const frame::Plan plan = frame::plan(scene, settings);
    CHECK(has(plan, "gbuffer.layer (layer 2)"));
    CHECK(has(plan, "gbuffer.layer (mirrored layer 3)"));
    const frame::Frame f = render(scene, settings);
    CHECK(same(none.indirect, f.indirect));
    CHECK(same(none.reflect.composed, f.reflect.composed));
    CHECK(f.reflect.hits.size() == 3);
    // Where no shadow is cast, what is met has none.
    settings.method = frame::Method::zbuffer;
    CHECK(has(frame::plan(scene, settings), "screen.reflect (mirrored layer 3)"));
    CHECK_FALSE(has(frame::plan(scene, settings), "shadow (key, mirrored)"));
    CHECK_FALSE(render(scene, settings).reflect.reflection.empty());

    scene.materials[1].mirror = glm::vec3(0);
    settings.method = frame::Method::direct;
    for (const frame::StageRun& s : render(scene, settings).stages)
        if (s.label.find("mirrored layer") != std::string::npos) CHECK(s.rule == "no-mirror");
}

TEST_CASE("reflect: LRA's listing has no layers", "[frame][reflect][layers][input]") {
    frame::Settings settings = marching(March::steps, 1);
    settings.reflect.variant = screen::ReflectVariant::published;
    CHECK_THROWS_WITH(frame::plan(hidden_board(1), settings), Catch::Contains("variant = published with layers = 1"));
}
