// The lightmap atlas (IPR 3.2.1.1): what it may not do to the scene, how many texels a surface gets, and that charts keep apart.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/gi/atlas_checks.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test::atlas;

TEST_CASE("atlas: a square metre has as many texels as its density says", "[probes][IPR 3.2.1.1][analytic]") {
    for (const Mesh& mesh : {quad(1, 1), without_uv(quad(1, 1))}) {
        const Scene scene = scene_of({mesh});
        const Atlas a = atlas_of(scene, density(100));
        CHECK(a.size == glm::ivec2(10));
        CHECK(covered(drawn(a, scene)) == 100);
        CHECK(a.summary.used == Approx(1).epsilon(1e-6));
        // sqrt 80 = 8.94: nine rows and columns of centres lie within, the outer ones 0.47 texels from the edge.
        const Atlas b = atlas_of(scene, density(80));
        CHECK(b.size == glm::ivec2(9));
        CHECK(covered(drawn(b, scene)) == 81);
        CHECK(b.summary.used == Approx(80.0 / 81));
        double least = 9, most = 0;
        for (std::uint32_t v = 0; v < 4; ++v)
            least = std::min(least, in_texels(b, v).x), most = std::max(most, in_texels(b, v).x);
        CHECK(least == Approx((9 - std::sqrt(80.0)) / 2).margin(1e-5));
        CHECK(most == Approx((9 + std::sqrt(80.0)) / 2).margin(1e-5));
    }
    const Scene scene = scene_of({without_uv(quad(2.5f, 0.4f))});
    CHECK(covered(drawn(atlas_of(scene, density(100)), scene)) == 25 * 4);
}

TEST_CASE("atlas: a flat chart keeps its lengths, and the charts' area is that of the surface",
          "[probes][IPR 3.2.1.1][analytic]") {
    Mesh mesh = without_uv(box({1, 2, 3}));
    mesh.transform = glm::dmat4(glm::dvec4(0.36, 0.48, -0.8, 0), glm::dvec4(-0.8, 0.6, 0, 0),
                                glm::dvec4(0.48, 0.64, 0.6, 0), glm::dvec4(1, -2, 3, 1));  // turned and moved
    const Atlas a = atlas_of(mesh, density(400));
    CHECK(a.charts.size() == 6);
    double sum = 0;
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        const glm::uvec3 c = a.geometry.triangles[t];
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t p = c[k], q = c[(k + 1) % 3];
            const double length = glm::length(position(a.geometry, q) - position(a.geometry, p));
            CHECK(glm::length(in_texels(a, q) - in_texels(a, p)) == Approx(20 * length).epsilon(1e-5));
        }
        sum += texel_area(a, t);
    }
    CHECK(sum == Approx(400 * 22).epsilon(1e-5));
    CHECK(a.summary.used == Approx(400.0 * 22 / a.size.x / a.size.x).epsilon(1e-6));
    // Seen from the front no chart is mirrored: with v down, corners turn counter-clockwise.
    for (const glm::uvec3& c : a.geometry.triangles) {
        const glm::dvec2 e = in_texels(a, c.y) - in_texels(a, c.x), f = in_texels(a, c.z) - in_texels(a, c.x);
        CHECK(e.x * f.y - e.y * f.x < 0);
    }
}

TEST_CASE("atlas: curved charts have the density of flat ones on average", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {0, 0, 0}, 1, 20, 0);
    const Scene scene = scene_of({without_uv(mesh)});
    const Atlas a = atlas_of(scene, density(2000));
    check_atlas(scene, density(2000), a);
    std::vector<double> texels(a.charts.size()), metres(a.charts.size());
    double longest = 0;
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        if (a.chart[t] < 0) continue;
        texels[std::size_t(a.chart[t])] += texel_area(a, t), metres[std::size_t(a.chart[t])] += area(a.geometry, t);
        // At 60 degrees a texel covers two of its sides, before the chart as a whole is scaled up.
        longest = std::max(longest, area(a.geometry, t) * 2000 / texel_area(a, t));
    }
    for (std::size_t c = 0; c < a.charts.size(); ++c) CHECK(texels[c] == Approx(2000 * metres[c]).epsilon(1e-4));
    CHECK(longest < 2);
    CHECK(longest > 1);
}

