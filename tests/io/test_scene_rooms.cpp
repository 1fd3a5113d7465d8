#include "core/host_math.h"
#include "io/scenes/generate.h"
#include "io/scenes/rooms_parts.h"
#include "scene_checks.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// Where a ray from inside leaves the inner faces of the outer walls: is that in a window?
bool leaves_by_window(const scenes::flat::Flat& flat, const glm::dvec3& from, const glm::dvec3& d) {
    const scenes::flat::Box& f = flat.floor;
    double t = 1e30;
    int side = -1;
    const double to[4] = {d.z < 0 ? (f.z0 - from.z) / d.z : 1e30, d.x > 0 ? (f.x1 - from.x) / d.x : 1e30,
                          d.z > 0 ? (f.z1 - from.z) / d.z : 1e30, d.x < 0 ? (f.x0 - from.x) / d.x : 1e30};
    for (int k = 0; k < 4; ++k)
        if (to[k] < t) t = to[k], side = k;
    const glm::dvec3 p = from + t * d;
    for (const scenes::flat::Room& room : flat.rooms) {
        const scenes::flat::Box& r = room.floor;
        if (!room.outside[std::size_t(side)]) continue;
        const double along[4] = {p.x - r.x0, p.z - r.z0, r.x1 - p.x, r.z1 - p.z};
        for (const scenes::flat::Opening& o : room.openings[std::size_t(side)])
            if (o.window && along[side] > o.from && along[side] < o.to && p.y > o.low && p.y < o.high) return true;
    }
    return false;
}

glm::dvec3 direction(int i, int count) {  // evenly over the sphere (Fibonacci)
    const double y = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - y * y), turn = 2.399963 * i + 0.1;
    return {r * host::sin(turn), y, r * host::cos(turn)};
}

}  // namespace

TEST_CASE("rooms: a hundred seeds are valid; rays meet a front or leave by a window", "[io][scenes]") {
    int left = 0;
    for (std::uint32_t seed = 1; seed <= 100; ++seed) {
        const Scene s = generate_scene("rooms", {20'000, seed}, "test");
        INFO("seed " << seed);
        CHECK(std::abs(double(triangle_count(s)) / 20'000 - 1) < 0.05);
        const Faults faults = faults_of(s);
        CHECK(faults.index == 0);
        CHECK(faults.area == 0);
        CHECK(faults.normal == 0);
        CHECK(faults.side == 0);
        CHECK(faults.coordinate == 0);
        REQUIRE(!s.lights.empty());
        validate(s.camera);

        // From the camera and from under the lamp the room is closed.
        scenes::Dice dice{seed, scenes::flat::dice_row};
        const scenes::flat::Flat flat = scenes::flat::plan_flat(dice);
        const glm::dvec3 lamp = glm::dvec3(s.lights[0].position) - glm::dvec3(0, 0.05, 0);
        int escaped = 0, backs = 0;
        for (const glm::dvec3& from : {s.camera.position, lamp})
            for (int i = 0; i < 40; ++i) {
                const glm::dvec3 d = direction(i, 40);
                const RayHit hit = first_hit(s, from, d);
                if (hit.t < 1e30) {
                    backs += !hit.front;
                } else {
                    ++left;
                    escaped += !leaves_by_window(flat, from, d);
                }
            }
        CHECK(escaped == 0);
        CHECK(backs == 0);

        // The camera sees at least a metre far, and stands on the floor or on a rug.
        const glm::dvec3 ahead = glm::normalize(s.camera.look_at - s.camera.position);
        CHECK(first_hit(s, s.camera.position, ahead).t > 1);
        CHECK(first_hit(s, s.camera.position, {0, -1, 0}).t == Approx(s.camera.position.y).margin(0.02));
    }
    CHECK(left > 50);  // windows are holes
}

TEST_CASE("rooms: every room can be reached through doors", "[io][scenes]") {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        scenes::Dice dice{seed, scenes::flat::dice_row};
        const scenes::flat::Flat flat = scenes::flat::plan_flat(dice);
        // A tree of n rooms has n - 1 doors, and each door is an opening of two rooms.
        std::size_t doors = 0;
        for (const scenes::flat::Room& room : flat.rooms)
            for (const auto& side : room.openings)
                for (const scenes::flat::Opening& o : side) doors += !o.window;
        INFO("seed " << seed);
        CHECK(doors == 2 * (flat.rooms.size() - 1));
    }
}

TEST_CASE("rooms: the same bytes every time, other ones for another seed", "[io][scenes][determinism]") {
    const std::uint64_t first = scene_hash(generate_scene("rooms", {20'000, 1}, "test"));
    CHECK(scene_hash(generate_scene("rooms", {20'000, 1}, "test")) == first);
    CHECK(scene_hash(generate_scene("rooms", {20'000, 2}, "test")) != first);
    // Written down from gcc 12 on x86-64; any other compiler and build has to agree.
    CHECK(hash_text(first) == "97c4c8256730f675");
}
