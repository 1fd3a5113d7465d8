// The plot of debug layers: where curves, axes and labels lie.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/probes/plot.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

constexpr glm::vec4 red(1, 0, 0, 1), white(1);

int count(const Image4& picture, glm::ivec2 low, glm::ivec2 high, const glm::vec4& colour) {
    int n = 0;
    for (int y = low.y; y < high.y; ++y)
        for (int x = low.x; x < high.x; ++x) n += picture(x, y) == colour;
    return n;
}

}  // namespace

TEST_CASE("plot: a curve lies between the axes' ends, and what is beyond them nowhere", "[probes][plot]") {
    const glm::ivec2 size(320, 200);
    Plot plot(size, {});
    plot.curve({{0, 0}, {1, 1}}, red);
    const Image4& p = plot.picture();
    // The plane of curves: 56 texels left of it, 16 right, 24 above, 40 below.
    CHECK(p(56, 160) == red);
    CHECK(p(304, 24) == red);
    CHECK(p(180, 92) == red);  // its middle
    CHECK(count(p, {0, 0}, size, red) >= 249);  // a texel a column, at least
    Plot beyond(size, {});
    beyond.curve({{-1, 0.5}, {2, 0.5}}, red);  // a level line: its part inside
    CHECK(count(beyond.picture(), {0, 0}, size, red) == 249);
    CHECK(count(beyond.picture(), {56, 92}, {305, 93}, red) == 249);
    Plot none(size, {});
    none.curve({{0, 2}, {1, 3}}, red);
    none.curve({{0.5, 0.5}}, red);  // one point is no line
    none.curve({{std::nan(""), 0}, {1, std::nan("")}}, red);
    CHECK(count(none.picture(), {0, 0}, size, red) == 0);
}

TEST_CASE("plot: ticks and labels stand at their places", "[probes][plot]") {
    const glm::ivec2 size(320, 200);
    const Plot bare(size, {}), ticked(size, {.across = {{0.5, "8"}}, .upwards = {{1, "1e-2"}}, .across_name = "i", .upwards_name = "si/s1"});
    const auto changed = [&](glm::ivec2 low, glm::ivec2 high) {
        int n = 0;
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x) n += bare.picture()(x, y) != ticked.picture()(x, y);
        return n;
    };
    CHECK(changed({180, 24}, {181, 160}) == 136);  // a pale line, from the top to the axis
    // An 8 has 13 of 15 cells of 2 x 2 texels, beneath the tick; the name of the axis is an i: 4 cells.
    CHECK(changed({170, 165}, {190, 180}) == 4 * 13);
    CHECK(changed({170, 182}, {190, 200}) == 4 * 4);
    CHECK(changed({0, 15}, {48, 34}) > 4 * 20);  // 1e-2, left of the upper end
    CHECK(changed({0, 0}, {48, 15}) > 4 * 20);   // si/s1
    CHECK(changed({0, 40}, {48, 200}) == 0);
    CHECK(count(bare.picture(), {0, 0}, size, white) > 320 * 200 - 600);
}
