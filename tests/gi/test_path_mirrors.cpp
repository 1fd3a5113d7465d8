// Light that a lamp sends by way of mirrors: a path cannot run into a point, so its images are asked. Each expected number is
// that of the lamp's image in an open room.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/host_math.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/reference.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

Material mirror_of(double reflectance) {
    Material m = grey(0);
    m.mirror = glm::vec3(float(reflectance));
    return m;
}

PathParams with(Mode mode, int samples = 1024) {
    PathParams p;
    p.mode = mode, p.samples = samples;
    return p;
}

struct Found {
    double value = 0, error = 0;
};

Found irradiance_at(const Scene& scene, const glm::dvec3& at, const glm::dvec3& normal, const PathParams& params,
                    std::uint64_t paths = 4096) {
    const ReceiverPoints point = repeated(at, normal, paths);
    const Estimate e = trace_irradiance(params, *prepare(scene, params.rays), {&point.position, &point.normal}, 5, {});
    REQUIRE(e.nonfinite == 0);
    Found f;
    for (std::size_t i = 0; i < e.mean.size(); ++i)
        f.value += e.mean.texels[i].x, f.error += double(e.error.texels[i].x) * e.error.texels[i].x;
    const double n = double(e.mean.size());
    return {f.value / n, std::sqrt(f.error) / n};
}

void check_equal(const Found& got, double want) {
    CAPTURE(got.value, got.error, want);
    CHECK(got.error <= 0.01 * want);
    CHECK(std::abs(got.value - want) <= 4 * got.error + 2e-5 * want);
}

constexpr double power = 4 * host::pi;  // 1 W/sr

// Irradiance at the origin, which looks up, of 1 W/sr at p.
double from(const glm::dvec3& p) {
    const double d2 = p.x * p.x + p.y * p.y + p.z * p.z;
    return p.y / (d2 * std::sqrt(d2));
}

// A lamp at (0, 1, 0) over the origin, and a plate between them.
Scene hidden_lamp() {
    Scene scene;
    scene.lights = {point_lamp({0, 1, 0}, power)};
    add_rectangle(scene, grey(0), {-0.1, 0.55, -0.1}, {0.1, 0.55, 0.1});
    return scene;
}

}  // namespace

TEST_CASE("path mirrors: a wall shows the lamp's image", "[reference][analytic][mirrors]") {
    Scene scene = hidden_lamp();
    CHECK(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::all)).value == 0);
    add_rectangle(scene, mirror_of(0.75), {-1, -5, -5}, {-1, 5, 5});
    const double want = 0.75 * from({-2, 1, 0});
    check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::all)), want);
    // It was reflected once before it came here.
    CHECK(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::direct)).value == 0);
    check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::one_bounce)), want);
    check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::indirect)), want);
    PathParams exact = with(Mode::all);
    exact.rays = Rays::exact;
    check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, exact), want);
    PathParams none = with(Mode::indirect);
    none.max_bounces = 1;
    check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, none), want);

    // Each lamp has its image.
    Scene two = scene;
    two.lights.push_back(point_lamp({0.05, 1, 0.02}, 2 * power));
    check_equal(irradiance_at(two, {0, 0, 0}, {0, 1, 0}, with(Mode::all, 4096)), want + 2 * 0.75 * from({-2.05, 1, 0.02}));

    // What stands before the mirror hides the image, on either way.
    for (const double x : {-0.5, -0.75}) {
        Scene hidden = scene;
        const double y = x == -0.5 ? 0.25 : 0.625;  // of the way to the mirror's point (-1, 0.5, 0), and of that on from it
        add_rectangle(hidden, grey(0), {x, y - 0.05, -0.05}, {x, y + 0.05, 0.05});
        CHECK(irradiance_at(hidden, {0, 0, 0}, {0, 1, 0}, with(Mode::all)).value == 0);
    }
    // A mirror that ends before the point, or lies behind the lamp, shows nothing.
    Scene low = hidden_lamp(), behind = hidden_lamp();
    add_rectangle(low, mirror_of(0.75), {-1, -5, -5}, {-1, 0.45, 5});
    add_rectangle(behind, mirror_of(0.75), {-1, 1.5, -1}, {1, 1.5, 1});
    CHECK(irradiance_at(low, {0, 0, 0}, {0, 1, 0}, with(Mode::all)).value == 0);
    CHECK(irradiance_at(behind, {0, 0, 0}, {0, 1, 0}, with(Mode::all)).value == 0);
}

