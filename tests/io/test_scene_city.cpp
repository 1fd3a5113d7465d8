#include "io/scenes/generate.h"
#include "scene_checks.h"

using namespace plumb;

TEST_CASE("city: as many triangles as asked for, within 5 %", "[io][scenes]") {
    for (const std::int64_t wanted : {1'000, 3'000, 10'000, 30'000, 100'000, 300'000}) {
        const Scene s = io::generate_scene("city", {wanted, 1}, "test");
        INFO(wanted);
        CHECK(std::abs(double(triangle_count(s)) / double(wanted) - 1) < 0.05);
    }
}

TEST_CASE("city: no triangle is degenerate, every normal is unit and on its triangle's front", "[io][scenes]") {
    for (const std::int64_t wanted : {1'000, 30'000, 400'000}) {
        const Scene s = io::generate_scene("city", {wanted, 3}, "test");
        const Faults faults = faults_of(s);
        INFO(wanted);
        CHECK(faults.index == 0);
        CHECK(faults.area == 0);
        CHECK(faults.normal == 0);
        CHECK(faults.side == 0);
        CHECK(faults.coordinate == 0);
        CHECK(s.lights.size() == 2);  // the sun, and what stands for the sky
    }
}

TEST_CASE("city: 600 m wide whatever the number of triangles; the camera stands over the roofs", "[io][scenes]") {
    for (const std::int64_t wanted : {1'000, 100'000}) {
        const Scene s = io::generate_scene("city", {wanted, 1}, "test");
        glm::vec3 low, high;
        REQUIRE(bounds(flatten(s), low, high));
        CHECK(low.x == Approx(-308));
        CHECK(high.x == Approx(308));
        CHECK(low.z == Approx(-308));
        CHECK(high.z == Approx(308));
        // The church's cross is the highest thing: nave 33 m, drum 12 m, dome and lantern about 25 m.
        CHECK(high.y > 60);
        CHECK(high.y < 90);
    }
    // Straight down from the camera there is air, then a front side.
    const Scene s = io::generate_scene("city", {10'000, 1}, "test");
    const RayHit below = first_hit(s, s.camera.position, {0, -1, 0});
    CHECK(below.front);
    CHECK(below.t > 40);
}

TEST_CASE("city: the same bytes every time, other ones for another seed", "[io][scenes][determinism]") {
    const std::uint64_t first = scene_hash(io::generate_scene("city", {10'000, 1}, "test"));
    CHECK(scene_hash(io::generate_scene("city", {10'000, 1}, "test")) == first);
    CHECK(scene_hash(io::generate_scene("city", {10'000, 2}, "test")) != first);
    // Written down from gcc 12 on x86-64; any other compiler and build has to agree.
    CHECK(hash_text(first) == "c9c8b8db13360d67");
}
