// What is refused before anything is rendered, and what is not.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "gi/frame/frame.h"
#include "gi/frame/refusals.h"
#include "gi/reference/closed_form_scenes.h"

using namespace plumb;
using namespace plumb::frame;
using reference::grey;

namespace {

// A closed cube of 2 m with a camera and a spot in it.
Scene room(const Material& wall, const glm::dvec3& centre = glm::dvec3(0), double half = 1) {
    Scene s;
    s.name = "room";
    reference::add_cube(s, wall, centre - half, centre + half);
    s.materials[0].name = "wall";
    s.camera.position = centre + half * glm::dvec3(0, 0, 0.5), s.camera.look_at = centre;
    s.frame_size = {16, 16};
    Light key;
    key.name = "key";
    key.position = glm::vec3(centre + half * glm::dvec3(0, 0.5, 0));
    key.rsm_size = 16;
    s.lights = {key};
    return s;
}

Settings by_paths(int max_bounces = 0) {
    Settings settings;
    settings.method = Method::reference;
    settings.reference.max_bounces = max_bounces;
    return settings;
}

Settings stored_in(const raster::Layout& layout) {
    Settings settings;
    settings.layout = layout;
    return settings;
}

Scene with_intensity(float intensity) {
    Scene s = room(grey(0.5));
    s.lights[0].intensity = glm::vec3(intensity);
    return s;
}

}  // namespace

TEST_CASE("refusals: a flux that overflows or vanishes in its target is refused by its light", "[frame][refusals]") {
    // The spot's outer angle is 45 degrees: a texel of 16 is 1/8 wide at 1 m, so 1/64 sr; with rho 0.5 I / 128 W.
    const Settings half = stored_in(raster::Layout::rgba16f);
    const double most = 65504.0 * 128, least = 0x1p-25 * 128;
    CHECK_NOTHROW(plan(with_intensity(float(most * 0.99)), half));
    CHECK_THROWS_WITH(plan(with_intensity(float(most * 1.01)), half),
                      Catch::StartsWith("room: rsm: light \"key\": flux up to 6.616e+04 W a texel does not fit rgba16f"));
    CHECK_NOTHROW(plan(with_intensity(float(least * 1.01)), half));
    CHECK_THROWS_WITH(plan(with_intensity(float(least * 0.99)), half),
                      Catch::Contains("light \"key\"") && Catch::Contains("vanishes in rgba16f"));
    // In fp32 both are served; so is a light that is off.
    CHECK_NOTHROW(plan(with_intensity(float(most * 100)), stored_in(raster::Layout::fp32)));
    CHECK_NOTHROW(plan(with_intensity(float(least / 100)), stored_in(raster::Layout::fp32)));
    Scene off = with_intensity(float(most * 2));
    off.lights[0].on = false;
    CHECK_NOTHROW(plan(off, half));

    raster::Layout small;
    small.name = "custom", small.rsm_flux = Format::r11g11b10f;
    CHECK_NOTHROW(plan(with_intensity(64512.0f * 127), stored_in(small)));
    CHECK_THROWS_WITH(plan(with_intensity(64512.0f * 129), stored_in(small)),
                      Catch::Contains("does not fit r11g11b10f"));
}

TEST_CASE("refusals: the bound of a flux is what the map holds", "[frame][refusals]") {
    // Above 65,520 a half is infinite. The room's nearest wall lies in the middle of the map and has the largest texel.
    const Scene s = with_intensity(65520.0f * 128);
    const Frame f = execute(s, stored_in(raster::Layout::fp32), plan(s, stored_in(raster::Layout::fp32)), {});
    // A texel off the middle by half of one: its cosines take (1 + 2 / 16^2)^-2 and less than 2 % in all.
    CHECK(f.rsms[0][0].largest_flux <= 65520 * 1.000001f);
    CHECK(f.rsms[0][0].largest_flux >= 65520 * 0.98f);

    // The pass refuses what plan() refuses, by the same bound, and nothing that it draws is infinite.
    const Settings half = stored_in(raster::Layout::rgba16f);
    const Scene above = with_intensity(65504.0f * 129), below = with_intensity(65504.0f * 127);
    CHECK_THROWS_AS(plan(above, half), InputError);
    CHECK_THROWS_WITH(execute(above, half, plan(above, half, rules()), {}),
                      Catch::StartsWith("rsm: light \"key\": flux up to 6.602e+04 W a texel does not fit rgba16f"));
    // Such a light's irradiance would not fit a half: it stays a float.
    Settings half_maps = half;
    half_maps.layout.name = "custom", half_maps.layout.indirect = Format::rgba32f;
    const Frame drawn = execute(below, half_maps, plan(below, half_maps), {});
    CHECK(drawn.rsms[0][0].largest_flux > 60000);
    CHECK(drawn.rsms[0][0].largest_flux <= 65504);
}

