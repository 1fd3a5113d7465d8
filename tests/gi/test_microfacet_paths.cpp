// Microfacets in the path tracer: rooms whose light is known, bits, refusals.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/microfacet_tables.h"
#include "gi/reference/reference.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

Material rough(const glm::vec3& base, float metalness, float roughness, double emission = 0) {
    Material m = grey(0, emission);
    m.reflectance = base;
    m.microfacet = true, m.metalness = metalness, m.roughness = roughness;
    return m;
}

PathParams with(int samples, Microfacets microfacets = Microfacets::multiple) {
    PathParams p;
    p.samples = samples, p.microfacets = microfacets, p.filter = reference::Filter::box;
    return p;
}

Estimate seen(const Scene& scene, const PathParams& params, glm::ivec2 size, RunOptions options = {}) {
    return trace(params, *prepare(scene, params.rays), scene.camera, size, 1, options);
}

struct Mean {
    double value = 0, error = 0;
};
Mean mean_of(const Estimate& e, int channel = 0) {
    Mean m;
    for (std::size_t i = 0; i < e.mean.size(); ++i)
        m.value += e.mean.texels[i][channel], m.error += double(e.error.texels[i][channel]) * e.error.texels[i][channel];
    return {m.value / double(e.mean.size()), std::sqrt(m.error) / double(e.mean.size())};
}

void look(Scene& scene, const glm::dvec3& eye, const glm::dvec3& at, double fov) {
    scene.camera.position = eye, scene.camera.look_at = at, scene.camera.fov_y_deg = fov;
    if (glm::length(glm::cross(at - eye, glm::dvec3(0, 1, 0))) < 1e-6) scene.camera.up = {0, 0, -1};
}

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

// A room of all materials at once, with a lamp that emits and one that is a point, and a texture of both numbers.
Scene everything() {
    Scene scene;
    add_rectangle(scene, rough({0.7f, 0.7f, 0.7f}, 0, 0.6f), {-1, 0, -1}, {1, 0, 1});
    add_rectangle(scene, grey(0.7), {-1, 2, -1}, {1, 2, 1});
    add_rectangle(scene, rough({1, 0.766f, 0.336f}, 1, 0.4f), {-1, 0, -1}, {-1, 2, 1});
    add_rectangle(scene, rough({0.1f, 0.6f, 0.1f}, 0.5f, 0), {1, 0, -1}, {1, 2, 1});
    Texture texture;
    texture.srgb = false;
    texture.texels = Image<std::uint32_t>(4, 4, 0xff204060u);
    for (int i = 0; i < 16; i += 3) texture.texels.texels[std::size_t(i)] = 0xffe0a010u;
    scene.textures.push_back(texture);
    add_rectangle(scene, rough({0.8f, 0.8f, 0.8f}, 1, 1), {-1, 0, -1}, {1, 2, -1});
    scene.materials.back().surface_texture = 0;
    add_rectangle(scene, grey(0.2f, 20), {-0.3, 1.98, -0.3}, {0.3, 1.98, 0.3});
    Material mirror = grey(0.1f);
    mirror.mirror = glm::vec3(0.8f);
    add_cube(scene, mirror, {0.2, 0, -0.4}, {0.6, 0.5, 0.1});
    scene.lights.push_back(point_lamp({0.5, 1.5, 0.5}, 8));
    scene.environment.radiance = {0.3f, 0.4f, 0.5f};
    look(scene, {0, 1, 3.5}, {0, 1, 0}, 40);
    return scene;
}

}  // namespace

TEST_CASE("microfacets: a white thing in a furnace is not seen", "[reference][microfacet][furnace]") {
    // Walls of reflectance rho and exitance M around it send M/pi/(1 - rho) from everywhere: what reflects all of it does so, too.
    const double rho = 0.5, expected = 1 / host::pi / (1 - rho);
    for (const auto& [metalness, roughness] : {std::pair{1.f, 1.f}, {1.f, 0.5f}, {1.f, 0.1f}, {1.f, 0.f}, {0.f, 1.f}, {0.f, 0.3f}, {0.f, 0.f}}) {
        CAPTURE(metalness, roughness);
        Scene scene;
        add_cube(scene, grey(rho, 1), {-2, -2, -2}, {2, 2, 2});
        add_sphere(scene, rough(glm::vec3(1), metalness, roughness), {0, 0, 0}, 0.8, 3);
        look(scene, {0, 0, 1.9}, {0, 0, 0}, 40);
        const Mean m = mean_of(seen(scene, with(256), {16, 16}));
        CAPTURE(m.value / expected - 1, m.error / expected);
        CHECK(std::abs(m.value - expected) <= 0.0015 * expected + 4 * m.error);
        CHECK(m.error < 0.004 * expected);
    }
}

