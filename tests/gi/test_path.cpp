// The path tracer as an estimator: bits, modes, standard errors, refusals. Closed forms: test_closed_forms.cpp.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/frame/frame.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/reference.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

Material coloured(const glm::vec3& reflectance) {
    Material m = grey(0.5);
    m.reflectance = reflectance;
    return m;
}

// A room with a lamp of every kind, a textured wall, a glossy block and a mirror, open to a sky at the front.
Scene everything() {
    Scene scene;
    add_rectangle(scene, coloured({0.7f, 0.7f, 0.7f}), {-1, 0, -1}, {1, 0, 1});
    add_rectangle(scene, coloured({0.7f, 0.7f, 0.7f}), {-1, 2, -1}, {1, 2, 1});
    add_rectangle(scene, coloured({0.6f, 0.1f, 0.1f}), {-1, 0, -1}, {-1, 2, 1});
    add_rectangle(scene, coloured({0.1f, 0.6f, 0.1f}), {1, 0, -1}, {1, 2, 1});
    add_rectangle(scene, coloured({0.8f, 0.8f, 0.8f}), {-1, 0, -1}, {1, 2, -1});
    Texture checks;
    checks.texels = Image<std::uint32_t>(4, 4, 0xff4080c0u);
    for (int i = 0; i < 16; i += 3) checks.texels.texels[std::size_t(i)] = 0xffe0d010u;
    scene.textures.push_back(checks);
    scene.materials.back().texture = 0;
    add_rectangle(scene, grey(0.2f, 20), {-0.3, 1.98, -0.3}, {0.3, 1.98, 0.3});
    Material gloss = grey(0.3f);
    gloss.specular = glm::vec3(0.4f, 0.5f, 0.6f), gloss.exponent = 30;
    add_cube(scene, gloss, {-0.6, 0, -0.5}, {-0.1, 0.8, 0});
    Material mirror = grey(0.1f);
    mirror.mirror = glm::vec3(0.8f);
    add_cube(scene, mirror, {0.2, 0, -0.4}, {0.6, 0.5, 0.1});
    scene.lights.push_back(point_lamp({0.5, 1.5, 0.5}, 8));
    Light spot = point_lamp({-0.5, 1.5, 0.8}, 1);
    spot.type = LightType::spot, spot.intensity = glm::vec3(3), spot.direction = {0, -0.6f, -0.8f};
    Light sun = spot;
    sun.type = LightType::directional, sun.intensity = glm::vec3(1, 0.9f, 0.8f);
    scene.lights.insert(scene.lights.end(), {spot, sun});
    scene.environment.radiance = {0.3f, 0.4f, 0.5f};
    scene.camera.position = {0, 1, 3.5}, scene.camera.look_at = {0, 1, 0};
    scene.camera.fov_y_deg = 40;
    return scene;
}

// Points of the floor.
PointInputs floor_points(int width, int height, Image4& position, Image4& normal) {
    position = Image4(width, height);
    normal = Image4(width, height, glm::vec4(0, 1, 0, 0));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            position(x, y) = glm::vec4(1.8f * (x + 0.5f) / float(width) - 0.9f, 0,
                                       1.8f * (y + 0.5f) / float(height) - 0.9f, 0);
    return {&position, &normal};
}

Estimate frame_of(const Scene& scene, const PathParams& params, glm::ivec2 size, std::uint32_t seed = 1,
                  RunOptions options = {}) {
    return trace(params, *prepare(scene, params.rays), scene.camera, size, seed, options);
}

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

// The mean of the picture and the standard error of that mean: pixels are independent.
struct Mean {
    double value = 0, error = 0;
};
Mean mean_of(const Estimate& e) {
    Mean m;
    for (std::size_t i = 0; i < e.mean.size(); ++i)
        for (int c = 0; c < 3; ++c)
            m.value += e.mean.texels[i][c], m.error += double(e.error.texels[i][c]) * e.error.texels[i][c];
    const double n = 3.0 * double(e.mean.size());
    return {m.value / n, std::sqrt(m.error) / n};
}

