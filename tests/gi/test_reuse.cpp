// Light of the last frame: means and their variance, a camera that moves, what comes into sight, and light that changes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/camera.h"
#include "core/error.h"
#include "core/hash.h"
#include "gi/screen/screen.h"

using namespace plumb;
using namespace plumb::screen;

namespace {

constexpr int side = 64;
constexpr double pixel_width = 1.0 / 16;  // on the wall at z = -2, seen by 90 degrees

// A wall at z = -2, and before it one at z = -1 that ends at x = 0; a camera `right` of the origin that looks along -z.
struct Shot {
    Image4 irradiance{side, side}, position{side, side}, normal{side, side};
    View view;
    Shot(double right, bool screen, double ahead = -1) {
        Camera camera;
        camera.position = {right, 0, 0}, camera.look_at = {right, 0, ahead};
        camera.fov_y_deg = 90, camera.near = 0.05, camera.far = 100;
        view = make_view(camera, 1);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const Ray ray = ray_through_pixel(camera, {side, side}, {x, y});
                for (const double z : {-1.0, -2.0}) {
                    const double t = z / ray.direction.z;
                    const glm::dvec3 at = ray.origin + ray.direction * t;
                    if (!(t > 0) || (z > -2 && (!screen || at.x > 0))) continue;
                    position(x, y) = glm::vec4(glm::vec3(at), float(-z)), normal(x, y) = {0, 0, 1, 1};
                    break;
                }
            }
    }
    void light(const glm::vec3& e) {
        for (glm::vec4& texel : irradiance.texels) texel = glm::vec4(e, 0);
    }
};

struct Made {
    Image4 light, age;
};

Made reuse_of(const ReuseParams& params, const Shot& shot, const LastFrame& last) {
    Made made;
    run_reuse(params, {&shot.irradiance, &shot.position, &shot.normal, shot.view, &last, {}}, {}, made.light, made.age);
    return made;
}

LastFrame left_by(const Shot& shot, const Made& made) { return {made.light, made.age, shot.position, shot.normal, shot.view, {side, side}}; }

ReuseParams mean_of(int frames, ReuseClamp clamp = ReuseClamp::none) {
    ReuseParams params;
    params.frames = frames, params.clamp = clamp;
    return params;
}

// Of two frames, the second with light `now` where the first had `then`.
Made second(const Shot& first, Shot shot, const ReuseParams& params) { return reuse_of(params, shot, left_by(first, reuse_of(params, first, {}))); }

}  // namespace

TEST_CASE("reuse: even light stays as it is, and frames are counted to their limit", "[screen][reuse][analytic]") {
    Shot shot(0, false);
    shot.light({0.7f, 3, 1e4f});
    LastFrame last;
    for (int f = 1; f <= 7; ++f) {
        const Made made = reuse_of(mean_of(5), shot, last);
        for (std::size_t i = 0; i < made.light.size(); ++i) {
            REQUIRE(made.light.texels[i].x == Approx(0.7).epsilon(1e-6));
            REQUIRE(made.light.texels[i].z == Approx(1e4).epsilon(1e-6));
            REQUIRE(made.light.texels[i].w == 2);
            // A border pixel's share may lie outside: what is known of it counts whole.
            REQUIRE(made.age.texels[i].x == Approx(std::min(f, 5)).epsilon(1e-5));
            REQUIRE(made.age.texels[i].w == 1);
        }
        last = left_by(shot, made);
    }
}

TEST_CASE("reuse: noise has 1/n of its variance, and 1/(2 N - 1) in the end", "[screen][reuse][analytic]") {
    const int most = 8;
    Shot shot(0, false);
    LastFrame last;
    for (int f = 1; f <= 80; ++f) {
        for (int i = 0; i < side * side; ++i) {
            const auto h = pixel_hash<std::int32_t>(i, f, 0, 77);
            const auto unit = [](std::int32_t v) { return float(std::uint32_t(v) >> 8) * 0x1p-24f; };
            shot.irradiance.texels[std::size_t(i)] = {unit(h.x), unit(h.y), unit(h.z), 0};
        }
        const Made made = reuse_of(mean_of(most), shot, last);
        last = left_by(shot, made);
        double sum = 0, squares = 0;
        for (const glm::vec4& t : made.light.texels)
            for (int c = 0; c < 3; ++c) sum += double(t[c]), squares += double(t[c]) * double(t[c]);
        const double n = 3.0 * side * side, mean = sum / n, variance = squares / n - mean * mean;
        const double expected = 1.0 / 12 / (f <= most ? f : 2 * most - 1);
        CAPTURE(f, mean, variance, expected);
        CHECK(mean == Approx(0.5).margin(0.01));
        // 12,288 numbers know a variance to 1.3 %.
        if (f <= most || f > 5 * most) CHECK(variance == Approx(expected).epsilon(0.06));
    }
}

