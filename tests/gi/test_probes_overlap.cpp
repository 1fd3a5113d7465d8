// Overlap of triangles on a plane, which decides what a chart may hold.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/probes/plane_cover.h"
#include "tests/gi/chart_meshes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

TEST_CASE("overlap: agrees with the area that triangles share", "[probes][overlap]") {
    test::Dice dice(1);
    int overlapping = 0, apart = 0;
    for (int i = 0; i < 20000; ++i) {
        const PlaneTriangle a = random_triangle(dice, 0.3f), b = random_triangle(dice, 0.3f);
        if (std::fabs(twice_area(a)) < 1e-3 || std::fabs(twice_area(b)) < 1e-3) continue;
        const double area = shared_area(a, b);
        if (area > 0 && area < 1e-9) continue;  // a touch, but for rounding
        CHECK(overlap(a, b, 1e-12) == (area > 0));
        CHECK(overlap(b, a, 1e-12) == (area > 0));
        ++(area > 0 ? overlapping : apart);
    }
    CHECK(overlapping > 1000);
    CHECK(apart > 1000);
}

TEST_CASE("overlap: a shared side or corner is none, half a tolerance neither, twice the tolerance is one",
          "[probes][overlap]") {
    const PlaneTriangle a{glm::dvec2(0, 0), {1, 0}, {0, 1}}, beside{glm::dvec2(1, 0), {1, 1}, {0, 1}};
    CHECK_FALSE(overlap(a, beside, 0));
    CHECK_FALSE(overlap(a, {glm::dvec2(0, 0), {-1, 0}, {0, -1}}, 0));
    CHECK(overlap(a, a, 0));
    CHECK(overlap(a, {a[0], a[2], a[1]}, 0));
    const double tolerance = 1e-3;
    for (double deep : {0.5, 2.0}) {
        PlaneTriangle moved = beside;
        for (glm::dvec2& p : moved) p -= deep * tolerance * glm::dvec2(std::sqrt(0.5));
        CHECK(overlap(a, moved, tolerance) == (deep > 1));
    }
    // One inside the other: no sides cross.
    CHECK(overlap(a, {glm::dvec2(0.2, 0.2), {0.3, 0.2}, {0.2, 0.3}}, 0));
}

TEST_CASE("overlap: any_overlap finds one pair among many, and none in a grid", "[probes][overlap]") {
    std::vector<PlaneTriangle> grid;
    const int n = 60;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const glm::dvec2 a(x / 7.0, y / 3.0), b((x + 1) / 7.0, y / 3.0), c((x + 1) / 7.0, (y + 1) / 3.0),
                d(x / 7.0, (y + 1) / 3.0);
            grid.push_back({a, b, c}), grid.push_back({a, c, d});
        }
    CHECK_FALSE(any_overlap(grid, 1e-9));
    test::Dice dice(2);
    for (int i = 0; i < 50; ++i) {
        // A small triangle in the middle of one that is there: too little area to be told by its sum.
        auto more = grid;
        more.erase(more.begin() + dice.below(int(more.size())));
        const PlaneTriangle host = more[std::size_t(dice.below(int(more.size())))];
        const glm::dvec2 middle = (host[0] + host[1] + host[2]) / 3.0;
        more.push_back({middle, middle + glm::dvec2(1e-4, 0), middle + glm::dvec2(0, 1e-4)});
        CHECK(any_overlap(more, 1e-9));
    }
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        test::Dice few(seed);
        std::vector<PlaneTriangle> some;
        for (int i = 0; i < 30; ++i) some.push_back(random_triangle(few, 0.06f));
        bool truth = false;
        for (std::size_t i = 0; i < some.size(); ++i)
            for (std::size_t k = 0; k < i; ++k) truth = truth || overlap(some[i], some[k], 1e-9);
        CHECK(any_overlap(some, 1e-9) == truth);
    }
}