TEST_CASE("path mirrors: many triangles of a plane are one mirror, and each of a box's has its image", "[reference][analytic][mirrors]") {
    Scene scene = hidden_lamp();
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 8; ++k)
            add_rectangle(scene, mirror_of(0.5), {-1, i - 4.0, k - 4.0}, {-1, i - 3.0, k - 3.0});
    const auto made = prepare(scene, Rays::native);
    CHECK(made->mirrors.count == 1);
    CHECK_FALSE(made->mirrors.curved);
    check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::all)), 0.5 * from({-2, 1, 0}));

    // Mirrors that face away from each other by a right angle: the corner of x = -1 and z = -1.
    Scene corner = hidden_lamp();
    add_rectangle(corner, mirror_of(0.5), {-1, -9, -1}, {-1, 9, 9});
    add_rectangle(corner, mirror_of(0.25), {-1, -9, -1}, {9, 9, -1});
    CHECK(prepare(corner, Rays::native)->mirrors.count == 2);
    const double one = 0.5 * from({-2, 1, 0}) + 0.25 * from({0, 1, -2});
    check_equal(irradiance_at(corner, {0, 0, 0}, {0, 1, 0}, with(Mode::one_bounce, 4096)), one);
    // Twice mirrored it stands behind the edge: half of the ways end at one mirror, half at the other, to the same image.
    // From here and from the lamp the way to it meets the edge itself, so the point lies aside of the diagonal.
    const glm::dvec3 at(0.25, 0, 0);
    const double twice = 0.5 * 0.25 * from(glm::dvec3(-2, 1, -2) - at);
    const double all = 0.5 * from(glm::dvec3(-2, 1, 0) - at) + 0.25 * from(glm::dvec3(0, 1, -2) - at) + twice;
    Scene open = corner;
    check_equal(irradiance_at(open, at, {0, 1, 0}, with(Mode::indirect, 4096)), all);
}

TEST_CASE("path mirrors: two that face each other show images of images, four deep", "[reference][analytic][mirrors]") {
    Scene scene = hidden_lamp();
    add_rectangle(scene, mirror_of(0.5), {-1, -9, -9}, {-1, 9, 9});
    add_rectangle(scene, mirror_of(0.5), {1, -9, -9}, {1, 9, 9});
    double want = 0;
    for (int k = 1; k <= 4; ++k) want += 2 * std::pow(0.5, k) * from({2.0 * k, 1, 0});
    const Found got = irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, with(Mode::all, 4096));
    check_equal(got, want);
    for (int last = 1; last <= 5; ++last) {
        PathParams bounded = with(Mode::all, 4096);
        bounded.max_bounces = last;
        double part = 0;
        for (int k = 1; k <= std::min(last, 4); ++k) part += 2 * std::pow(0.5, k) * from({2.0 * k, 1, 0});
        CAPTURE(last);
        check_equal(irradiance_at(scene, {0, 0, 0}, {0, 1, 0}, bounded), part);
    }
}

TEST_CASE("path mirrors: a mirror on the floor throws the sun's patch, and a spot's cone", "[reference][analytic][mirrors]") {
    // The sun comes down at 45 degrees along +x and is thrown up again: under a plate at 1 m the mirror's patch lies 1 m on.
    Scene scene;
    Light sun;
    sun.type = LightType::directional, sun.intensity = glm::vec3(2);
    sun.direction = glm::vec3(float(std::sqrt(0.5)), -float(std::sqrt(0.5)), 0);
    scene.lights = {sun};
    add_rectangle(scene, mirror_of(0.5), {-0.25, 0, -0.25}, {0.25, 0, 0.25});
    add_rectangle(scene, grey(0), {0.5, 1, -1}, {2, 1, 1});
    const auto below = [&](double x) { return irradiance_at(scene, {x, 0.999, 0}, {0, -1, 0}, with(Mode::all)); };
    check_equal(below(1), 2 * 0.5 * std::sqrt(0.5));
    check_equal(below(1.2), 2 * 0.5 * std::sqrt(0.5));
    CHECK(below(1.3).value == 0);
    CHECK(below(0.7).value == 0);

    // A spot that looks at the mirror's middle: its image looks up from below. Where the cone's outer angle is passed, nothing.
    Light spot = point_lamp({-1, 1, 0}, power);
    spot.type = LightType::spot, spot.direction = sun.direction, spot.cone_inner_deg = 5, spot.cone_outer_deg = 10;
    scene.lights = {spot};
    const auto image = [&](double x) {
        const glm::dvec3 d = glm::dvec3(x, 0.999, 0) - glm::dvec3(-1, -1, 0);
        const double d2 = d.x * d.x + d.y * d.y, angle = std::atan2(d.y, d.x) - host::pi / 4;
        const double outer = std::cos(10 * host::pi / 180), inner = std::cos(5 * host::pi / 180);
        const double t = std::clamp((std::cos(angle) - outer) / (inner - outer), 0.0, 1.0);
        return 0.5 * t * t * (3 - 2 * t) * d.y / (d2 * std::sqrt(d2));
    };
    check_equal(below(1), image(1));
    check_equal(below(0.55), image(0.55));
    REQUIRE(image(0.55) < 0.9 * 0.5 * from({-1.55, 1.999, 0}));

    // A lamp that ends at its radius ends there by way of the mirror, too.
    spot.type = LightType::point, spot.radius = 3;
    scene.lights = {spot};
    const double d2 = 4 + 1.999 * 1.999;
    check_equal(below(1), 0.5 * (1 - d2 / 9) * 1.999 / std::sqrt(d2));
    scene.lights[0].radius = 2.8f;
    CHECK(below(1).value == 0);
}