TEST_CASE("reuse: light stays where its surface is while the camera moves", "[screen][reuse][analytic]") {
    for (const int pixels : {1, 5, -3}) {
        Shot first(0, false), shot(pixels * pixel_width, false);
        // A line of the wall, that is linear between pixels, and half a pixel's step.
        for (std::size_t i = 0; i < first.irradiance.size(); ++i) first.irradiance.texels[i] = glm::vec4(4 + first.position.texels[i].x, 0, 0, 0);
        shot.light(glm::vec3(0));
        const Made made = second(first, shot, mean_of(16));
        int fresh = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const glm::vec4 age = made.age(x, y);
                if (age.x == 1) {
                    ++fresh;
                    continue;
                }
                CAPTURE(pixels, x, y);
                CHECK(age.x == Approx(2).epsilon(1e-5));
                CHECK(made.light(x, y).x == Approx((4 + shot.position(x, y).x) / 2).epsilon(1e-4));
            }
        CHECK(fresh == std::abs(pixels) * side);
    }
    // Half a pixel: the mean of two.
    Shot first(0, false), shot(pixel_width / 2, false);
    for (std::size_t i = 0; i < first.irradiance.size(); ++i) first.irradiance.texels[i] = glm::vec4(i % side % 2 == 0 ? 1.0f : 3.0f, 0, 0, 0);
    const Made made = second(first, shot, mean_of(16));
    CHECK(made.light(30, 30).x == Approx(1).epsilon(1e-4));  // (2 + 0) / 2
}

TEST_CASE("reuse: picks of half an odd picture move by half of its pixels", "[screen][reuse][analytic]") {
    const glm::ivec2 full(47, 35), half(24, 18);
    const double width = 4.0 / full.y;  // of a pixel on the wall at z = -2, m
    const auto seen = [&](double right, Image4& position, Image4& normal) {
        Camera camera;
        camera.position = {right, 0, 0}, camera.look_at = {right, 0, -1}, camera.fov_y_deg = 90, camera.near = 0.05, camera.far = 100;
        for (int y = 0; y < half.y; ++y)
            for (int x = 0; x < half.x; ++x) {
                const Ray ray = ray_through_pixel(camera, full, glm::min(2 * glm::ivec2(x, y) + 1, full - 1));
                position(x, y) = glm::vec4(glm::vec3(ray.origin + ray.direction * (-2 / ray.direction.z)), 2), normal(x, y) = {0, 0, 1, 1};
            }
        return make_view(camera, double(full.x) / full.y);
    };
    Image4 before(half.x, half.y), now = before, normal = before, light = before, age(half.x, half.y, glm::vec4(1));
    const View then = seen(0, before, normal), view = seen(2 * width, now, normal);
    for (std::size_t i = 0; i < light.size(); ++i) light.texels[i] = glm::vec4(4 + before.texels[i].x, 0, 0, 0);
    const LastFrame last{light, age, before, normal, then, full};
    const Image4 dark(half.x, half.y);
    Made made;
    run_reuse(mean_of(16), {&dark, &now, &normal, view, &last, full}, {}, made.light, made.age);
    // The last column's pick has no pixel to its right.
    for (int x = 0; x < half.x - 3; ++x) {
        CAPTURE(x);
        CHECK(made.age(x, 7).x == Approx(2).epsilon(1e-4));
        CHECK(made.light(x, 7).x == Approx((4 + now(x, 7).x) / 2).epsilon(2e-5));
    }
}

TEST_CASE("reuse: what comes from behind an edge begins anew", "[screen][reuse][analytic]") {
    // The camera goes right by four pixels of the wall: it sees the wall from x = -1/4 on, where it saw it from 0 on.
    Shot first(0, true), shot(4 * pixel_width, true);
    first.light(glm::vec3(1)), shot.light(glm::vec3(1));
    const Made made = second(first, shot, mean_of(16));
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const glm::vec4 p = shot.position(x, y);
            const bool border = x >= side - 5;  // from outside of the picture
            if (border) continue;
            CAPTURE(x, y, p.x, p.z);
            // What lies within a pixel of either end has one neighbour there.
            const bool hidden_before = p.z < -1.5 && p.x < -pixel_width, open_before = p.z > -1.5 || p.x > pixel_width;
            if (hidden_before) CHECK(made.age(x, y).x == 1);
            if (open_before) CHECK(made.age(x, y).x > 1.9f);
        }
}

TEST_CASE("reuse: light that changes leaves a ghost, which the box takes away", "[screen][reuse][analytic]") {
    Shot shot(0, false);
    for (const ReuseClamp clamp : {ReuseClamp::none, ReuseClamp::box}) {
        LastFrame last;
        for (int f = 0; f < 9; ++f) {
            shot.light(glm::vec3(5));
            last = left_by(shot, reuse_of(mean_of(4, clamp), shot, last));
        }
        shot.light(glm::vec3(1));
        for (int k = 1; k <= 6; ++k) {
            const Made made = reuse_of(mean_of(4, clamp), shot, last);
            last = left_by(shot, made);
            CAPTURE(int(clamp), k);
            const double before = clamp == ReuseClamp::none ? 4 * std::pow(0.75, k - 1) : k == 1 ? 4 : 0;
            CHECK(made.light(20, 30).x == Approx(clamp == ReuseClamp::none ? 1 + 4 * std::pow(0.75, k) : 1).epsilon(1e-5));
            CHECK(made.age(20, 30).z == Approx(3 * before).epsilon(1e-5).margin(1e-5));
        }
    }
}

