// Irradiance at receivers by path tracing: closed forms, receiver by receiver, and what its standard error promises.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/receiver_irradiance.h"
#include "random_scene.h"

namespace {

using namespace plumb;
using namespace plumb::probes;
using reference::Mode;
using reference::PathParams;

Scene scene_of(Mesh mesh) {
    Scene scene;
    scene.materials.resize(1);
    mesh.material.resize(mesh.triangles.size(), 0);
    scene.meshes = {std::move(mesh)};
    return scene;
}

// A closed room of 4 m, fronts inwards.
Scene room(float rho, float exitance) {
    Mesh mesh;
    test::add_box(mesh, glm::vec3(-2), glm::vec3(2), 0, true);
    Scene scene = scene_of(mesh);
    scene.materials[0].reflectance = glm::vec3(rho);
    scene.materials[0].emission = glm::vec3(exitance);
    return scene;
}

// A square floor of 4 m at y = 0, facing up.
Scene black_floor() {
    Mesh mesh;
    test::add_quad(mesh, {-2, 0, 2}, {2, 0, 2}, {-2, 0, -2}, 0);
    Scene scene = scene_of(mesh);
    scene.materials[0].reflectance = glm::vec3(0);
    return scene;
}

Receivers receivers_of(const Scene& scene, double per_m2) {
    AtlasParams params;
    params.receivers_per_m2 = per_m2;
    const Atlas atlas = make_atlas(scene, flatten(scene), params);
    return place_receivers(atlas, raster::prepare(scene, atlas.geometry), {});
}

PathParams with(Mode mode, int samples) {
    PathParams p;
    p.mode = mode, p.samples = samples, p.rays = Rays::exact;
    return p;
}

ReceiverIrradiance traced(const Scene& scene, const Receivers& r, const PathParams& p, std::uint32_t seed = 1) {
    return receiver_irradiance(r, *reference::prepare(scene, p.rays), p, seed, {});
}

// How many first channels lie within `sigmas` of their standard error of `expected`, and what they are together.
struct Cover {
    int within = 0, count = 0;
    double mean = 0, mean_error = 0;
    double share() const { return double(within) / count; }
};
Cover cover(const ReceiverIrradiance& e, double expected, double sigmas) {
    Cover c;
    double variance = 0;
    for (std::size_t i = 0; i < e.mean.size(); ++i) {
        const double error = double(e.error[i].x);
        c.within += std::fabs(double(e.mean[i].x) - expected) <= sigmas * error;
        ++c.count, c.mean += double(e.mean[i].x), variance += error * error;
    }
    c.mean /= c.count, c.mean_error = std::sqrt(variance) / c.count;
    return c;
}

}  // namespace

TEST_CASE("receivers traced: in a furnace E is M / (1 - rho) everywhere, of which indirect rho M / (1 - rho)",
          "[probes][reference][analytic][furnace]") {
    // All walls emit M = 3 and reflect rho = 0.6: whatever a ray of any receiver meets has the same radiosity.
    const double m = 3, rho = 0.6;
    const Scene scene = room(float(rho), float(m));
    const Receivers r = receivers_of(scene, 20);
    REQUIRE(r.count() > 1500);
    struct Case {
        Mode mode;
        double expected;
    };
    const Case cases[] = {{Mode::direct, m}, {Mode::indirect, m * rho / (1 - rho)}, {Mode::all, m / (1 - rho)}, {Mode::one_bounce, m * rho}};
    for (const auto& [mode, expected] : cases) {
        const ReceiverIrradiance e = traced(scene, r, with(mode, 256));
        REQUIRE(e.mean.size() == std::size_t(r.count()));
        CHECK(e.samples == 256);
        CHECK(e.rounds == 16);
        CHECK(e.nonfinite == 0);
        // Student's t of 15 degrees of freedom: 5 % lie beyond 2.131, 0.9 % beyond 3.
        const Cover two = cover(e, expected, 2.131), three = cover(e, expected, 3);
        CAPTURE(int(mode), expected, two.mean, two.mean_error, two.share(), three.share());
        CHECK(std::fabs(two.mean - expected) < 4 * two.mean_error);
        CHECK(two.mean_error < 1e-3 * expected);
        CHECK(two.share() > 0.93);
        CHECK(two.share() < 0.97);
        CHECK(three.share() > 0.98);
        CHECK(three.share() < 0.998);
    }
}

TEST_CASE("receivers traced: under a uniform sky E is pi L", "[probes][reference][analytic]") {
    Scene scene = black_floor();
    scene.environment.radiance = {2, 1, 0.5f};
    const Receivers r = receivers_of(scene, 20);
    const ReceiverIrradiance e = traced(scene, r, with(Mode::all, 256));
    const Cover c = cover(e, 2 * host::pi, 4);
    CAPTURE(c.mean, c.mean_error);
    CHECK(std::fabs(c.mean - 2 * host::pi) < 4 * c.mean_error);
    CHECK(c.mean_error < 1e-3 * 2 * host::pi);
    CHECK(c.share() > 0.99);
    for (const glm::vec4& v : e.mean) {
        REQUIRE(v.y == Approx(v.x / 2).epsilon(1e-5));
        REQUIRE(v.z == Approx(v.x / 4).epsilon(1e-5));
        REQUIRE(v.w == 0);
    }
    // A sky that nothing reflects is never indirect.
    for (const glm::vec4& v : traced(scene, r, with(Mode::indirect, 16)).mean) REQUIRE(v == glm::vec4(0));
}

