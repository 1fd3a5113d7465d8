// Whole bakes of all the scenes that there are: each is sound, or refused in one line.
#include <catch2/catch.hpp>
#include <regex>

#include "gi/frame/settings.h"
#include "gi/probes/sky_probe.h"
#include "io/scene_file.h"
#include "io/scenes/generate.h"
#include "tests/gi/probe_bakes.h"
#include "tests/io/files.h"
#include "tools/shared/bake_file.h"

using namespace plumb;
using namespace plumb::test;

namespace {

const std::string scenes = PLUMB_SOURCE_DIR "/data/scenes/";

// Few rays of few receivers: what can go wrong with a scene's surfaces does so at any number.
probes::BakeParams quick(float receivers_per_m2) {
    probes::BakeParams p;
    p.placement.overlaps = 10, p.placement.least = 8, p.receiver_rays = 512;
    p.receivers_per_m2 = receivers_per_m2;
    p.receiver_rays = 8, p.test_rays = 8, p.relight_rays = 64, p.degree = 2;
    p.placement.count = 12, p.placement.overlaps = 4;
    return p;
}

double area_of(const Scene& scene) {
    const Geometry g = flatten(scene);
    double area = 0;
    for (const glm::uvec3& t : g.triangles) {
        const glm::dvec3 a(g.vertices[t.x].position), b(g.vertices[t.y].position), c(g.vertices[t.z].position);
        const double twice = glm::length(glm::cross(b - a, c - a));
        if (std::isfinite(twice)) area += twice / 2;
    }
    return area;
}

// Density: of so many receivers, besides those that small charts have anyway.
void check_baked(const Scene& scene, int receivers) {
    probes::BakeGraph graph(scene, quick(float(receivers / area_of(scene))));
    run_all(graph);
    const probes::Bake& b = graph.bake();
    CAPTURE(b.receivers.count(), b.atlas.charts.size(), b.placement.probes.size(), b.supports.unsupported, b.counts().escaped,
            b.counts().back, b.counts().unseen, b.shifted, probes::black_receivers(b), b.clusters.clusters.size());
    check_sound(b);
    CHECK(probes::standing_probes(b.placement.probes) == 12);
    CHECK(b.placement.probes.size() == (probes::sends_light(scene.environment) ? 13 : 12));
    CHECK(b.supports.unsupported == 0);
    // Some of it sees something.
    CHECK(b.clusters.clusters.size() > 0);
    CHECK(probes::black_receivers(b) < b.receivers.count());
    // Its file can be written, and is what a reader asks for.
    const io::Folder folder;
    io::write_described(folder / "a.bake", cli::bake_file(b, scene.name, false));
    CHECK(io::error_of([&] { cli::check_bake(io::read_described(folder / "a.bake", cli::bake_kind)); }) == "");
}

Scene loaded(const std::string& file) { return io::load_scene(file, frame::method_tables()); }

// A scene file with so few triangles that its bake takes no time.
Scene with_triangles(const std::string& name, int triangles) {
    const io::Folder folder;
    const std::string text = std::regex_replace(io::read_text(scenes + name), std::regex("triangles = [0-9]+"),
                                                "triangles = " + std::to_string(triangles));
    return loaded(folder.put("scene.toml", text));
}

}  // namespace

TEST_CASE("bake: every scene that is generated, as small as it can be", "[probes][scenes]") {
    for (const io::GeneratedScene& s : io::generated_scenes()) {
        CAPTURE(s.name);
        Scene scene = io::generate_scene(s.name, {.triangles = s.least_triangles}, "test");
        const auto moves = [](const Mesh& m) { return m.dynamic; };
        if (std::all_of(scene.meshes.begin(), scene.meshes.end(), moves)) {
            CHECK_THROWS_WITH(check_baked(scene, 2000), Catch::Matchers::Contains("every mesh is dynamic"));
            for (Mesh& mesh : scene.meshes) mesh.dynamic = false;
        }
        check_baked(scene, 2000);
    }
}

TEST_CASE("bake: the scenes in data/", "[probes][scenes]") {
    for (const char* name : {"cornell/cornell.toml", "cornell/cornell_glossy.toml", "cornell/cornell_lamp.toml", "cornell_small.toml",
                             "sky/cornell_sky.toml", "box/box.toml", "furnace/furnace.toml", "furnace/furnace_cube.toml"}) {
        CAPTURE(name);
        check_baked(loaded(scenes + name), 1000);
    }
    const std::vector<std::pair<const char*, int>> smaller = {
        {"shapes/shapes.toml", 500}, {"stress/stress.toml", 4000}, {"hall/hall_2.toml", 14000}, {"rooms/rooms.toml", 20000}};
    for (const auto& [name, triangles] : smaller) {
        CAPTURE(name);
        check_baked(with_triangles(name, triangles), 2000);
    }
}

TEST_CASE("bake: of a scene with keyframes and things that move, as it stands", "[probes][scenes]") {
    const Scene still = with_triangles("atrium/atrium.toml", 14000);
    probes::BakeGraph first(still, quick(1));
    for (const char* name : {"atrium/frames_camera.toml", "atrium/frames_light.toml", "atrium/frames_object.toml", "atrium/frames_all.toml"}) {
        CAPTURE(name);
        const Scene scene = with_triangles(name, 14000);
        const Animation& moving = scene.animation;
        REQUIRE((!moving.camera.empty() || !moving.lights.empty() || !moving.meshes.empty()));
        // Where nothing was moved yet, it is the scene without keyframes: the same surfaces, the same bake. What moves is not baked.
        probes::BakeGraph graph(scene, quick(1));
        Scene left = still;
        std::erase_if(left.meshes, [&](const Mesh& m) {
            return std::any_of(scene.meshes.begin(), scene.meshes.end(), [&](const Mesh& other) { return other.dynamic && other.name == m.name; });
        });
        CHECK((left.meshes.size() < still.meshes.size()) == !moving.meshes.empty());
        probes::BakeGraph without(left, quick(1));
        CHECK(graph.bake().scene_hash == without.bake().scene_hash);
        CHECK((graph.bake().scene_hash == first.bake().scene_hash) == moving.meshes.empty());
        if (name == std::string("atrium/frames_object.toml")) check_baked(scene, 2000);
    }
}

TEST_CASE("bake: degenerate and extreme triangles, at every density", "[probes][scenes][extreme]") {
    const Scene scene = io::generate_scene("stress", {.triangles = 2000}, "test");
    for (const int receivers : {1, 100, 20000}) {
        CAPTURE(receivers);
        check_baked(scene, receivers);
    }
}