TEST_CASE("reuse: the box is of surfaces alone, and of all nine pixels", "[screen][reuse][analytic]") {
    // Around one pixel of light 3 lie holes of light 0, or surfaces; the last frame had 1, or 9 there.
    for (const float before : {1.0f, 9.0f})
        for (int beside = 0; beside < 9; ++beside) {
            Shot shot(0, false);
            shot.light(glm::vec3(before));
            const LastFrame last = left_by(shot, reuse_of(mean_of(4, ReuseClamp::box), shot, {}));
            for (int y = 29; y <= 31; ++y)
                for (int x = 19; x <= 21; ++x) {
                    const bool lit = x == 20 && y == 30, surface = lit || (y - 29) * 3 + x - 19 == beside;
                    if (!surface) shot.normal(x, y) = glm::vec4(0);
                    shot.irradiance(x, y) = glm::vec4(glm::vec3(lit ? 3 : surface ? (before < 3 ? 2.0f : 5.0f) : before < 3 ? 0.0f : 100.0f), 0);
                }
            const Made made = reuse_of(mean_of(4, ReuseClamp::box), shot, last);
            CAPTURE(before, beside);
            // The middle itself has nobody beside it: then history is moved to what it has now.
            const float held = beside == 4 ? 3.0f : before < 3 ? 2.0f : 5.0f;
            CHECK(made.light(20, 30).x == Approx((held + 3) / 2).epsilon(1e-6));
            CHECK(made.age(20, 30).z == Approx(3 * std::abs(held - before)).epsilon(1e-5));
        }
}

TEST_CASE("reuse: what lies behind the last camera, or was empty, was not seen", "[screen][reuse]") {
    Shot first(0, false), turned(0, false, 1);
    first.light(glm::vec3(9));
    // The wall that it faces now lay behind it.
    for (int i = 0; i < side * side; ++i) turned.position.texels[std::size_t(i)] = {float(i % side) * 0.01f, 0, 2, 2}, turned.normal.texels[std::size_t(i)] = {0, 0, -1, 1};
    turned.light(glm::vec3(2));
    const Made made = second(first, turned, mean_of(16));
    for (const glm::vec4& age : made.age.texels) REQUIRE(age.x == 1);
    for (const glm::vec4& light : made.light.texels) REQUIRE(light.x == 2);
    Shot empty(0, false);
    empty.light(glm::vec3(7));
    for (glm::vec4& n : empty.normal.texels) n = glm::vec4(0);
    const Made none = second(first, empty, mean_of(16));
    for (const glm::vec4& light : none.light.texels) REQUIRE((light.x == 0 && light.y == 0 && light.z == 0));
    for (const glm::vec4& age : none.age.texels) REQUIRE(age == glm::vec4(0));
    // And of a last frame that was empty nothing is taken.
    const Made fresh = second(empty, first, mean_of(16));
    for (const glm::vec4& age : fresh.age.texels) REQUIRE(age.x == 1);
}

TEST_CASE("reuse: frames turn patterns to all rotations, evenly", "[screen][reuse]") {
    for (const int rotations : {1, 2, 7, 16, 64, 100}) {
        std::set<int> met;
        for (int f = 0; f < rotations; ++f) {
            const int turn = turn_of_frame(std::uint32_t(f), rotations);
            REQUIRE((turn >= 0 && turn < rotations));
            met.insert(turn);
        }
        CHECK(int(met.size()) == rotations);
        CHECK(turn_of_frame(0, rotations) == 0);
    }
    for (const int frames : {4, 8, 16, 32}) {
        std::vector<int> turns;
        for (int f = 0; f < frames; ++f) turns.push_back(turn_of_frame(std::uint32_t(f), 64));
        std::sort(turns.begin(), turns.end());
        int gap = 64 + turns.front() - turns.back();
        for (std::size_t k = 1; k < turns.size(); ++k) gap = std::max(gap, turns[k] - turns[k - 1]);
        CAPTURE(frames, gap);
        CHECK(gap * frames <= 2 * 64);
    }
}

TEST_CASE("reuse: parameters out of range are refused by name", "[screen][reuse][bad input]") {
    Shot shot(0, false);
    ReuseParams params = mean_of(4);
    params.sigma_normal = 0;
    CHECK_THROWS_WITH(reuse_of(params, shot, {}), Catch::Contains("sigma_normal"));
    params = mean_of(-1);
    CHECK_THROWS_WITH(reuse_of(params, shot, {}), Catch::Contains("frames"));
}