TEST_CASE("path mirrors: a lamp in mirrors is a small emitter in them, for what is glossy, too", "[reference][mirrors]") {
    // The same rays find an emitter by running into it: another way to the same light.
    constexpr double radius = 0.2;
    Scene lamp;
    Material glossy = grey(0.3);
    glossy.specular = glm::vec3(0.5f), glossy.exponent = 5;
    add_rectangle(lamp, glossy, {-2, -0.5, -2}, {2, -0.5, 2});
    add_rectangle(lamp, mirror_of(0.8), {-2, -0.5, -2}, {-2, 2, 2});
    add_rectangle(lamp, mirror_of(0.6), {-2, -0.5, -2}, {2, 2, -2});
    add_rectangle(lamp, grey(0), {-0.3, 0.6, -0.3}, {0.3, 0.6, 0.3});
    Scene emitter = lamp;
    lamp.lights = {point_lamp({0, 1, 0}, power)};
    add_sphere(emitter, grey(0, power / (4 * host::pi * radius * radius)), {0, 1, 0}, radius, 3);
    const glm::dvec3 at(0.2, 0, 0.1), up(0, 1, 0);
    // Up to three reflections: mirrors, and the floor between mirrors.
    PathParams p = with(Mode::indirect, 8192);
    p.max_bounces = 3;
    PathParams many = p;
    many.samples = 1 << 20;
    const Found of_lamp = irradiance_at(lamp, at, up, p), of_emitter = irradiance_at(emitter, at, up, many);
    CAPTURE(of_lamp.value, of_lamp.error, of_emitter.value, of_emitter.error);
    CHECK(of_emitter.error < 0.02 * of_emitter.value);
    CHECK(of_lamp.error < 0.01 * of_lamp.value);
    // The emitter's extent changes the light by the order of (r/d)^2.
    CHECK(std::abs(of_lamp.value - of_emitter.value) < 4 * std::hypot(of_lamp.error, of_emitter.error) + 0.005 * of_lamp.value);
}

TEST_CASE("path mirrors: the same bits by every instruction set, and none changed without a mirror", "[reference][bits][mirrors]") {
    Scene scene = hidden_lamp();
    scene.lights.push_back(point_lamp({0.5, 1, 0.5}, 2));
    add_rectangle(scene, mirror_of(0.75), {-1, -1, -5}, {-1, 5, 5});
    add_rectangle(scene, mirror_of(0.5), {1, -1, -5}, {1, 5, 5});
    add_rectangle(scene, grey(0.5), {-1, 0, -5}, {1, 0, 5});
    scene.camera.position = {0, 0.4, 3}, scene.camera.look_at = {0, 0.3, 0};
    PathParams p = with(Mode::all, 64);
    p.rays = Rays::exact;
    const auto made = prepare(scene, p.rays);
    RunOptions first;
    first.isa = Isa::scalar, first.threads = 1;
    const Estimate want = trace(p, *made, scene.camera, {24, 16}, 3, first);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 2}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            const Estimate got = trace(p, *made, scene.camera, {24, 16}, 3, options);
            CHECK(got.rays == want.rays);
            CHECK(std::equal(&got.mean.texels[0].x, &got.mean.texels[0].x + 4 * got.mean.size(), &want.mean.texels[0].x));
        }
}

TEST_CASE("path mirrors: what is curved has no image, and says so", "[reference][mirrors]") {
    Scene scene = hidden_lamp();
    add_rectangle(scene, mirror_of(0.75), {-1, -5, -5}, {-1, 5, 5});
    CHECK_FALSE(prepare(scene, Rays::native)->mirrors.curved);
    Scene curved = scene;
    for (Vertex& v : curved.meshes.back().vertices) v.normal = glm::normalize(v.normal + glm::vec3(0, 1e-3f * v.position.y, 0));
    CHECK(prepare(curved, Rays::native)->mirrors.curved);
    CHECK(prepare(curved, Rays::native)->mirrors.count == 0);
    CHECK(lamp_light_unseen(scene, flatten(scene)).empty());
    REQUIRE(lamp_light_unseen(curved, flatten(curved)).size() == 1);
    CHECK(lamp_light_unseen(curved, flatten(curved))[0] == "light of lamps by way of mirrors that are curved or have a normal map");
    curved.lights[0].on = false;
    CHECK(lamp_light_unseen(curved, flatten(curved)).empty());
    Scene several = scene;
    add_rectangle(several, mirror_of(0.75), {1, -5, -5}, {1, 5, 5});
    REQUIRE(lamp_light_unseen(several, flatten(several)).size() == 1);
    CHECK(lamp_light_unseen(several, flatten(several))[0] == "light of lamps by way of more than 4 mirrors");
    scene.materials.back().normal_texture = 0;
    scene.textures.resize(1);
    scene.textures[0].texels = Image<std::uint32_t>(1, 1, 0xffff8080u);
    CHECK(prepare(scene, Rays::native)->mirrors.curved);
}
