// The run time's first two stages from data textures: radiance and lambda of a bake that was written and read back, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/error.h"
#include "core/sh.h"
#include "gi/probes/directions.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/relight.h"
#include "gi/probes/texture_rays.h"
#include "probe_bakes.h"
#include "tests/parity/twin_data_parts.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

// How many numbers differ, and all of them where lists have other lengths.
template <class A, class B>
std::size_t differing(const A& a, const B& b) {
    if (a.size() != b.size()) return std::max(a.size(), b.size());
    std::size_t n = 0;
    for (std::size_t i = 0; i < a.size(); ++i) n += std::memcmp(&a[i], &b[i], sizeof a[i]) != 0;
    return n;
}

// One probe whose rays met materials in turn: nothing, a back, and those that there are.
BakeArrays rays_of(int rays, int degree, int materials) {
    BakeArrays a;
    const Buffer<float> harmonics = harmonics_of(relight_directions(rays), degree);
    a.rays = rays, a.coefficients = sh::count(degree), a.sh.assign(harmonics.begin(), harmonics.end());
    a.probes = {{0, 0, 0}};
    for (int i = 0; i < rays; ++i) a.relight.push_back({i % (materials + 2) - 2, {0.25f, float(i) / float(rays)}, {1, 2, 3}});
    return a;
}

}  // namespace

