// Motion by keyframes: values between keys, and the poses that they make of a scene.
#include <catch2/catch.hpp>
#include <limits>

#include "core/animation.h"
#include "core/error.h"

using namespace plumb;
using Catch::Matchers::Contains;

namespace {

Scene three_things() {
    Scene s;
    s.camera.position = {0, 1, 4}, s.camera.look_at = {0, 1, 0};
    s.lights.resize(2);
    s.lights[0].name = "key", s.lights[1].name = "sun";
    s.meshes.resize(3);
    for (int m = 0; m < 3; ++m) s.meshes[std::size_t(m)].transform[3] = glm::dvec4(m, 0, 0, 1);
    return s;
}

glm::dvec3 moved(const Mesh& mesh, const glm::dvec3& p) { return glm::dvec3(mesh.transform * glm::dvec4(p, 1)); }

// Nobody rounds in these: the sums are of few halves and quarters.
void require_same(const glm::dvec3& a, const glm::dvec3& b) {
    CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z);
    REQUIRE(a == b);
}

}  // namespace

TEST_CASE("animation: a track is linear between its keys and held outside of them", "[animation]") {
    const Track track = {{2, {1, 0, -1}}, {4, {3, 8, -1}}, {12, {-1, 0, 0}}};
    require_same(value_at(track, 0), {1, 0, -1});
    require_same(value_at(track, 2), {1, 0, -1});
    require_same(value_at(track, 2.5), {1.5, 2, -1});
    require_same(value_at(track, 3), {2, 4, -1});
    require_same(value_at(track, 4), {3, 8, -1});
    require_same(value_at(track, 10), {0, 2, -0.25});  // a quarter of the way from the last key
    require_same(value_at(track, 12), {-1, 0, 0});
    require_same(value_at(track, 1e9), {-1, 0, 0});
}

TEST_CASE("animation: what is equal at two keys rests between them, to the bit", "[animation]") {
    // 0.1 (1 - s) + 0.1 s is not 0.1 for every s.
    const Track track = {{0, glm::dvec3(0.1)}, {7, glm::dvec3(0.1, 0.7, 0.1)}};
    for (int frame = 0; frame <= 7; ++frame) {
        CHECK(value_at(track, frame).x == 0.1);
        CHECK(value_at(track, frame).z == 0.1);
    }
}

TEST_CASE("animation: a switch turns at its keys", "[animation]") {
    const Track track = {{3, {1, 0, 0}}, {5, {0, 0, 0}}, {9, {1, 0, 0}}};
    for (const auto& [frame, on] : std::vector<std::pair<double, int>>{
             {0, 1}, {3, 1}, {4.999, 1}, {5, 0}, {8.5, 0}, {9, 1}, {100, 1}})
        CHECK(step_at(track, frame).x == on);
}

TEST_CASE("animation: camera, lights and meshes take their poses, and nothing else moves", "[animation]") {
    Scene s = three_things();
    s.animation.camera.position = {{0, {0, 1, 4}}, {10, {2, 1, 4}}};
    s.animation.camera.fov_y_deg = {{0, {40, 0, 0}}, {10, {60, 0, 0}}};
    LightTracks sun;
    sun.light = 1;
    sun.direction = {{0, {0, -1, 0}}, {10, {1, 0, 0}}};
    sun.intensity = {{0, {0, 2, 4}}, {10, {8, 2, 0}}};
    sun.cone_deg = {{0, {10, 20, 0}}, {10, {20, 40, 0}}};
    sun.on = {{0, {1, 0, 0}}, {5, {0, 0, 0}}};
    s.animation.lights = {sun};
    MeshTracks door;
    door.name = "door", door.pivot = {1, 0, 0};
    door.meshes = {{1, s.meshes[1].transform}, {2, s.meshes[2].transform}};
    door.rotate_deg = {{0, {0, 0, 0}}, {10, {180, 0, 0}}};
    door.translate = {{0, {0, 0, 0}}, {10, {0, 3, 0}}};
    s.animation.meshes = {door};

    const Scene half = scene_at(s, 5);
    require_same(half.camera.position, {1, 1, 4});
    require_same(half.camera.look_at, s.camera.look_at);
    CHECK(half.camera.fov_y_deg == 50);
    const float diagonal = float(1 / std::sqrt(2.0));
    CHECK(half.lights[1].direction.x == diagonal);
    CHECK(half.lights[1].direction.y == -diagonal);
    CHECK(half.lights[1].intensity == glm::vec3(4, 2, 2));
    CHECK(half.lights[1].cone_inner_deg == 15);
    CHECK(half.lights[1].cone_outer_deg == 30);
    CHECK_FALSE(half.lights[1].on);
    CHECK(half.lights[0].on);
    CHECK(half.lights[0].direction == s.lights[0].direction);
    // Yaw by 90 degrees takes +x to -z: the second mesh stands one metre beside the pivot.
    require_same(moved(half.meshes[0], {0, 0, 0}), {0, 0, 0});
    require_same(moved(half.meshes[1], {0, 0, 0}), {1, 1.5, 0});
    require_same(moved(half.meshes[1], {1, 0, 0}), {1, 1.5, -1});
    require_same(moved(half.meshes[2], {0, 0, 0}), {1, 1.5, -1});
    CHECK(half.meshes[0].transform == s.meshes[0].transform);

    // What does not turn has its own transform, to the bit.
    CHECK(scene_at(s, 0).meshes[2].transform == s.meshes[2].transform);
}

TEST_CASE("animation: poses replace each other", "[animation]") {
    Scene s = three_things();
    MeshTracks tracks;
    tracks.meshes = {{2, s.meshes[2].transform}};
    tracks.rotate_deg = {{0, {0, 0, 0}}, {8, {70, 20, 10}}};
    tracks.scale = {{0, {1, 1, 1}}, {8, {2, 0.5, 1}}};
    s.animation.meshes = {tracks};
    s.animation.camera.look_at = {{0, {0, 1, 0}}, {8, {1, 1, 0}}};
    for (double frame : {0.0, 1.0, 3.5, 8.0}) {
        const Scene direct = scene_at(s, frame), around = scene_at(scene_at(scene_at(s, 7), 2), frame);
        CHECK(direct.meshes[2].transform == around.meshes[2].transform);
        CHECK(direct.camera.look_at == around.camera.look_at);
    }
}

TEST_CASE("animation: a pose that cannot be names its frame", "[animation]") {
    Scene s = three_things();
    s.animation.camera.position = {{0, {0, 1, 4}}, {4, {0, 1, -4}}};
    CHECK_NOTHROW(scene_at(s, 1));
    CHECK_THROWS_WITH(scene_at(s, 2), Contains("frame 2: camera: look_at = [0, 1, 0]: must be finite and away from"));

    s = three_things();
    LightTracks key;
    key.direction = {{0, {0, -1, 0}}, {4, {0, 1, 0}}};
    s.animation.lights = {key};
    CHECK_THROWS_WITH(scene_at(s, 2), Contains("frame 2: light \"key\": the keyframes around it point opposite ways"));

    s = three_things();
    MeshTracks tracks;
    tracks.name = "door", tracks.meshes = {{0, glm::dmat4(1)}};
    tracks.scale = {{0, {1, 1, 1}}, {4, {1, -1, 1}}};
    s.animation.meshes = {tracks};
    CHECK_NOTHROW(scene_at(s, 1));
    CHECK_THROWS_WITH(scene_at(s, 2), Contains("frame 2: mesh \"door\": scale = [1, 0, 1]: expected none of them 0"));
    CHECK(is_animated(s));
    CHECK_FALSE(is_animated(three_things()));
}
