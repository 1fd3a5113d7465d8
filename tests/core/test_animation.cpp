// Motion by keyframes: values between keys, and the poses that they make of a scene.
#include <catch2/catch.hpp>
#include <algorithm>
#include <cmath>
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

namespace {

Motion along(std::vector<glm::dvec3> points, double speed, PathEnd end = PathEnd::hold) {
    Motion motion;
    motion.bezier = std::move(points), motion.speed = speed, motion.end = end;
    return motion;
}

// Bernstein's sum in long double: another algorithm for the same curve.
glm::dvec3 bernstein(const std::vector<glm::dvec3>& points, double t) {
    const std::size_t n = points.size() - 1;
    long double sum[3] = {0, 0, 0};
    for (std::size_t i = 0; i <= n; ++i) {
        long double weight = 1;
        for (std::size_t k = 0; k < i; ++k) weight *= (long double)(n - k) / (long double)(k + 1) * t;
        for (std::size_t k = i; k < n; ++k) weight *= 1 - (long double)t;
        for (int c = 0; c < 3; ++c) sum[c] += weight * points[i][c];
    }
    return {double(sum[0]), double(sum[1]), double(sum[2])};
}

double largest(const glm::dvec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

}  // namespace

TEST_CASE("animation: a Bezier curve is Bernstein's sum and ends at its ends, to the bit", "[animation][IPR A.1][analytic]") {
    const std::vector<glm::dvec3> points = {{-1, 3, 0.1}, {-0.9, 8.5, -6.1}, {2, 0.3, 1}, {5, -4, 2}, {0.7, 1, 3}};
    for (std::size_t count = 1; count <= points.size(); ++count) {
        const std::vector<glm::dvec3> some(points.begin(), points.begin() + std::ptrdiff_t(count));
        require_same(bezier_at(some, 0), some.front());
        require_same(bezier_at(some, 1), some.back());
        for (double t : {0.125, 0.3, 0.5, 0.77, 0.999})
            CHECK(largest(bezier_at(some, t) - bernstein(some, t)) < 1e-14);
    }
    // A quadratic, half way: a quarter, a half and a quarter of its points.
    require_same(bezier_at({{0, 0, 0}, {2, 4, 0}, {4, 0, 8}}, 0.5), {2, 2, 2});
}

TEST_CASE("animation: the curve leaves along its first side, n times as fast", "[animation][IPR A.1][analytic]") {
    // B'(0) = n (P1 - P0), B'(1) = n (Pn - Pn-1); the error of a difference quotient is of the order of its step.
    const std::vector<glm::dvec3> points = {{0, 0, 0}, {1, 2, 0}, {3, 2, 1}, {4, 0, -1}};
    const double h = 1e-6;
    CHECK(largest((bezier_at(points, h) - points[0]) / h - 3.0 * (points[1] - points[0])) < 1e-4);
    CHECK(largest((points[3] - bezier_at(points, 1 - h)) / h - 3.0 * (points[3] - points[2])) < 1e-4);
}

TEST_CASE("animation: points of equal distance on a line are walked through at constant speed", "[animation][IPR A.1][analytic]") {
    // Linear precision: sum B_i(t) i/n = t. Halves and quarters: nothing rounds.
    const std::vector<glm::dvec3> line = {{0, 1, 0}, {2, 1, -4}, {4, 1, -8}, {6, 1, -12}, {8, 1, -16}};
    for (int k = 0; k <= 16; ++k) require_same(bezier_at(line, k / 16.0), {k / 2.0, 1, -double(k)});
    // What all points share rests to the bit.
    for (double t : {0.1, 0.3, 0.7}) CHECK(bezier_at({{0, 0.1, 0}, {1, 0.1, 0}, {5, 0.1, 0}}, t).y == 0.1);
}

TEST_CASE("animation: at its end a curve is held, begins again or goes back", "[animation][IPR A.1]") {
    const auto at = [](PathEnd end, double frame) {
        Motion motion = along({{0, 0, 0}, {1, 0, 0}}, 0.25, end);
        motion.start = 8;
        return path_parameter(motion, frame);
    };
    for (PathEnd end : {PathEnd::hold, PathEnd::repeat, PathEnd::swing}) {
        CHECK(at(end, 0) == 0);
        CHECK(at(end, 8) == 0);
        CHECK(at(end, 9) == 0.25);
        CHECK(at(end, 11) == 0.75);
    }
    CHECK(at(PathEnd::hold, 12) == 1);
    CHECK(at(PathEnd::hold, 1e6) == 1);
    CHECK(at(PathEnd::repeat, 12) == 0);
    CHECK(at(PathEnd::repeat, 13) == 0.25);
    CHECK(at(PathEnd::swing, 12) == 1);
    CHECK(at(PathEnd::swing, 13) == 0.75);
    CHECK(at(PathEnd::swing, 16) == 0);
    CHECK(at(PathEnd::swing, 17) == 0.25);
}

TEST_CASE("animation: motions of meshes, lights and camera", "[animation][IPR A.1]") {
    Scene s = three_things();
    MeshTracks box;
    box.meshes = {{1, s.meshes[1].transform}}, box.pivot = {1, 0, 0};
    box.motion = along({{0, 0, 0}, {0, 4, 0}}, 0.125);
    box.motion.translate = {0, 0, 2}, box.motion.turn_deg = 22.5, box.motion.axis = {0, 1, 0};
    s.animation.meshes = {box};
    LightTracks key;
    key.light = 0, key.position = {{0, {0, 1, 0}}}, key.direction = {{0, {1, 0, 0}}};
    key.motion.translate = {1, 0, 0}, key.motion.turn_deg = 45, key.motion.axis = {0, 0, 1};
    s.animation.lights = {key};
    s.animation.camera.motion = along({{0, 1, 4}, {0, 1, 8}}, 0.25);
    s.animation.camera.motion.translate = {1, 0, 0};
    s.animation.camera.look_at = {{0, {0, 1, 0}}};
    CHECK(is_animated(s));

    const Scene four = scene_at(s, 4);
    // 90 degrees about +y take +x to -z and +z to +x, as a yaw of 90 degrees does.
    require_same(moved(four.meshes[1], {0, 0, 0}), {1, 2, 8});
    require_same(moved(four.meshes[1], {1, 0, 0}), {1, 2, 7});
    require_same(moved(four.meshes[1], {0, 0, 1}), {2, 2, 8});
    CHECK(four.lights[0].position == glm::vec3(4, 1, 0));
    CHECK(four.lights[0].direction == glm::vec3(-1, 0, 0));
    CHECK(scene_at(s, 2).lights[0].direction == glm::vec3(0, 1, 0));
    require_same(four.camera.position, {4, 1, 8});
    require_same(four.camera.look_at, {4, 1, 0});

    // Poses replace each other.
    const Scene around = scene_at(scene_at(scene_at(s, 9), 3), 4);
    CHECK(around.meshes[1].transform == four.meshes[1].transform);
    CHECK(around.lights[0].position == four.lights[0].position);
    CHECK(around.lights[0].direction == four.lights[0].direction);
    require_same(around.camera.position, four.camera.position);
    require_same(around.camera.look_at, four.camera.look_at);
    CHECK(scene_at(s, 0).meshes[1].transform == s.meshes[1].transform);
}

TEST_CASE("animation: a turn about any axis keeps the axis and all lengths", "[animation][IPR A.1][analytic]") {
    Scene s = three_things();
    MeshTracks box;
    box.meshes = {{0, glm::dmat4(1)}};
    const double length = std::sqrt(1 + 0.04 + 1);
    box.motion.turn_deg = 7, box.motion.axis = glm::dvec3(1, 0.2, 1) / length;
    s.animation.meshes = {box};
    for (double frame : {1.0, 10.0, 51.0}) {
        const glm::dmat3 m(scene_at(s, frame).meshes[0].transform);
        CHECK(largest(m * box.motion.axis - box.motion.axis) < 1e-15);
        const glm::dmat3 identity = glm::transpose(m) * m;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) CHECK(identity[c][r] == Approx(c == r ? 1 : 0).margin(1e-14));
        CHECK(glm::determinant(m) == Approx(1).epsilon(1e-14));
        // The trace of a turn by alpha is 1 + 2 cos alpha.
        CHECK(m[0][0] + m[1][1] + m[2][2] == Approx(1 + 2 * std::cos(7 * frame * 3.141592653589793 / 180)).epsilon(1e-13));
    }
}
