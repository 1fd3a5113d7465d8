// A bake is of static meshes alone.
#include <catch2/catch.hpp>

#include "core/error.h"
#include "gi/probes/kept_steps.h"
#include "gi/probes/static_scene.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

Mesh box_of(const glm::vec3& low, const glm::vec3& high, bool inwards, bool dynamic, const char* name) {
    Mesh mesh;
    add_box(mesh, low, high, 0, inwards);
    mesh.material.assign(mesh.triangles.size(), 0);
    mesh.dynamic = dynamic, mesh.name = name;
    return mesh;
}

// A room with a box that stands still, and things that move: before, between and after them. One of these has a normal map.
Scene with_moving() {
    Scene scene;
    scene.materials.resize(2);
    scene.textures.resize(1);
    scene.textures[0].texels = Image<std::uint32_t>(2, 2, 0xffff8080);
    scene.materials[1].normal_texture = 0;
    scene.meshes = {box_of({-1, -1.5f, -1}, {-0.6f, 1, 1}, false, true, "first"), box_of(glm::vec3(-2), glm::vec3(2), true, false, "room"),
                    box_of({0, 0, 0}, {1, 1, 1}, false, true, "between"), box_of({-0.5f, -2, 0}, {0.5f, -1, 1.5f}, false, false, "box"),
                    box_of({1.2f, -2, -1}, {1.5f, 1, 1}, false, true, "last")};
    Mesh& mapped = scene.meshes[2];
    mapped.tangents.assign(mapped.vertices.size(), glm::vec4(1, 0, 0, 1));
    mapped.material.assign(mapped.triangles.size(), 1);
    return scene;
}
Scene without_moving(Scene scene) {
    std::erase_if(scene.meshes, [](const Mesh& m) { return m.dynamic; });
    return scene;
}

std::vector<std::uint64_t> content_of(const Bake& b) {
    return {b.scene_hash, content_hash(lent(b.atlas)), content_hash(lent(b.receivers, b.shifted)), content_hash(lent(b.placement, b.radius)),
            content_hash(lent(b.supports)), content_hash(lent(b.relight, 0, b.relight.probes)), content_hash(b.alpha.data(), b.alpha.size() * 4),
            content_hash(lent(b.flat))};
}

}  // namespace

TEST_CASE("bake: of a scene with dynamic meshes it is that of the scene without them, byte by byte", "[probes][dynamic]") {
    const Scene moving = with_moving(), still = without_moving(moving);
    REQUIRE(still.meshes.size() == 2);
    BakeParams params = small();
    params.receiver_rays = 32;
    BakeGraph a(moving, params), b(still, params);
    run_all(a), run_all(b);
    CHECK(content_of(a.bake()) == content_of(b.bake()));
    // The moving things would change it.
    Scene all = moving;
    for (Mesh& m : all.meshes) m.dynamic = false;
    CHECK(BakeGraph(all, params).bake().scene_hash != a.bake().scene_hash);
    CHECK(a.bake().atlas.geometry.tangents.empty());
    CHECK(a.bake().atlas.geometry.triangles.size() == 24);
}

TEST_CASE("bake: triangles of the scene and of the atlas are the same ones", "[probes][dynamic]") {
    const Scene scene = with_moving();
    const Geometry all = flatten(scene), fixed = flatten_static(scene);
    const std::vector<std::int32_t> index = static_triangles(scene, all);
    REQUIRE(index.size() == 60);
    std::size_t none = 0, wrong = 0;
    for (std::size_t t = 0; t < index.size(); ++t) {
        none += index[t] < 0 ? 1 : 0;
        if (index[t] < 0) continue;
        for (int c = 0; c < 3; ++c)
            wrong += all.vertices[all.triangles[t][c]].position == fixed.vertices[fixed.triangles[std::size_t(index[t])][c]].position ? 0 : 1;
    }
    CHECK(none == 36);
    CHECK(wrong == 0);
    CHECK(std::vector<std::int32_t>(index.begin() + 12, index.begin() + 25) == std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, -1});
    CHECK(index.at(36) == 12);
    // Where nothing moves, each is itself.
    const Scene still = without_moving(scene);
    const std::vector<std::int32_t> same = static_triangles(still, flatten(still));
    for (std::size_t t = 0; t < same.size(); ++t) REQUIRE(same[t] == std::int32_t(t));
}

TEST_CASE("bake: a scene where everything moves is refused", "[probes][dynamic]") {
    Scene scene = with_moving();
    for (Mesh& m : scene.meshes) m.dynamic = true;
    scene.name = "all moving";
    CHECK_THROWS_WITH(BakeGraph(scene, small()), Catch::Matchers::Contains("all moving") && Catch::Matchers::Contains("every mesh is dynamic"));
    CHECK_THROWS_AS(BakeGraph(scene, small()), InputError);
}