TEST_CASE("refusals: what falls on a texel has to be a float, however little of it is reflected", "[frame][refusals]") {
    // 1e38 W/m2 on texels some 40 km wide are 1e47 W; times a reflectance of 0 that would be no number.
    Scene s = room(grey(0), glm::dvec3(0), 2e5);
    s.lights[0].type = LightType::directional;
    s.lights[0].intensity = glm::vec3(1e38f);
    Settings whole;
    whole.pruning = false;
    CHECK_THROWS_WITH(plan(s, whole), Catch::Contains("light \"key\"") && Catch::Contains("falls on a texel"));
    // With pruning nothing is reflected, and no map holds flux.
    const Frame f = execute(s, {}, plan(s, {}), {});
    for (const glm::vec4& texel : f.radiance.texels) CHECK(texel == glm::vec4(0));
    s.lights[0].intensity = glm::vec3(1e27f);
    CHECK_NOTHROW(plan(s, whole));
}

TEST_CASE("refusals: what no stage reads is not asked for, and what runs is asked once with its plan",
          "[frame][refusals]") {
    // By the method direct a map has its depth alone: no flux is stored. Without pruning it is, and then it has to fit.
    Settings direct = stored_in(raster::Layout::rgba16f);
    direct.method = Method::direct;
    const Scene bright = with_intensity(65504.0f * 200);
    CHECK_NOTHROW(execute(bright, direct, plan(bright, direct), {}));
    direct.pruning = false;
    CHECK_THROWS_WITH(plan(bright, direct), Catch::Contains("flux up to"));
    // A light that is off draws nothing, or zeros.
    Scene off = bright;
    off.lights[0].on = false;
    for (const bool pruning : {true, false}) {
        Settings half = stored_in(raster::Layout::rgba16f);
        half.pruning = pruning;
        CHECK_NOTHROW(plan(off, half));
        // What the layout asks of the camera, and coordinates, are asked of every plan, though the camera sees nothing.
        Settings isr = stored_in(raster::Layout::isr);
        isr.pruning = pruning;
        Scene endless = room(grey(0.5));
        endless.camera.far = std::numeric_limits<double>::infinity();
        endless.camera.position = {0, 0, 5}, endless.camera.look_at = {0, 0, 10};
        CHECK_THROWS_WITH(plan(endless, isr), Catch::StartsWith("room: gbuffer: layout \"isr\" divides depth by"));
        endless.meshes.clear();
        CHECK_THROWS_WITH(plan(endless, isr), Catch::Contains("far plane, which is infinite"));
        Scene broken = room(grey(0.5));
        broken.camera.look_at = {0, 0, 10};
        broken.meshes[0].vertices[2].position.y = std::numeric_limits<float>::quiet_NaN();
        CHECK_THROWS_WITH(plan(broken, half), Catch::StartsWith("room: mesh ") &&
                                                  Catch::Contains("vertex 2 at (") &&
                                                  Catch::Contains("expected finite coordinates"));
    }
}