TEST_CASE("microfacets: a room of rough metal adds as much with every reflection", "[reference][microfacet][furnace]") {
    // All walls emit M and reflect all: of light that was reflected B times before it came to what is seen, and there once
    // more, (B + 2) M/pi is sent.
    const int bounces = 6;
    for (const float roughness : {1.0f, 0.4f, 0.15f}) {
        CAPTURE(roughness);
        Scene scene;
        add_cube(scene, rough(glm::vec3(1), 1, roughness, 1), {-1, -1, -1}, {1, 1, 1});
        look(scene, {0.1, 0.2, 0.3}, {0.4, -0.5, -1}, 60);
        PathParams params = with(256);
        params.max_bounces = bounces;
        const Mean multiple = mean_of(seen(scene, params, {12, 12}));
        const double expected = (bounces + 2) / host::pi;
        CAPTURE(multiple.value / expected - 1, multiple.error / expected);
        CHECK(std::abs(multiple.value - expected) <= 0.003 * expected + 4 * multiple.error);
        params.microfacets = Microfacets::single;
        const Mean single = mean_of(seen(scene, params, {12, 12}));
        CHECK(single.value < multiple.value - 10 * multiple.error - (roughness > 0.3f ? 0.05 * expected : 0));
    }
}

TEST_CASE("microfacets: a ball of white metal vanishes before a uniform sky; of single reflection it is dark", "[reference][microfacet][furnace]") {
    for (const float roughness : {1.0f, 0.6f, 0.2f}) {
        CAPTURE(roughness);
        Scene scene;
        add_sphere(scene, rough(glm::vec3(1), 1, roughness), {0, 0, 0}, 1, 4);
        scene.environment.radiance = glm::vec3(0.7f);
        look(scene, {0, 0, 6}, {0, 0, 0}, 22);
        const Mean m = mean_of(seen(scene, with(256), {16, 16}));
        CAPTURE(m.value / 0.7 - 1, m.error);
        CHECK(std::abs(m.value - 0.7) <= 0.001 * 0.7 + 4 * m.error);
        CHECK(m.error < 0.003);
    }
    // Seen from above: E of alpha = 1 is 1 - ln 2 (test_microfacet.cpp), of both forms of G.
    Scene plate;
    add_rectangle(plate, rough(glm::vec3(1), 1, 1), {-1, 0, -1}, {1, 0, 1});
    plate.environment.radiance = glm::vec3(1);
    look(plate, {0, 500, 0}, {0, 0, 0}, 0.1);
    const Mean m = mean_of(seen(plate, with(1024, Microfacets::single), {16, 16}));
    CHECK(std::abs(m.value - (1 - host::log(2))) <= 0.0005 + 4 * m.error);
    CHECK(m.error < 0.002);
}

TEST_CASE("microfacets: a smooth metal shows what a perfect mirror shows", "[reference][microfacet]") {
    // An emitting square above, its image below: F0 at the angle of sight, k M/pi of a mirror.
    auto scene_of = [](const Material& floor) {
        Scene scene;
        add_rectangle(scene, floor, {-2, 0, -2}, {2, 0, 2});
        add_rectangle(scene, grey(0, host::pi), {-1, 1, -1}, {1, 1, 1});
        look(scene, {0, 0.5, 1.6}, {0, 0, 0.9}, 8);
        return scene;
    };
    Material mirror = grey(0);
    mirror.mirror = glm::vec3(1);
    const Estimate a = seen(scene_of(mirror), with(64), {8, 8}), b = seen(scene_of(rough(glm::vec3(1), 1, 0)), with(256), {8, 8});
    for (std::size_t i = 0; i < a.mean.size(); ++i) {
        CHECK(a.mean.texels[i].x == Approx(1).epsilon(1e-5));
        CHECK(std::abs(b.mean.texels[i].x - 1) <= 1e-3 + 5 * b.error.texels[i].x);
        CHECK(b.error.texels[i].x < 0.01);
    }
}

