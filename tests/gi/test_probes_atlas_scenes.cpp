// The lightmap atlas of scenes of all sorts, sizes and units; what it refuses; its bits.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/content_hash.h"
#include "tests/gi/atlas_checks.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test::atlas;

TEST_CASE("atlas: holds for scenes of all sorts, gaps and sizes", "[probes][IPR 3.2.1.1]") {
    int cut = 0, kept = 0;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        Scene scene;
        test::add_materials(dice, scene);
        for (Material& m : scene.materials) m.alpha_cutoff = 0;  // holes are the receivers' concern
        test::add_meshes(dice, scene);
        if (flatten(scene).triangles.empty()) continue;
        if (dice.one_in(2)) scene.meshes[0] = without_uv(scene.meshes[0]);
        if (dice.one_in(3)) scene.meshes[0].tangents.assign(scene.meshes[0].vertices.size(), glm::vec4(1, 0, 0, 1));
        if (dice.one_in(3)) scene.materials[0].normal_texture = 0;
        AtlasParams params;
        params.gap = dice.below(6);
        params.receivers_per_m2 = dice.between(5, 100);
        if (dice.one_in(2)) params.size = 64 + dice.below(200);
        const Atlas a = atlas_of(scene, params);
        check_atlas(scene, params, a);
        cut += a.summary.meshes_cut, kept += a.summary.meshes_kept;
    }
    CHECK(cut > 10);
    CHECK(kept > 10);
}

TEST_CASE("atlas: a size is filled with the largest density that fits", "[probes][IPR 3.2.1.1][analytic]") {
    CHECK(atlas_of(quad(1, 1), side(100)).texels_per_m == Approx(100).epsilon(1e-6));
    // Six squares of a cube and two gaps of 3: 83 texels a side; the scale is found within 2^(1/256).
    const Atlas a = atlas_of(box({1, 1, 1}), side(256));
    CHECK(a.texels_per_m <= 83.01);
    CHECK(a.texels_per_m >= 83 * host::exp2(-1 / 256.0));
    // More texels, more density.
    double before = 0;
    for (int size : {32, 64, 128, 256, 512}) {
        const Scene scene = scene_of({box({1, 2, 3}), quad(4, 1)});
        const Atlas b = atlas_of(scene, side(size));
        check_atlas(scene, side(size), b);
        CHECK(b.texels_per_m > before);
        before = b.texels_per_m;
    }
}

TEST_CASE("atlas: any unit of length", "[probes][extreme]") {
    // 0.2 mm and 2000 km across: the same atlas, since all lengths are powers of two apart.
    const Atlas metre = atlas_of(scene_of({box({1, 0.5f, 0.25f}), quad(1, 1)}), side(128));
    for (const int exponent : {-12, 21}) {
        const float scale = std::ldexp(1.0f, exponent);
        const Scene scene = scene_of({box(scale * glm::vec3(1, 0.5f, 0.25f)), quad(scale, scale)});
        const Atlas a = atlas_of(scene, side(128));
        check_atlas(scene, side(128), a);
        CHECK(a.uv == metre.uv);
        CHECK(a.texels_per_m == Approx(metre.texels_per_m / scale).epsilon(1e-12));
    }
    // At the default density a scene of 0.2 mm has a texel a chart.
    const Scene small = scene_of({box(glm::vec3(2e-4f))});
    const Atlas a = atlas_of(small);
    check_atlas(small, {}, a);
    for (const Chart& chart : a.charts) CHECK(chart.size == glm::ivec2(1));
}

TEST_CASE("atlas: triangles without area have no texels and change nothing for others", "[probes][degenerate]") {
    const Scene plain = scene_of({box({1, 1, 1})});
    Scene with = plain;
    Mesh& mesh = with.meshes[0];
    mesh.triangles.insert(mesh.triangles.begin() + 3, {0, 0, 1});  // a line
    mesh.triangles.insert(mesh.triangles.begin(), {4, 4, 4});      // a point
    mesh.triangles.push_back({1, 1, 6});                           // a line
    mesh.material.assign(mesh.triangles.size(), 0);
    with.meshes.emplace_back();  // nothing but a point
    with.meshes[1].vertices.assign(3, with.meshes[0].vertices[0]);
    with.meshes[1].triangles = {{0, 1, 2}}, with.meshes[1].material = {0};
    const Atlas a = atlas_of(with, density(80)), b = atlas_of(plain, density(80));
    check_atlas(with, density(80), a);
    CHECK(a.size == b.size);
    CHECK(a.charts.size() == b.charts.size());
    std::int64_t none = 0;
    for (std::size_t t = 0; t < a.chart.size(); ++t) none += a.chart[t] < 0;
    CHECK(a.summary.triangles_without_area == none);
    CHECK(none >= 3);
    CHECK(covered(drawn(a, with)) == covered(drawn(b, plain)));
    // Its place is that of a neighbour, so that a ray which hits it finds light from there.
    CHECK(a.uv[a.geometry.triangles[0].x] == b.uv[b.geometry.triangles[2].x]);
}

