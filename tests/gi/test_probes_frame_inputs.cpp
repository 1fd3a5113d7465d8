// What frames of the method probes hand their stages: textures where rays end, weights, windows and distances of levels of detail.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/frame/frame.h"
#include "gi/frame/probe_bake.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lod.h"
#include "gi/probes/sky_probe.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

probes::Bake bake_of(const Scene& scene, const probes::BakeParams& params) {
    probes::BakeGraph graph(scene, params);
    run_all(graph);
    return graph.release();
}

frame::Frame frame_of(Scene scene, const probes::LodParams& lod, probes::Window window = probes::Window::none) {
    for (Material& m : scene.materials) m.emission = glm::vec3(1);
    scene.camera.position = {-1.8, 1.5, 0.1}, scene.camera.look_at = {1, -0.5, 0};
    scene.camera.fov_y_deg = 80, scene.camera.near = 1e-3;
    scene.frame_size = {33, 27}, scene.method = "probes";
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small(), settings.probes.receivers_per_m2 = 5;
    settings.lod = lod, settings.probe_run.window = window;
    frame::add_bake(scene, settings);
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

}  // namespace

TEST_CASE("probes: rays that end on a texture bring the colour of the place", "[probes][frame][analytic]") {
    // A square in the room, black for x below 0 and white beyond, in triangles that part it along the diagonal.
    Scene scene = empty_room();
    Mesh square;
    for (const auto& [x, z] : {std::pair(-1.0f, 1.0f), {1.0f, 1.0f}, {1.0f, -1.0f}, {-1.0f, -1.0f}})
        square.vertices.push_back({{x, -1.5f, z}, 0.5f + 0.5f * x, {0, 1, 0}, 0.5f - 0.5f * z});
    square.triangles = {{0, 1, 2}, {0, 2, 3}}, square.material = {1, 1};
    scene.meshes.push_back(square);
    Texture texture;
    texture.srgb = false, texture.filter = Filter::nearest;
    texture.texels = Image<std::uint32_t>(2, 1, 0xff000000u), texture.texels(1, 0) = 0xffffffffu;
    scene.textures = {texture};
    scene.materials[1].texture = 0, scene.materials[1].reflectance = glm::vec3(0.5f);
    const probes::Bake bake = bake_of(scene, small());
    const probes::HitSurfaces hits = probes::hit_surfaces(scene, bake, {}, probes::Unasked::black);
    int black = 0, white = 0;
    for (std::size_t k = 0; k < bake.relight.material.size(); ++k) {
        const float x = bake.relight.position[k].x;
        if (bake.relight.material[k] != 1 || std::fabs(x) < 1e-3f) continue;
        CHECK(hits.surface.texels[k].x == (x < 0 ? 0.0f : 0.5f));
        ++(x < 0 ? black : white);
    }
    CHECK(black > 5);
    CHECK(white > 5);
}

TEST_CASE("probes: fragments take the next level where fragment_shift says", "[probes][frame][lod][IPR 4.2.4]") {
    probes::LodParams lod;
    lod.levels = 2, lod.distance_1 = 3.5f, lod.fragment_shift = 1, lod.smoothing = 0;
    const frame::Frame f = frame_of(empty_room(), lod);
    const glm::dvec3 eye(-1.8, 1.5, 0.1);
    int shifted = 0;
    for (std::size_t i = 0; i < f.probes.uv.size(); ++i) {
        if (!(f.probes.uv.texels[i].w > 0)) continue;
        const double distance = glm::length(glm::dvec3(f.gbuffer.position.texels[i]) - eye);
        if (std::fabs(distance - 2.5) < 1e-3) continue;
        CHECK(f.probes.uv.texels[i].z == (distance < 2.5 ? 0 : 1));
        shifted += distance > 2.5 && distance < 3.5;
    }
    CHECK(shifted > 20);
}

TEST_CASE("probes: each level's rays have weights that add up to the sphere, and windows hold in all", "[probes][frame][lod][window][analytic]") {
    probes::LodParams lod;
    lod.levels = 3, lod.distance_1 = 0.5f, lod.distance_2 = 1;
    const frame::Frame f = frame_of(empty_room(), lod, probes::Window::hann);
    const frame::ProbeBuffers& p = f.probes;
    REQUIRE(p.lod.rays[2] < p.lod.rays[0]);
    for (std::size_t k = 0; k < 3; ++k) {
        double sum = 0;
        for (int r = 0; r < p.lod.rays[k]; ++r) sum += double(p.weights[k * std::size_t(p.data.rays) + std::size_t(r)]);
        CHECK(sum == Approx(4 * host::pi).epsilon(1e-5));
    }
    // Hann's factor of degree 1 is (1 + cos(pi / 8)) / 2 of degree 7; Y_10 has a maximum of sqrt(3 / (4 pi)).
    double most = 0;
    for (int r = 0; r < p.data.rays; ++r)
        for (int j = 1; j < 4; ++j) most = std::max(most, std::fabs(double(p.harmonics[std::size_t(r) * 64 + std::size_t(j)])));
    CHECK(most == Approx((1 + std::cos(host::pi / 8)) / 2 * std::sqrt(3 / (4 * host::pi))).epsilon(0.01));
}

TEST_CASE("lod: where charts lie as far apart as asked each has receivers in every level", "[probes][lod][IPR 4.2.3]") {
    // The box' faces are a texel each.
    Scene scene = empty_room();
    add_box(scene.meshes[0], glm::vec3(-0.1f), glm::vec3(0.1f), 1);
    scene.meshes[0].material.resize(scene.meshes[0].triangles.size(), 1);
    probes::BakeParams params = small();
    params.gap = 12;
    const auto missing = probes::charts_missing(bake_of(scene, params), 3);
    CHECK(missing[1] == missing[0]);
    CHECK(missing[2] == missing[0]);
}

TEST_CASE("lod: the sky, a probe that clusters of all levels ask, is in level 0", "[probes][lod]") {
    Scene open = empty_room();
    open.meshes[0].triangles.resize(open.meshes[0].triangles.size() - 2);
    open.meshes[0].material.resize(open.meshes[0].triangles.size());
    open.environment.radiance = glm::vec3(1);
    const probes::Bake bake = bake_of(open, small());
    REQUIRE(probes::standing_probes(bake.placement.probes) + 1 == int(bake.placement.probes.size()));
    for (const probes::ProbeLevel from : {probes::ProbeLevel::centre, probes::ProbeLevel::radius}) {
        probes::LodParams params;
        params.levels = 3, params.distance_1 = 0.1f, params.distance_2 = 0.2f, params.probe_level = from;
        const probes::Levels levels = probes::levels_at(probes::lod_of(params, bake), bake, probes::lod_boxes(bake), {9, 0, 0}, {1, 0, 0}, {});
        CHECK(levels.probe.front() == 2);
        CHECK(levels.probe.back() == 0);
    }
}