PathParams with(Mode mode, int samples) {
    PathParams p;
    p.mode = mode, p.samples = samples;
    return p;
}

}  // namespace

TEST_CASE("path tracer: exact rays give the same bits by every instruction set and number of threads",
          "[reference][bits]") {
    const Scene scene = everything();
    PathParams params = with(Mode::all, 64);
    params.rays = Rays::exact, params.filter = reference::Filter::box;
    const auto prepared = prepare(scene, params.rays);
    Image4 position, normal;
    const PointInputs points = floor_points(21, 9, position, normal);
    Estimate picture, light, openness;
    PathParams ao = params;
    ao.mode = Mode::ambient_occlusion;
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            CAPTURE(isa_name(isa), threads);
            RunOptions options;
            options.isa = isa, options.threads = threads;
            const Estimate a = trace(params, *prepared, scene.camera, {37, 19}, 3, options);
            const Estimate b = trace_irradiance(params, *prepared, points, 3, options);
            const Estimate c = trace(ao, *prepared, scene.camera, {37, 19}, 3, options);
            if (picture.mean.empty()) picture = a, light = b, openness = c;
            REQUIRE(same(a.mean, picture.mean));
            REQUIRE(same(a.error, picture.error));
            REQUIRE(same(b.mean, light.mean));
            REQUIRE(same(b.error, light.error));
            REQUIRE(same(c.mean, openness.mean));
            REQUIRE(a.rays == picture.rays);
            REQUIRE(b.rays == light.rays);
        }
    CHECK(picture.nonfinite == 0);
    CHECK(mean_of(picture).value > 0.1);
    CHECK(mean_of(picture).error > 0);
}

TEST_CASE("path tracer: light is what is direct and what is not", "[reference]") {
    const Scene scene = everything();
    const auto prepared = prepare(scene, Rays::native);
    Image4 position, normal;
    const PointInputs points = floor_points(32, 32, position, normal);
    auto run = [&](Mode mode, int bounces) {
        PathParams p = with(mode, 256);
        p.max_bounces = bounces;
        return mean_of(trace_irradiance(p, *prepared, points, 1 + std::uint32_t(mode), {}));
    };
    const Mean all = run(Mode::all, 0), direct = run(Mode::direct, 0), indirect = run(Mode::indirect, 0),
               once = run(Mode::one_bounce, 0), up_to_once = run(Mode::all, 1);
    CHECK(all.error < 0.005 * all.value);
    CHECK(std::abs(direct.value + indirect.value - all.value) <
          4 * std::sqrt(direct.error * direct.error + indirect.error * indirect.error + all.error * all.error));
    CHECK(std::abs(direct.value + once.value - up_to_once.value) <
          4 * std::sqrt(direct.error * direct.error + once.error * once.error + up_to_once.error * up_to_once.error));
    CHECK(indirect.value > 1.2 * once.value);  // there is more than one bounce
}

TEST_CASE("path tracer: the standard error is honest", "[reference]") {
    // Of 200 independent runs the means spread by what each of them says, with one sample a round and with many.
    const Scene scene = everything();
    const auto prepared = prepare(scene, Rays::native);
    Image4 position, normal;
    const PointInputs points = floor_points(4, 2, position, normal);
    for (int samples : {16, 256}) {
        const int runs = 200;
        std::vector<glm::dvec3> sum(8, glm::dvec3(0)), squares(8, glm::dvec3(0)), said(8, glm::dvec3(0));
        for (int seed = 1; seed <= runs; ++seed) {
            const Estimate e = trace_irradiance(with(Mode::all, samples), *prepared, points, std::uint32_t(seed), {});
            REQUIRE(e.samples == samples);
            REQUIRE(e.rounds == 16);
            for (std::size_t i = 0; i < 8; ++i)
                for (int c = 0; c < 3; ++c) {
                    const double v = e.mean.texels[i][c], s = e.error.texels[i][c];
                    sum[i][c] += v, squares[i][c] += v * v, said[i][c] += s * s / runs;
                }
        }
        double ratio = 0;
        int lit = 0;
        for (std::size_t i = 0; i < 8; ++i)
            for (int c = 0; c < 3; ++c) {
                if (sum[i][c] == 0) continue;  // a point under a block
                const double mean = sum[i][c] / runs;
                ratio += (squares[i][c] / runs - mean * mean) * runs / (runs - 1) / said[i][c], ++lit;
            }
        REQUIRE(lit >= 18);
        ratio /= lit;
        // 8 points by 199 degrees of freedom each, channels not counted: the ratio's own error is 5 % for normal
        // values; the tails of paths widen it.
        CAPTURE(samples, ratio);
        CHECK(ratio > 0.8);
        CHECK(ratio < 1.25);
    }
}