TEST_CASE("atlas: refuses what it cannot do, in one line that says why", "[probes][input]") {
    const Scene one = scene_of({quad(1, 1)});
    CHECK(refusal(Scene{}, {}) == "atlas: scene: no surfaces: expected a triangle that has an area");
    Mesh line;
    line.vertices.assign(3, {{1, 2, 3}, 0, {0, 1, 0}, 0});
    line.triangles = {{0, 1, 2}}, line.material = {0};
    CHECK(refusal(scene_of({line}), {}) == "atlas: scene: no surfaces: expected a triangle that has an area");
    CHECK_THAT(refusal(scene_of({quad(2e6f, 2e6f)}), {}),
               Catch::Contains("4e+12 m2 of surfaces with 80 receivers a m2: expected what fits"));
    AtlasParams low;
    low.max_size = 8;
    CHECK_THAT(refusal(one, low), Catch::Contains("8 x 8 texels"));
    low.max_size = 9;
    CHECK(refusal(one, low).empty());
    // Six charts of one texel and the gaps between them take 9 x 5 texels at least.
    CHECK(refusal(scene_of({box({1, 1, 1})}), side(8)) ==
          "atlas: a lightmap of 8 x 8 texels: expected room for 6 charts and 3 texels between any two");
    CHECK(refusal(scene_of({box({1, 1, 1})}), side(9)).empty());

    for (double bad : {0.0, -1.0, HUGE_VAL, double(std::nanf(""))})
        CHECK_THAT(refusal(one, density(bad)), Catch::Contains("receivers_per_m2 = "));
    AtlasParams p;
    p.gap = -1;
    CHECK_THAT(refusal(one, p), Catch::Contains("gap = -1: expected 0 to 64"));
    p = {}, p.size = -1;
    CHECK_THAT(refusal(one, p), Catch::Contains("size = -1: expected 0 to 16384"));
    p = {}, p.max_size = 16385;
    CHECK_THAT(refusal(one, p), Catch::Contains("max_size = 16385: expected 1 to 16384"));
    for (double bad : {0.0, 81.0, double(std::nanf(""))}) {
        p = {}, p.chart_angle_deg = bad;
        CHECK_THAT(refusal(one, p), Catch::Contains("chart_angle_deg = "));
    }
}

TEST_CASE("atlas: twice the same, and a mesh's charts do not depend on its neighbours", "[probes][bits]") {
    Mesh ball;
    test::add_ball(ball, {0, 0, 0}, 1, 12, 0);
    const Scene scene = scene_of({without_uv(ball), box({1, 2, 3}), quad(2, 2), without_uv(ball)});
    const Atlas a = atlas_of(scene), b = atlas_of(scene);
    CHECK(a.uv == b.uv);
    CHECK(a.chart == b.chart);
    // The first and the last mesh are equal, so are their charts.
    const std::size_t n = ball.triangles.size(), last = a.chart.size() - n;
    std::int32_t offset = 0;
    for (std::size_t t = 0; t < n; ++t)
        if (a.chart[t] == 0) offset = a.chart[last + t];
    int differ = 0;
    for (std::size_t t = 0; t < n; ++t) differ += a.chart[last + t] != (a.chart[t] < 0 ? -1 : a.chart[t] + offset);
    CHECK(offset > 0);
    CHECK(differ == 0);
}

TEST_CASE("atlas: the same bits from every compiler", "[probes][bits]") {
    // Written by GCC 12 without optimisation; with -O2, with -O3 for AVX2 and FMA, and by clang they are the same.
    Mesh ball;
    test::add_ball(ball, {0.1f, 0.2f, 0.3f}, 1, 24, 0);
    const Scene scene = scene_of({without_uv(ball), box({1, 2, 3}), quad(2, 1.7f), ball});
    for (const auto& [params, expected] :
         {std::pair(density(80), "578739ef58b05961"), std::pair(side(200), "72f11dea64ec9bc1")}) {
        const Atlas a = atlas_of(scene, params);
        std::uint64_t hash = content_hash(a.uv.data(), a.uv.size() * sizeof(glm::vec2));
        hash = content_hash(a.chart.data(), a.chart.size() * sizeof(std::int32_t), hash);
        CHECK(hash_text(hash) == expected);
    }
}