TEST_CASE("atlas: own coordinates are scaled by the mean edge ratio, and stay as they are",
          "[probes][IPR 3.2.1.1][analytic]") {
    Mesh mesh = quad(2, 1);
    const float uv[4][2] = {{0.25f, 0.75f}, {0.75f, 0.75f}, {0.75f, 0.25f}, {0.25f, 0.25f}};
    for (std::size_t k = 0; k < 4; ++k) mesh.vertices[k].u = uv[k][0], mesh.vertices[k].v = uv[k][1];
    const Atlas a = atlas_of(mesh, density(10000));
    CHECK(a.summary.meshes_kept == 1);
    REQUIRE(a.charts.size() == 1);
    CHECK(a.charts[0].own_uv);
    const double texels = 100 * (2 * 4 + 2 * 2 + std::sqrt(10.0)) / 5;  // of a unit of the coordinates
    for (std::size_t k = 1; k < 4; ++k) {
        const glm::dvec2 step = in_texels(a, std::uint32_t(k)) - in_texels(a, 0);
        CHECK(step.x == Approx(texels * (double(uv[k][0]) - uv[0][0])).margin(1e-3));
        CHECK(step.y == Approx(texels * (double(uv[k][1]) - uv[0][1])).margin(1e-3));
    }
}

TEST_CASE("atlas: islands stay together where they are the gap apart, and are split where not",
          "[probes][IPR 3.2.1.1]") {
    // Two squares of a metre, whose coordinates are metres, `apart` metres from each other.
    auto pair_of = [](float apart) {
        Mesh mesh;
        test::add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
        test::add_quad(mesh, {5, 0, 0}, {6, 0, 0}, {5, 0, -1}, 0);
        for (std::size_t k = 4; k < 8; ++k) mesh.vertices[k].u += 1 + apart;
        return mesh;
    };
    for (const float apart : {0.0f, 0.2f, 0.3f, 0.4f, 0.5f, 10.0f}) {
        CAPTURE(apart);
        const Scene scene = scene_of({pair_of(apart)});
        const Atlas a = atlas_of(scene, density(100));
        check_atlas(scene, density(100), a);
        CHECK(a.summary.meshes_kept == 1);
        // 10 texels a metre, so three are 0.3 m. At 10 m apart a sixth of the rectangle is filled.
        const bool together = apart > 0.295f && apart < 9;
        CHECK(a.charts.size() == (together ? 1 : 2));
        CHECK(a.summary.layouts_split == (together ? 0 : 1));
        if (together) CHECK(in_texels(a, 4).x - in_texels(a, 0).x == Approx(10 * (1 + apart)).margin(1e-3));
    }
}

TEST_CASE("atlas: an island without a texel's centre is taken out of its layout", "[probes][IPR 3.2.1.1]") {
    // A square of 10 x 10 texels and one of a fifth of a texel beside it, on either side of a texel's centre.
    for (const float at : {1.53f, 1.56f}) {
        Mesh mesh;
        test::add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
        test::add_quad(mesh, {5, 0, 0}, {5.02f, 0, 0}, {5, 0, -0.02f}, 0);
        for (std::size_t k = 4; k < 8; ++k)
            mesh.vertices[k].u = at + 0.02f * mesh.vertices[k].u,
            mesh.vertices[k].v = 0.54f + 0.02f * mesh.vertices[k].v;
        const Scene scene = scene_of({mesh});
        const Atlas a = atlas_of(scene, density(100));
        check_atlas(scene, density(100), a);
        CHECK(a.summary.charts_without_texel == 0);
    }
}