TEST_CASE("path tracer: rounds of many samples are worth more than their number", "[reference]") {
    // Sobol's points: 16 rounds of 16 against 256 rounds of 1, equal numbers of paths.
    const Scene scene = everything();
    const auto prepared = prepare(scene, Rays::native);
    Image4 position, normal;
    const PointInputs points = floor_points(16, 16, position, normal);
    PathParams plain = with(Mode::direct, 16);
    const double one = trace_irradiance(plain, *prepared, points, 1, {}).relative_error;
    plain.samples = 256;
    const double many = trace_irradiance(plain, *prepared, points, 1, {}).relative_error;
    CHECK(many < 0.7 * one / 4);  // random numbers: one / 4
    // Four rounds of 64 lie more evenly still.
    plain.rounds = 4;
    const Estimate four = trace_irradiance(plain, *prepared, points, 1, {});
    CHECK(four.rounds == 4);
    CHECK(four.samples == 256);
    CHECK(four.relative_error < many);
}

TEST_CASE("path tracer: until_error stops when it is reached, and not before", "[reference]") {
    const Scene scene = everything();
    PathParams p = with(Mode::all, 1);
    p.until_error = 0.05f;
    const Estimate coarse = frame_of(scene, p, {24, 24});
    CHECK(coarse.relative_error <= 0.05);
    p.until_error = 0.02f;
    const Estimate fine = frame_of(scene, p, {24, 24});
    CHECK(fine.relative_error <= 0.02);
    CHECK(fine.samples > coarse.samples);
    CHECK(fine.samples % 128 == 0);
    p.until_error = 1e-6f, p.max_samples = 256;
    const Estimate given_up = frame_of(scene, p, {24, 24});
    CHECK(given_up.samples == 256);
    CHECK(given_up.relative_error > 1e-6);
}

TEST_CASE("path tracer: a mirror shows the lamp, without noise", "[reference][analytic]") {
    // The camera looks down at a mirror of 0.7 that shows a ceiling of exitance 3: 0.7 x 3 / pi.
    Scene scene;
    Material mirror = grey(0);
    mirror.mirror = glm::vec3(0.7f, 0.5f, 0.2f);
    add_rectangle(scene, mirror, {-5, 0, -5}, {5, 0, 5});
    add_rectangle(scene, grey(0, 3), {-50, 4, -50}, {50, 4, 50});
    scene.camera.position = {0, 2, 1}, scene.camera.look_at = {0, 0, 0};
    const Estimate e = frame_of(scene, with(Mode::all, 16), {8, 8});
    for (const glm::vec4& v : e.mean.texels) {
        CHECK(v.x == Approx(0.7 * 3 / host::pi).epsilon(1e-5));
        CHECK(v.z == Approx(0.2 * 3 / host::pi).epsilon(1e-5));
    }
    CHECK(e.relative_error < 1e-6);
    // The reflection is light that was reflected once: the mirror is the surface that is seen.
    CHECK(frame_of(scene, with(Mode::one_bounce, 16), {8, 8}).mean(4, 4).x == 0);
    CHECK(frame_of(scene, with(Mode::direct, 16), {8, 8}).mean(4, 4).x == e.mean(4, 4).x);
}