TEST_CASE("refusals: emission counts with the largest texel of its texture", "[frame][refusals]") {
    Scene s = room(grey(0.5, 100000));
    Texture dim;
    dim.name = "dim", dim.srgb = false;
    dim.texels = Image<std::uint32_t>(2, 2, 0xff000000u);
    dim.texels(1, 0) = 0xff969696u;  // 150 / 255 of 1e5 is 58,824
    s.textures = {dim};
    s.materials[0].emission_texture = 0;
    const Settings half = stored_in(raster::Layout::rgba16f);
    const Frame f = execute(s, half, plan(s, half), {});
    for (const glm::vec4& e : f.gbuffer.emission.texels) CHECK(e.x <= 65504);
    s.textures[0].texels(1, 0) = 0xff9696b4u;  // 180 / 255 of it, in red, is 70,588
    CHECK_THROWS_WITH(plan(s, half), Catch::Contains("emission of 7.059e+04 W/m2 does not fit rgba16f (65504)"));
    CHECK_THROWS_WITH(execute(s, half, plan(s, half, rules()), {}), Catch::StartsWith("gbuffer: material \"wall\""));
    // Unsigned floats of 11 bits hold 65,024, of 10 bits, in blue, 64,512.
    raster::Layout small;
    small.name = "custom", small.emission = Format::r11g11b10f;
    CHECK_NOTHROW(plan(room(grey(0.5, 64512)), stored_in(small)));
    CHECK_THROWS_WITH(plan(room(grey(0.5, 64600)), stored_in(small)), Catch::Contains("(64512)"));
}

TEST_CASE("refusals: positions and emission that overflow their targets", "[frame][refusals]") {
    const Settings half = stored_in(raster::Layout::rgba16f);
    CHECK_THROWS_WITH(plan(room(grey(0.5), {0, 0, 70000}, 20000), half),
                      Catch::Contains("km do not fit rgba16f"));
    CHECK_THROWS_WITH(plan(room(grey(0.5, 70000)), half),
                      Catch::StartsWith("room: gbuffer: material \"wall\": emission of 7e+04 W/m2 does not fit rgba16f"));
    CHECK_NOTHROW(plan(room(grey(0.5, 65000)), half));
}

TEST_CASE("refusals: scenes that a float cannot tell from a point, or whose distances leave it", "[frame][refusals]") {
    const Settings direct = [] {
        Settings s;
        s.method = Method::direct;
        return s;
    }();
    // 2 m, 1e7 m off: floats are 1.2 m apart there, and 1e6 m off 0.12 m.
    CHECK_THROWS_WITH(plan(room(grey(0.5), glm::dvec3(1e7)), direct),
                      Catch::Contains("a scene of 2 m lies 1e+07 m from the origin, where floats are 1.192 m apart"));
    CHECK_NOTHROW(plan(room(grey(0.5), glm::dvec3(1e6)), direct));
    CHECK_THROWS_WITH(plan(room(grey(0.5), glm::dvec3(0), 0x1p61), direct), Catch::Contains("overflow"));
    CHECK_THROWS_WITH(plan(room(grey(0.5), glm::dvec3(0), 0x1p-62), direct), Catch::Contains("vanish"));
    for (const double half : {1e-15, 1e-4, 1e6, 1e15})
        CHECK_NOTHROW(plan(room(grey(0.5), glm::dvec3(0), half), direct));

    // Rays from the G-buffer's points: 2^-20 of 1e5 m is 0.095 m, of a scene of 2 m more than 1/64.
    Settings rays;
    rays.rsm.gather = rsm::Gather::all_rays;
    CHECK_THROWS_WITH(plan(room(grey(0.5), glm::dvec3(1e5)), rays),
                      Catch::Contains("rays have to keep 0.09537 m off"));
    CHECK_NOTHROW(plan(room(grey(0.5), glm::dvec3(1e4)), rays));
    CHECK_NOTHROW(plan(room(grey(0.5), glm::dvec3(1e5)), direct));
}

TEST_CASE("refusals: a closed room that reflects everything does not converge", "[frame][refusals]") {
    const Material white = grey(1, 1);
    const char* message =
        "reflects 1 in channel R: the sum of all reflections does not converge: set [reference] max_bounces";
    CHECK_THROWS_WITH(plan(room(white), by_paths()),
                      Catch::Contains("\"wall\"") && Catch::Contains(message));
    // What the message says helps.
    CHECK_NOTHROW(plan(room(white), by_paths(8)));
    CHECK_NOTHROW(plan(room(grey(0.9999995f, 1)), by_paths()));
    CHECK_THROWS_AS(plan(room(grey(0.9999998f, 1)), by_paths()), InputError);
    // A mirror reflects as well as a diffuse wall; Phong's lobe loses some.
    Material half_mirror = grey(0.5, 1);
    half_mirror.mirror = glm::vec3(0.5f);
    CHECK_THROWS_AS(plan(room(half_mirror), by_paths()), InputError);
    half_mirror.mirror = glm::vec3(0), half_mirror.specular = glm::vec3(0.5f);
    CHECK_NOTHROW(plan(room(half_mirror), by_paths()));
    // One channel is enough.
    Material red = grey(0.5);
    red.reflectance.x = 1;
    CHECK_THROWS_WITH(plan(room(red), by_paths()), Catch::Contains("channel R"));
    // Settings that trace no such paths.
    CHECK_NOTHROW(plan(room(white), Settings{}));
    Settings once = by_paths();
    once.reference.mode = reference::Mode::one_bounce;
    CHECK_NOTHROW(plan(room(white), once));
}