TEST_CASE("receivers traced: of a single lamp E is I cos / d^2 at each receiver, without noise", "[probes][reference][analytic]") {
    Scene scene = black_floor();
    const glm::dvec3 lamp(0.5, 1.5, -0.25);
    Light light;
    light.type = LightType::point;
    light.position = glm::vec3(lamp), light.intensity = {7, 5, 3};
    scene.lights = {light};
    const Receivers r = receivers_of(scene, 30);
    const auto expected = [&](int i) {
        const glm::dvec3 to = lamp - glm::dvec3(r.position[std::size_t(i)]);
        const double d2 = glm::dot(to, to);
        return to.y / std::sqrt(d2) / d2;  // cos / d^2
    };
    const ReceiverIrradiance point = traced(scene, r, with(Mode::direct, 4));
    CHECK(point.relative_error == 0);
    for (int i = 0; i < r.count(); ++i)
        for (int c = 0; c < 3; ++c) {
            REQUIRE(point.error[std::size_t(i)][c] == 0);
            REQUIRE(point.mean[std::size_t(i)][c] == Approx(double(light.intensity[c]) * expected(i)).epsilon(1e-5));
        }
    // A spot straight down: the same within its inner cone, nothing outside of its outer one.
    scene.lights[0].type = LightType::spot;
    scene.lights[0].cone_inner_deg = 30, scene.lights[0].cone_outer_deg = 40;
    const ReceiverIrradiance spot = traced(scene, r, with(Mode::all, 4));
    int inner = 0, outer = 0;
    for (int i = 0; i < r.count(); ++i) {
        const glm::dvec3 to = lamp - glm::dvec3(r.position[std::size_t(i)]);
        const double cosine = to.y / std::sqrt(glm::dot(to, to));
        const bool in_cone = cosine > host::cos(29.9 * host::pi / 180), beyond = cosine < host::cos(40.1 * host::pi / 180);
        inner += in_cone, outer += beyond;
        if (in_cone) REQUIRE(spot.mean[std::size_t(i)].x == Approx(7 * expected(i)).epsilon(1e-5));
        if (beyond) REQUIRE(spot.mean[std::size_t(i)].x == 0);
    }
    CHECK(inner > 20);
    CHECK(outer > 20);
}

TEST_CASE("receivers traced: the standard error falls as the root of the paths", "[probes][reference]") {
    const Scene scene = room(0.5f, 1);
    const Receivers r = receivers_of(scene, 6);
    // Rounds of 16 paths each, so that what falls is chance alone.
    PathParams few = with(Mode::indirect, 256), many = with(Mode::indirect, 4096);
    few.rounds = 16, many.rounds = 256;
    const double a = traced(scene, r, few).relative_error, b = traced(scene, r, many).relative_error;
    CHECK(a / b == Approx(4).epsilon(0.05));  // of sqrt(16); 1.5 % is what 600 receivers of 15 degrees of freedom spread by
}

TEST_CASE("receivers traced: until_error goes on until it is reached", "[probes][reference]") {
    const Scene scene = room(0.5f, 1);
    const Receivers r = receivers_of(scene, 1);
    PathParams p = with(Mode::indirect, 1);
    p.until_error = 0.02f;
    const ReceiverIrradiance coarse = traced(scene, r, p);
    p.until_error = 0.005f;
    const ReceiverIrradiance fine = traced(scene, r, p);
    CHECK(coarse.relative_error <= 0.0205);  // a row may end with points that are none: they count as certain
    CHECK(fine.relative_error <= 0.00513);
    CHECK(fine.samples > coarse.samples);
}

TEST_CASE("receivers traced: the same bits by every instruction set and number of threads", "[probes][reference][bits]") {
    Scene scene = room(0.5f, 0.2f);
    scene.lights.resize(1);
    scene.lights[0].type = LightType::point, scene.lights[0].position = {1, 0.5f, -1};
    const Receivers r = receivers_of(scene, 7);
    REQUIRE(r.count() % 64 != 0);
    const PathParams p = with(Mode::all, 32);
    const auto prepared = reference::prepare(scene, Rays::exact);
    const ReceiverIrradiance first = receiver_irradiance(r, *prepared, p, 9, {});
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            const ReceiverIrradiance e = receiver_irradiance(r, *prepared, p, 9, options);
            REQUIRE(std::memcmp(e.mean.data(), first.mean.data(), e.mean.size() * sizeof(glm::vec4)) == 0);
            REQUIRE(std::memcmp(e.error.data(), first.error.data(), e.error.size() * sizeof(glm::vec4)) == 0);
        }
    // Another seed, other numbers.
    CHECK(receiver_irradiance(r, *prepared, p, 10, {}).mean[0] != first.mean[0]);
}

TEST_CASE("receivers traced: what is no irradiance and what is no receiver are refused", "[probes][reference]") {
    const Scene scene = room(0.5f, 1);
    const Receivers r = receivers_of(scene, 1);
    CHECK_THROWS_WITH(traced(scene, r, with(Mode::ambient_occlusion, 4)), Catch::Matchers::Contains("ambient_occlusion"));
    CHECK_THROWS_WITH(traced(scene, Receivers{}, with(Mode::all, 4)), Catch::Matchers::Contains("none"));
    CHECK_THROWS_AS(traced(scene, r, with(Mode::all, 0)), InputError);
}