TEST_CASE("path tracer: direct light of lamps is the frame's", "[reference]") {
    // Lamps are points, so nothing is left to chance: what the rasterizer's shadow maps leave out or in is all that may
    // differ, along the edges of shadows.
    Scene scene = everything();
    scene.environment.radiance = glm::vec3(0);
    for (Material& m : scene.materials) m.emission = glm::vec3(0);
    scene.frame_size = {96, 96};
    scene.method = "direct";
    const frame::Settings settings = frame::settings_of(scene);
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        Scene one = scene;
        one.lights = {scene.lights[l]};
        const frame::Frame f = frame::execute(one, settings, frame::plan(one, settings), {});
        const auto prepared = prepare(one, Rays::native);
        const Estimate e = trace_irradiance(with(Mode::direct, 16), *prepared,
                                            {&f.gbuffer.position, &f.gbuffer.normal}, 1, {});
        CHECK(e.relative_error == 0);
        int off = 0, lit = 0;
        for (std::size_t i = 0; i < e.mean.size(); ++i) {
            const double got = e.mean.texels[i].x, want = f.direct.texels[i].x;
            lit += want > 0;
            off += !(std::abs(got - want) <= 1e-5 * want);
        }
        CAPTURE(l, off, lit);
        CHECK(lit > 1000);
        CHECK(off < 0.05 * lit);
    }
}

TEST_CASE("path tracer: what is not finite is counted, not hidden", "[reference]") {
    Scene scene;
    add_rectangle(scene, grey(0.5), {-1, 0, -1}, {1, 0, 1});
    add_rectangle(scene, grey(0, 1), {-1, 1, -1}, {1, 1, 1});
    scene.lights.push_back(point_lamp({0, 0.5, 0}, 1));
    scene.lights[0].intensity = glm::vec3(3e38f);
    Image4 position(4, 4, glm::vec4(0, 0, 0, 0)), normal(4, 4, glm::vec4(0, 1, 0, 0));
    const auto prepared = prepare(scene, Rays::native);
    const Estimate e = trace_irradiance(with(Mode::direct, 32), *prepared, {&position, &normal}, 1, {});
    CHECK(e.nonfinite > 0);

    // A point that is nowhere, and one whose normal is: not black, but not a number.
    scene.lights[0].intensity = glm::vec3(1);
    const auto sane = prepare(scene, Rays::native);
    position(1, 1).y = std::nanf(""), normal(2, 2).x = std::nanf("");
    for (Mode mode : {Mode::all, Mode::ambient_occlusion}) {
        const Estimate lost = trace_irradiance(with(mode, 32), *sane, {&position, &normal}, 1, {});
        CHECK(std::isnan(lost.mean(1, 1).y));
        CHECK(std::isfinite(lost.mean(0, 0).x));
        CHECK(lost.nonfinite > 0);
    }
    const Estimate turned = trace_irradiance(with(Mode::all, 32), *sane, {&position, &normal}, 1, {});
    CHECK(std::isnan(turned.mean(2, 2).x));
}

TEST_CASE("path tracer: a lamp in a closed room is found beside a sun that is stronger by far", "[reference]") {
    // The floor of a room of 4 m, lit by 10 W at 2 m above it; outside a ground of 1000 m under the sun.
    Scene scene;
    add_cube(scene, grey(0), {-2, 0, -2}, {2, 4, 2});
    add_rectangle(scene, grey(0), {-500, -1, -500}, {500, -1, 500});
    scene.lights.push_back(point_lamp({0, 2, 0}, 10));
    Light sun = point_lamp({0, 1, 0}, 1);
    sun.type = LightType::directional, sun.intensity = glm::vec3(1000);
    scene.lights.push_back(sun);
    Image4 position(8, 8, glm::vec4(0, 0, 0, 0)), normal(8, 8, glm::vec4(0, 1, 0, 0));
    PathParams p = with(Mode::direct, 64);
    const auto prepared = prepare(scene, p.rays);
    const Mean m = mean_of(trace_irradiance(p, *prepared, {&position, &normal}, 1, {}));
    const double expected = 10 / (4 * host::pi) / 4;
    CHECK(m.error < 0.03 * expected);
    CHECK(std::abs(m.value - expected) < 4 * m.error + 1e-6 * expected);

    // Where nothing was found yet, until_error does not stop.
    scene.lights[0].on = false;
    p.until_error = 0.1f, p.max_samples = 256;
    CHECK(trace_irradiance(p, *prepare(scene, p.rays), {&position, &normal}, 1, {}).samples == 256);
}

