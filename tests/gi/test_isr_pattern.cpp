// Where samples of image-space radiosity lie, and how many patches each stands for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "gi/isr/isr.h"

using namespace plumb;
using namespace plumb::isr;

TEST_CASE("isr: rings of the square grid, the nearest first, each pixel once", "[isr][ISR 5.3.1][pattern]") {
    for (int rings : {1, 2, 3, 4, 10})
        for (float spacing : {1.0f, 1.5f, 2.0f, 4.0f, 7.3f})
            for (int rotations : {1, 4, 16}) {
                CAPTURE(rings, spacing, rotations);
                IsrParams params;
                params.rings = rings, params.spacing = spacing, params.rotations = rotations;
                const Pattern p = gather_pattern(params, 20);
                REQUIRE(p.samples == (2 * rings + 1) * (2 * rings + 1) - 1);
                REQUIRE(p.offsets.size() == std::size_t(p.samples * rotations));
                std::set<std::int32_t> seen;
                int reach = 0, k = 0;
                for (int r = 1; r <= rings; ++r)
                    for (int i = 0; i < 8 * r; ++i, ++k)
                        for (int turn = 0; turn < rotations; ++turn) {
                            const std::int32_t packed = p.offsets[std::size_t(k * rotations + turn)];
                            const int dx = std::int16_t(packed & 0xffff), dy = packed >> 16;
                            CHECK(packed != 0);
                            reach = std::max({reach, std::abs(dx), std::abs(dy)});
                            if (turn > 0) continue;
                            CHECK(seen.insert(packed).second);
                            CHECK(std::abs(std::max(std::abs(dx), std::abs(dy)) - r * double(spacing)) <= 0.5);
                        }
                CHECK(p.reach == reach);
            }
    CHECK(gather_pattern({}, 20).samples == 80);
    CHECK(ssao_pattern({}).samples == 24);
}

TEST_CASE("isr: rings of growing radius stand for a disc as wide as the reach, and no sample is the receiver",
          "[isr][pattern][analytic]") {
    for (int rings : {1, 2, 4, 9})
        for (int height : {1, 10, 64, 512})
            for (float growth : {1.0f, 2.0f, 4.0f}) {
                CAPTURE(rings, height, growth);
                IsrParams params;
                params.rings = rings, params.reach = 0.7f, params.growth = growth;
                const Pattern p = gather_pattern(params, height);
                REQUIRE((p.samples == sample_count(rings) && p.rotations == 64 && p.side == 1));
                REQUIRE((p.offsets.size() == std::size_t(64 * p.samples) && p.weights.size() == std::size_t(p.samples)));
                // Rings are a pixel wide at least; the receiver's own pixel belongs to none.
                const double radius = std::max(double(params.reach) * height, 1 / std::sqrt(M_PI) + rings);
                double sum = 1, before = 0;
                for (int k = 0; k < p.samples; ++k) {
                    // All rotations of a sample lie on the circle that halves its annulus, a 64th of a turn apart, within rounding.
                    const double inner = std::sqrt(sum / M_PI), middle = std::sqrt((sum + double(p.weights[std::size_t(k)]) / 2) / M_PI);
                    sum += double(p.weights[std::size_t(k)]);
                    CHECK((middle > inner && middle > before));
                    before = middle;
                    for (int turn = 0; turn < 64; ++turn) {
                        const std::int32_t packed = p.offsets[std::size_t(64 * k + turn)];
                        const double dx = std::int16_t(packed & 0xffff), dy = packed >> 16;
                        CHECK(packed != 0);
                        CHECK(std::abs(std::hypot(dx, dy) - middle) <= 0.7072);
                        CHECK(std::max(std::abs(dx), std::abs(dy)) <= p.reach);
                    }
                }
                CHECK(sum == Approx(M_PI * radius * radius).epsilon(1e-5).margin(1e-4));
                CHECK(p.reach <= radius + 0.5);
            }
}