TEST_CASE("overlap: a fan of many needles is decided in no time, and one needle too many is found",
          "[probes][overlap]") {
    // The hub lies where boxes are cut, and where they are not.
    const int n = 20000;
    for (const glm::dvec2& hub : {glm::dvec2(0, 0), glm::dvec2(0.3, 0.17)}) {
        auto rim = [&](double i) {
            return hub + glm::dvec2(host::cos(2 * host::pi * i / n), host::sin(2 * host::pi * i / n));
        };
        std::vector<PlaneTriangle> fan;
        std::vector<glm::dvec2> corners;
        for (int i = 0; i < n; ++i) corners.push_back(rim(i));
        for (int i = 0; i < n; ++i) fan.push_back({hub, corners[std::size_t(i)], corners[std::size_t((i + 1) % n)]});
        CHECK_FALSE(any_overlap(fan, 1e-12));
        // The sum of the areas tells nothing: the rim's square is larger by 4/pi.
        for (const double at : {0.5, n / 2 - 0.4, 0.77 * n}) {
            auto more = fan;
            more.push_back({hub, rim(at), rim(at + 1)});
            CHECK(any_overlap(more, 1e-12));
            more.back() = {hub, rim(at), rim(at + 100)};
            CHECK(any_overlap(more, 1e-12));
            more.back() = {rim(at), rim(at + 1), 0.5 * (hub + rim(at + 3))};
            CHECK(any_overlap(more, 1e-12));
        }
    }
}

TEST_CASE("overlap: in a fan, triangles below the tolerance hide none behind them", "[probes][overlap]") {
    // Needles of the upper half; below it sectors of a tenth of a turn, from and to in tenths, and their length.
    std::vector<PlaneTriangle> needles;
    auto rim = [](double tenths) {
        return glm::dvec2(host::cos(host::pi * tenths / 5), host::sin(host::pi * tenths / 5));
    };
    for (int i = 0; i < 500; ++i) needles.push_back({glm::dvec2(0), rim(i / 100.0), rim((i + 1) / 100.0)});
    auto with = [&](const std::vector<glm::dvec3>& sectors) {
        auto all = needles;
        for (const glm::dvec3& s : sectors) all.push_back({glm::dvec2(0), rim(s.x) * s.z, rim(s.y) * s.z});
        return any_overlap(all, 1e-6);
    };
    CHECK_FALSE(with({{5.5, 6, 1}, {6, 7, 1}, {7, 9, 1}}));
    CHECK(with({{5.1, 5.4, 1},
                {5.5, 8.5, 1},
                {6, 7, 1e-8},
                {7.5, 9, 1}}));  // the last overlaps the one before the one before it
    CHECK(with(
        {{5.5, 9.5, 1e-8}, {6, 8, 1}, {7, 9, 1}}));  // and here the one before it, not the one that reaches farthest
    CHECK_FALSE(with({{5.5, 9.5, 1e-8}, {6, 7, 1}, {7, 9, 1}}));
}

TEST_CASE("overlap: a cover takes what overlaps nothing, whole groups or none", "[probes][overlap]") {
    int taken = 0, refused = 0;
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        test::Dice dice(seed);
        PlaneCover cover({0, 0}, {1, 1}, 40, 1e-9);
        std::vector<PlaneTriangle> inside;
        for (int i = 0; i < 20; ++i) {
            std::vector<PlaneTriangle> group;
            for (int k = 0; k < 1 + dice.below(3); ++k) group.push_back(random_triangle(dice, 0.1f));
            auto all = inside;
            all.insert(all.end(), group.begin(), group.end());
            bool free = true;
            for (std::size_t k = inside.size(); k < all.size(); ++k)
                for (std::size_t j = 0; j < k; ++j) free = free && !overlap(all[k], all[j], 1e-9);
            REQUIRE(cover.add(group) == free);
            ++(free ? taken : refused);
            if (free) inside = all;
        }
    }
    CHECK(taken > 100);
    CHECK(refused > 100);
}