TEST_CASE("microfacets: exact rays give the same bits by every instruction set and number of threads", "[reference][microfacet][bits]") {
    const Scene scene = everything();
    for (const Microfacets kind : {Microfacets::multiple, Microfacets::single}) {
        PathParams params = with(32, kind);
        params.rays = Rays::exact;
        const auto prepared = prepare(scene, params.rays);
        Estimate first;
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 3}) {
                CAPTURE(isa_name(isa), threads, int(kind));
                RunOptions options;
                options.isa = isa, options.threads = threads;
                const Estimate e = trace(params, *prepared, scene.camera, {37, 19}, 3, options);
                if (first.mean.empty()) first = e;
                CHECK(same(e.mean, first.mean));
                CHECK(same(e.error, first.error));
                CHECK(e.nonfinite == 0);
            }
        CHECK(mean_of(first).value > 0.1);
    }
}

TEST_CASE("microfacets: a texture scales roughness by its green and metalness by its blue", "[reference][microfacet]") {
    auto picture = [](float metalness, float roughness, std::uint32_t texel) {
        Scene scene = everything();
        Material& m = scene.materials[4];
        m.metalness = metalness, m.roughness = roughness;
        m.surface_texture = texel == 0 ? -1 : 0;
        if (texel) scene.textures[0].texels = Image<std::uint32_t>(2, 2, texel);
        PathParams params = with(16);
        params.rays = Rays::exact;
        return seen(scene, params, {24, 24});
    };
    // 0x33 is a fifth of 0xff; red does not count.
    const Estimate plain = picture(0.2f, 1.0f / 5, 0), textured = picture(1, 1, 0xff333377u);
    CHECK(same(plain.mean, textured.mean));
    CHECK(same(plain.mean, picture(1, 1, 0xff3333ffu).mean));
    CHECK(!same(plain.mean, picture(1, 1, 0xff337777u).mean));
    CHECK(!same(plain.mean, picture(1, 1, 0xff773377u).mean));
}

TEST_CASE("microfacets: points of a scene with them are white and diffuse, their neighbours are not", "[reference][microfacet]") {
    // Under an open sky, beside a wall of white metal that mirrors it, a point gets all the sky has.
    Scene scene;
    add_rectangle(scene, rough(glm::vec3(1), 1, 0.7f), {0, 0, -50}, {0, 100, 50});
    scene.environment.radiance = glm::vec3(1);
    Image4 position(4, 1, glm::vec4(0.5f, 0.01f, 0, 0)), normal(4, 1, glm::vec4(0, 1, 0, 0));
    PathParams params = with(4096);
    const Estimate e = trace_irradiance(params, *prepare(scene, params.rays), {&position, &normal}, 1, {});
    const Mean m = mean_of(e);
    CAPTURE(m.value, m.error);
    CHECK(std::abs(m.value - host::pi) <= 0.002 * host::pi + 4 * m.error);
}

TEST_CASE("microfacets: what no surface is like is refused by name", "[reference][microfacet][refusals]") {
    auto refused = [](auto change) {
        Scene scene = everything();
        change(scene.materials[0]);
        prepare(scene, Rays::native);
    };
    CHECK_THROWS_WITH(refused([](Material& m) { m.roughness = 1.5f; }), Catch::Contains("roughness = 1.5: expected 0 to 1"));
    CHECK_THROWS_WITH(refused([](Material& m) { m.metalness = std::nanf(""); }), Catch::Contains("metalness"));
    CHECK_THROWS_WITH(refused([](Material& m) { m.mirror = glm::vec3(0.1f); }), Catch::Contains("beside microfacets"));
    CHECK_THROWS_WITH(refused([](Material& m) { m.surface_texture = 7; }), Catch::Contains("surface_texture = 7"));
}