TEST_CASE("isr: a tile deals out every rotation once, neighbours differ most", "[isr][pattern]") {
    for (int tile : {2, 4, 8, 16, 32}) {
        CAPTURE(tile);
        SampleUniforms u{};
        u.tile = tile, u.rotations = tile * tile, u.seed = 7;
        CHECK(tile_of(u.rotations) == tile);
        const auto rotation = [&](int x, int y) { return rotation_of<float>(u, x, y); };
        std::vector<int> times(std::size_t(u.rotations));
        for (int y = 0; y < tile; ++y)
            for (int x = 0; x < tile; ++x) {
                const int r = rotation(x, y);
                REQUIRE((r >= 0 && r < u.rotations));
                ++times[std::size_t(r)];
                CHECK((rotation(x + 3 * tile, y) == r && rotation(x, y + 5 * tile) == r));
                // Bayer's matrix: M of twice the side is 4 M of the quarter, plus 0, 2, 3, 1.
                SampleUniforms half = u;
                half.tile = tile / 2, half.rotations = u.rotations / 4;
                const int quarters[2][2] = {{0, 2}, {3, 1}};
                const int coarse = tile == 2 ? 0 : rotation_of<float>(half, x / 2, y / 2);
                CHECK(r == quarters[y % 2][x % 2] * u.rotations / 4 + coarse);
            }
        CHECK(std::count(times.begin(), times.end(), 1) == u.rotations);
    }
    for (int rotations : {1, 2, 8, 32, 128, 512}) CHECK(tile_of(rotations) == (rotations == 1 ? 1 : 0));
}

TEST_CASE("isr: what a pattern leaves open follows from what is said", "[isr][pattern]") {
    const auto of = [](auto set) {
        IsrParams params;
        set(params);
        validate(params);
        return resolved(params);
    };
    const IsrParams plain = of([](IsrParams&) {});
    CHECK((plain.pattern == PatternKind::rings && plain.rotations == 64 && plain.turn == Turn::tile));
    CHECK((plain.blur == Blur::edge_aware && plain.blur_radius == 8 && plain.blur_sigma == 4));
    const IsrParams eight = of([](IsrParams& p) { p.rotations = 8, p.position = Position::inverse_matrix, p.blur_sigma = 3; });
    CHECK((eight.turn == Turn::hash && eight.blur == Blur::gaussian && eight.blur_radius == 4 && eight.blur_sigma == 3));
    // As scene files said before there were rings: the grid, without rotations.
    const IsrParams spaced = of([](IsrParams& p) { p.spacing = 32; });
    CHECK((spaced.pattern == PatternKind::grid && spaced.rotations == 1 && spaced.spacing == 32));
    const IsrParams printed = of([](IsrParams& p) { p.variant = Variant::published; });
    CHECK((printed.pattern == PatternKind::grid && printed.rotations == 1 && printed.spacing == 8 && printed.turn == Turn::hash));
    CHECK((printed.blur == Blur::gaussian && printed.blur_radius == 4 && printed.blur_sigma == 2));
    const IsrParams grid = of([](IsrParams& p) { p.pattern = PatternKind::grid, p.rotations = 4; });
    CHECK((grid.pattern == PatternKind::grid && grid.rotations == 4 && grid.spacing == 0));
    // The grid by reach: (4 + 1/2) spacings are the reach; and never below a pixel.
    CHECK(gather_pattern(grid, 90).side == Approx(double(grid.reach) * 90 / 4.5));
    CHECK(gather_pattern(grid, 2).side == 1);
    IsrParams bad;
    bad.spacing = 0.5f;
    CHECK_THROWS_WITH(validate(bad), "isr: spacing = 0.5: expected 0, or 1 to 255");
    bad.spacing = 8, bad.pattern = PatternKind::rings;
    CHECK_THROWS_WITH(validate(bad), Catch::Contains("spacing = 8 with pattern = rings"));
    bad.rotations = 8, bad.spacing = 0, bad.turn = Turn::tile;
    CHECK_THROWS_WITH(validate(bad), Catch::Contains("turn = tile with rotations = 8"));
    bad.rotations = 0, bad.turn = Turn::automatic, bad.blur_sigma = 1e-4f;
    CHECK_THROWS_WITH(validate(bad), Catch::Contains("blur_sigma"));
    bad.blur_sigma = 0, bad.variant = Variant::published;
    CHECK_THROWS_WITH(validate(bad), Catch::Contains("pattern = rings with variant = published"));
}