TEST_CASE("path tracer: a million equal samples have the mean of one", "[reference]") {
    // A float sum of so many was 0.5 % off, without a sign of it in the standard error.
    Scene scene;
    add_rectangle(scene, grey(0, 0.3f), {-50, -50, -1}, {50, 50, -1});
    scene.camera.position = {0, 0, 2}, scene.camera.look_at = {0, 0, 0};
    PathParams p = with(Mode::all, 1 << 20);
    p.rounds = 2;
    const Estimate e = frame_of(scene, p, {1, 1});
    CHECK(e.samples == 1 << 20);
    CHECK(e.mean(0, 0).x == Approx(0.3f / host::pi).epsilon(2e-7));
}

TEST_CASE("path tracer: bad input is refused by name", "[reference][errors]") {
    using Catch::Matchers::Contains;
    Scene scene = everything();
    scene.name = "room.toml";
    scene.materials[0].name = "chalk";
    scene.materials[0].reflectance = glm::vec3(0.9f);
    scene.materials[0].mirror = glm::vec3(0.05f, 0.2f, 0);
    CHECK_THROWS_WITH(prepare(scene, Rays::native), Contains("room.toml") && Contains("chalk") &&
                                                        Contains("channel G") && Contains("at most 1"));
    scene = everything();
    scene.materials[1].name = "soot", scene.materials[1].emission.y = std::nanf("");
    CHECK_THROWS_WITH(prepare(scene, Rays::native), Contains("soot") && Contains("emission"));
    scene = everything();
    scene.materials[1].exponent = -3;
    CHECK_THROWS_WITH(prepare(scene, Rays::native), Contains("exponent = -3"));
    scene = everything();
    scene.lights[1].name = "torch", scene.lights[1].intensity.x = std::nanf("");
    CHECK_THROWS_WITH(prepare(scene, Rays::native), Contains("torch") && Contains("intensity"));
    scene = everything();
    PathParams p;
    p.samples = 0;
    CHECK_THROWS_WITH(frame_of(scene, p, {4, 4}), Contains("samples"));
    p = {};
    p.until_error = -1;
    CHECK_THROWS_WITH(frame_of(scene, p, {4, 4}), Contains("until_error"));
    CHECK_THROWS_WITH(frame_of(scene, PathParams{}, {0, 4}), Contains("0 x 4"));
    const Image4 four(4, 4), five(5, 4);
    CHECK_THROWS_WITH(trace_irradiance({}, *prepare(scene, Rays::native), {&four, &five}, 1, {}), Contains("5 x 4"));
    CHECK_THROWS_WITH(trace_irradiance({}, *prepare(scene, Rays::native), {&four, nullptr}, 1, {}), Contains("bound"));
}

TEST_CASE("path tracer: an empty scene shows its environment and nothing else", "[reference]") {
    Scene scene;
    CHECK(frame_of(scene, with(Mode::all, 16), {5, 3}).mean(2, 1) == glm::vec4(0));
    scene.environment.radiance = {1, 2, 3};
    const Estimate e = frame_of(scene, with(Mode::all, 16), {5, 3});
    CHECK(e.mean(2, 1) == glm::vec4(1, 2, 3, 0));
    CHECK(e.relative_error == 0);
}