// IPR 3.2.5.1, 3.2.5.2.
TEST_CASE("probe textures: radiance and lambda of textures that were written and read back have the same bits", "[probes][textures][lambda]") {
    Scene scene = furnished();
    // A wall in the room that has one side: some rays meet its back.
    Mesh& room = scene.meshes[0];
    const auto first = unsigned(room.vertices.size());
    for (const glm::vec2 at : {glm::vec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) room.vertices.push_back({{1.4f, at.x, at.y}, 0, {1, 0, 0}, 0});
    room.triangles.push_back({first, first + 1, first + 2}), room.triangles.push_back({first, first + 2, first + 3});
    room.material.resize(room.triangles.size(), 1);
    scene.materials[0].reflectance = {0.7f, 0.4f, 0.2f}, scene.materials[1].emission = {3, 1, 2};
    BakeGraph graph(scene, small());
    run_all(graph);
    const Bake& bake = graph.bake();
    const BakeArrays arrays = arrays_of(all_textures(arrays_of(bake)));

    CHECK(std::count_if(arrays.relight.begin(), arrays.relight.end(), [](const BakedRay& r) { return r.material == met_back; }) > 10);
    HitSurfaces hits;
    RaySurfaces surfaces;
    for (const Unasked unasked : {Unasked::black, Unasked::nearest}) {
        hits = hit_surfaces(scene, bake, {}, unasked), surfaces = ray_surfaces(arrays, scene, bake.transport.escape, unasked);
        CHECK(differing(surfaces.surface, hits.surface.texels) == 0);
        CHECK(differing(surfaces.emitted, hits.emitted.texels) == 0);
        CHECK(differing(surfaces.place, hits.place.texels) == 0);
    }
    CHECK(std::count_if(surfaces.surface.begin(), surfaces.surface.end(), [](const glm::vec4& s) { return s.w == 1; }) > 1000);
    CHECK(std::any_of(surfaces.emitted.begin(), surfaces.emitted.end(), [](const glm::vec4& e) { return e.x > 0; }));

    // Two levels, so that the weights of each are asked for.
    const std::vector<int> level_rays = {bake.relight.rays, 64};
    const RayTables tables = ray_tables(arrays, level_rays);
    CHECK((tables.probes == bake.relight.probes && tables.rays == bake.relight.rays && tables.coefficients == bake.coefficients()));
    CHECK(differing(tables.harmonics, bake.harmonics) == 0);
    CHECK(differing(tables.weights, level_weights(bake.relight_directions, level_rays)) == 0);

    const int side = bake.receivers.size.x;
    const Image4 last = noise_image({side, side}, 5, 0, 2);
    const auto lambda = [&](const Buffer<glm::vec4>& surface, const Buffer<glm::vec4>& emitted, const Buffer<glm::vec4>& place,
                            const Buffer<float>& harmonics, const Buffer<float>& weights) {
        const Buffer<glm::vec4> direct(surface.size(), glm::vec4(0.5f, 1, 0.25f, 0));
        RadianceInputs in;
        in.probes = tables.probes, in.rays = tables.rays, in.side = side, in.lightmap = &last;
        in.surface = &surface, in.emitted = &emitted, in.direct = &direct, in.place = &place;
        Buffer<glm::vec4> radiance, out;
        run(in, {}, radiance);
        std::vector<std::int32_t> level(std::size_t(tables.probes), 0);
        for (std::size_t p = 0; p < level.size(); p += 2) level[p] = 1;
        LambdaInputs sums;
        sums.probes = tables.probes, sums.rays = tables.rays, sums.coefficients = tables.coefficients, sums.levels = 2;
        sums.level_rays = {level_rays[0], level_rays[1]}, sums.level_coefficients = {tables.coefficients, 9};
        sums.radiance = &radiance, sums.harmonics = &harmonics, sums.weights = &weights, sums.probe_level = &level;
        run(sums, {}, out);
        return out;
    };
    const Buffer<glm::vec4> from_bake = lambda(hits.surface.texels, hits.emitted.texels, hits.place.texels, bake.harmonics,
                                               level_weights(bake.relight_directions, level_rays));
    const Buffer<glm::vec4> from_textures = lambda(surfaces.surface, surfaces.emitted, surfaces.place, tables.harmonics, tables.weights);
    CHECK(differing(from_textures, from_bake) == 0);
    CHECK(std::any_of(from_bake.begin(), from_bake.end(), [](const glm::vec4& l) { return l.x > 1; }));
}

TEST_CASE("probe textures: rays that meet nothing see the sky, backs are black, fronts have their material's colour", "[probes][textures][analytic]") {
    Scene scene;
    scene.materials.resize(2);
    scene.materials[0].reflectance = {0.25f, 0.5f, 0.75f}, scene.materials[1].emission = glm::vec3(float(host::pi));
    // Patches of one colour each (core/scene.h): the upper half of the sky, and the lower.
    scene.environment.radiance = glm::vec3(1), scene.environment.map = Image4(4, 2, glm::vec4(0.5f, 1, 2, 1));
    for (int x = 0; x < 4; ++x) scene.environment.map(x, 1) = {4, 3, 1, 1};
    const BakeArrays a = rays_of(16, 2, 2);
    const RaySurfaces s = ray_surfaces(a, scene, Escape::same_direction, Unasked::black);
    const Buffer<glm::vec4> directions = relight_directions(16);
    REQUIRE(s.surface.size() == 16);
    for (std::size_t i = 0; i < 16; ++i) {
        const bool sky = i % 4 == 1, first = i % 4 == 2, second = i % 4 == 3;
        CAPTURE(i);
        CHECK(s.surface[i] == (first ? glm::vec4(0.25f, 0.5f, 0.75f, 1) : second ? glm::vec4(0.5f, 0.5f, 0.5f, 1) : glm::vec4(0)));
        // M / pi of pi is 1 to three roundings.
        const glm::vec3 of_sky = directions[i].y > 0 ? glm::vec3(0.5f, 1, 2) : glm::vec3(4, 3, 1);
        const glm::vec3 expected = sky ? of_sky : second ? glm::vec3(1) : glm::vec3(0);
        for (int c = 0; c < 3; ++c) CHECK(std::fabs(s.emitted[i][c] - expected[c]) <= (sky ? 0 : 3 * 0x1p-24f));
        CHECK(s.place[i] == (first || second ? glm::vec4(0.25f, float(i) / 16, 0, 0) : glm::vec4(0)));
    }
    scene.environment = {};
    CHECK(ray_surfaces(a, scene, Escape::same_direction, Unasked::black).emitted[1] == glm::vec4(0));
}

TEST_CASE("probe textures: rays of other directions, materials that are not there or have a texture are refused", "[probes][textures][robustness]") {
    Scene scene;
    scene.materials.resize(2);
    BakeArrays a = rays_of(16, 1, 2);
    CHECK(ray_tables(a, {16}).weights.size() == 16);
    CHECK(ray_tables(rays_of(1, 0, 2), {1}).harmonics.size() == 1);
    for (const std::size_t at : {std::size_t(0), std::size_t(37), a.sh.size() - 1}) {
        BakeArrays changed = a;
        changed.sh[at] = -changed.sh[at];
        CHECK_THROWS_WITH(ray_tables(changed, {16}), Catch::StartsWith("spherical_harmonics: texel " + std::to_string(at / 4) + ", " + std::to_string(at % 4)));
    }
    CHECK_THROWS_WITH(ray_tables(a, {17}), "17 rays at level 0: expected 1 to 16");
    BakeArrays ragged = a;
    ragged.coefficients = 3;
    CHECK_THROWS_WITH(ray_tables(ragged, {16}), "spherical_harmonics: 3 coefficients: expected the square of a number");
    a.relight[5].material = 2;
    CHECK_THROWS_WITH(ray_surfaces(a, scene, Escape::nothing), "probe_rays: ray 5: material 2 of 2");
    a.relight[5].material = 1, scene.materials[1].emission_texture = 0;
    CHECK_THROWS_WITH(ray_surfaces(a, scene, Escape::nothing), Catch::StartsWith("probe_rays: ray 3: material 1 has a texture"));
    // A texture that no ray meets does not matter.
    for (BakedRay& ray : a.relight) ray.material = std::min(ray.material, 0);
    CHECK_NOTHROW(ray_surfaces(a, scene, Escape::nothing));
}