TEST_CASE("atlas: smaller charts fill what a frame or a ring leaves", "[probes][IPR 3.2.1.1]") {
    // A ring of 32 corners, radii 2 m and 1.8 m, and squares of 0.1 m to 0.9 m.
    Mesh ring;
    for (int i = 0; i <= 32; ++i)
        for (const double r : {1.8, 2.0}) {
            const double turn = host::pi * (i % 32) / 16;
            ring.vertices.push_back({glm::vec3(r * host::cos(turn), 0, -r * host::sin(turn)), 0, {0, 1, 0}, 0});
        }
    for (unsigned i = 0; i < 64; i += 2) {
        ring.triangles.push_back({i, i + 1, i + 2}), ring.triangles.push_back({i + 2, i + 1, i + 3});
        ring.material.insert(ring.material.end(), 2, 0);
    }
    for (int gap : {0, 1, 3, 5}) {
        CAPTURE(gap);
        std::vector<Mesh> meshes{ring};
        for (int i = 0; i < 60; ++i)
            meshes.push_back(without_uv(quad(0.1f + 0.1f * float(i % 9), 0.1f + 0.05f * float(i % 7))));
        const Scene scene = scene_of(meshes);
        AtlasParams params = density(100);
        params.gap = gap;
        const Atlas a = atlas_of(scene, params);
        check_atlas(scene, params, a);
        const Chart& outer = a.charts[0];
        CHECK(outer.size == glm::ivec2(40));
        int inside = 0;
        for (std::size_t c = 1; c < a.charts.size(); ++c) {
            const glm::ivec2 at = a.charts[c].origin - outer.origin;
            inside += at.x > 0 && at.y > 0 && at.x < 40 && at.y < 40;
        }
        CHECK(inside >= 2);
    }
}

TEST_CASE("atlas: tangents go with their vertices", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {0, 0, 0}, 1, 10, 0);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) mesh.tangents.push_back({float(v), 1, 2, v % 2 ? 1 : -1});
    Scene scene = scene_of({without_uv(mesh)});
    scene.materials[0].normal_texture = 0;
    scene.textures.emplace_back().texels = Image<std::uint32_t>(1, 1, 0xffff8080u);
    const Atlas a = atlas_of(scene);
    CHECK(a.geometry.vertices.size() > mesh.vertices.size());
    REQUIRE_FALSE(a.geometry.tangents.empty());
    check_atlas(scene, {}, a);
}

TEST_CASE("atlas: small and thin charts hold the centre of a texel", "[probes][IPR 3.2.1.1]") {
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        // Triangles from a hundredth of a texel to some texels; a texel is 0.1 m.
        Mesh mesh;
        for (int i = 0; i < 60; ++i) {
            const float size = 0.001f * float(host::pow(600, double(dice.unit()))),
                        thin = dice.one_in(2) ? 1 : dice.between(0.02f, 0.2f);
            const glm::vec3 at = dice.in_box(glm::vec3(-1), glm::vec3(1)), d = dice.direction(), e = dice.direction();
            const unsigned first = unsigned(mesh.vertices.size());
            for (const glm::vec3& p : {at, at + d * size, at + d * (size * dice.unit()) + e * (size * thin)})
                mesh.vertices.push_back({p, 0, {0, 1, 0}, 0});
            mesh.triangles.push_back({first, first + 1, first + 2}), mesh.material.push_back(0);
        }
        const Scene scene = scene_of({mesh});
        const Atlas a = atlas_of(scene, density(100));
        check_atlas(scene, density(100), a);
        // Only where the inner circle is below 1/128 of a texel may one be without.
        int tiny = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            double around = 0;
            for (int k = 0; k < 3; ++k)
                around += glm::length(position(a.geometry, a.geometry.triangles[t][(k + 1) % 3]) -
                                      position(a.geometry, a.geometry.triangles[t][k]));
            tiny += 2 * area(a.geometry, t) / around * 10 < 1.001 / 128;
        }
        CHECK(a.summary.charts_without_texel <= tiny);
    }
}

TEST_CASE("atlas: fine meshes that are small as a whole have a texel", "[probes][IPR 3.2.1.1]") {
    // Balls of 2 mm to 6 cm at 80 receivers a square metre: triangles of a twentieth of a texel at most, charts of a
    // half.
    for (const float radius : {0.001f, 0.003f, 0.01f, 0.02f, 0.03f}) {
        CAPTURE(radius);
        Mesh mesh;
        test::add_ball(mesh, {0.3f, 0.2f, 0.1f}, radius, 20, 0);
        const Scene scene = scene_of({without_uv(mesh)});
        const Atlas a = atlas_of(scene);
        check_atlas(scene, {}, a);
        CHECK(a.charts.size() >= 4);
        if (radius == 0.03f) CHECK(a.summary.charts_without_texel == 0);
    }
}