TEST_CASE("refusals: light that can leave, or that something takes, converges", "[frame][refusals]") {
    const Material white = grey(1, 1);
    // A camera outside the cube; a cube without its last wall; a room with one darker thing in it.
    Scene outside = room(white);
    outside.camera.position = {0, 0, 5};
    CHECK_NOTHROW(plan(outside, by_paths()));
    Scene open = room(white);
    open.meshes[0].triangles.resize(10), open.meshes[0].material.resize(10);
    CHECK_NOTHROW(plan(open, by_paths()));
    Scene darker = room(white);
    reference::add_rectangle(darker, grey(0.9), {-0.5, 0, -0.5}, {0.5, 0, 0.5});
    CHECK_NOTHROW(plan(darker, by_paths()));
    // A white panel within a white room takes nothing, and neither does a white box around which light goes.
    Scene panel = room(white);
    reference::add_rectangle(panel, white, {-0.5, 0, -0.5}, {0.5, 0, 0.5});
    CHECK_THROWS_AS(plan(panel, by_paths()), InputError);
    Scene box = room(white);
    reference::add_cube(box, white, glm::dvec3(-0.25), glm::dvec3(0.25));
    CHECK_THROWS_AS(plan(box, by_paths()), InputError);
    // A sphere has other edges.
    Scene sphere = room(white);
    sphere.meshes.clear(), sphere.materials.clear();
    reference::add_sphere(sphere, white, glm::dvec3(0), 1, 3);
    CHECK_THROWS_AS(plan(sphere, by_paths()), InputError);
}

TEST_CASE("refusals: how many passes a reflectance takes", "[frame][refusals][analytic]") {
    // verification.md 3, the unit cube of which one face emits: after n plain passes the mean lacks rho^n of itself,
    // every element as much in W/m2. The darkest, the opposite face, lacks most of what it has: 1e-6 of it there.
    const struct {
        double rho, opposite;
        int passes;
    } table[] = {{0.5, 0.181745826, 21}, {0.8, 0.689551071, 63}, {0.95, 3.193159845, 271}, {0.99, 16.527425128, 1376}};
    for (const auto [rho, opposite, passes] : table) {
        const double mean = 1 / (6 * (1 - rho));
        CAPTURE(rho);
        CHECK(passes_needed(rho, 1e-6 * opposite / mean) == passes);
    }
    Scene s = room(grey(0.25));
    reference::add_rectangle(s, grey(0.5), {-0.5, 0, -0.5}, {0.5, 0, 0.5});
    s.materials[1].specular = {0, 0.125f, 0}, s.materials[1].mirror = {0.0625f, 0.25f, 0};
    s.materials.push_back(grey(1));  // no surface has it
    CHECK(spectral_radius_bound(s, flatten(s)) == 0.875);
}

TEST_CASE("refusals: what is rendered all the same, but may not be what is wanted", "[frame][refusals]") {
    CHECK(warnings(room(grey(0.5)), by_paths()).empty());
    // Only who traces is told; below 0.999 nobody. ln(1e-3) / ln(0.9995f) = 13811.4.
    CHECK(warnings(room(grey(0.9995)), Settings{}).empty());
    CHECK(warnings(room(grey(0.998)), by_paths()).empty());
    const std::vector<std::string> traced = warnings(room(grey(0.9995)), by_paths());
    REQUIRE(traced.size() == 1);
    CHECK_THAT(traced[0], Catch::Contains("13812 reflections leave a thousandth"));
    const std::vector<std::string> far = warnings(room(grey(0.5), glm::dvec3(2e6)), Settings{});
    REQUIRE(far.size() == 1);
    CHECK_THAT(far[0], Catch::Contains("0.2384 m apart"));
}
