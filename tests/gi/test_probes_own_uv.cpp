// A mesh's own coordinates, and the packing of charts.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "gi/probes/own_uv.h"
#include "gi/probes/pack.h"
#include "tests/gi/chart_meshes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

TEST_CASE("own coordinates: kept where they do not overlap, scaled by the mean edge ratio", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_quad(mesh, {0, 0, 0}, {2, 0, 0}, {0, 0, -1}, 0);  // 2 m x 1 m
    const float uv[4][2] = {{0.25f, 0.75f}, {0.75f, 0.75f}, {0.75f, 0.25f}, {0.25f, 0.25f}};
    for (std::size_t k = 0; k < 4; ++k) set_uv(mesh, k, uv[k][0], uv[k][1]);
    const UvIslands islands = judge_own_uv(Surface(mesh).mesh);
    REQUIRE(islands.verdict == OwnUv::kept);
    // Two edges of 2 m, two of 1 m and a diagonal of sqrt 5, all over edges of 1/2 and a diagonal of sqrt(1/2).
    CHECK(islands.metres == Approx((2 * 4 + 2 * 2 + std::sqrt(10.0)) / 5).epsilon(1e-12));
    CHECK(islands.count == 1);
    CHECK(islands.mirrored == 0);
    for (std::size_t k = 0; k < 4; ++k) set_uv(mesh, k, -uv[k][0], uv[k][1]);
    CHECK(judge_own_uv(Surface(mesh).mesh).mirrored == 1);
}

TEST_CASE("own coordinates: a ball's map of longitude and latitude is kept", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {0, 0, 0}, 1, 16, 0);
    const UvIslands islands = judge_own_uv(Surface(mesh).mesh);
    CHECK(islands.verdict == OwnUv::kept);
    CHECK(islands.count == 1);
    // A radian of latitude is 1/pi of the map; of longitude, 1/(2 pi) at most: the mean of edges lies between.
    CHECK(islands.metres > host::pi / 2);
    CHECK(islands.metres < 2 * host::pi);
}

TEST_CASE("own coordinates: refused where absent, degenerate, not finite, stretched or overlapping",
          "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
    test::add_quad(mesh, {1, 0, 0}, {2, 0, 0}, {1, 0, -1}, 0);
    auto verdict = [](const Mesh& m) { return judge_own_uv(Surface(m).mesh).verdict; };
    CHECK(verdict(mesh) == OwnUv::overlapping);  // both have the whole square

    Mesh mirrored = mesh;  // the second is the first one's mirror image, about the edge between them
    for (std::size_t k = 4; k < 8; ++k) mirrored.vertices[k].u = 1 - mirrored.vertices[k].u;
    CHECK(verdict(mirrored) == OwnUv::overlapping);

    Mesh beside = mesh;
    for (std::size_t k = 4; k < 8; ++k) beside.vertices[k].u += 1;
    CHECK(verdict(beside) == OwnUv::kept);
    for (std::size_t k = 4; k < 8; ++k) beside.vertices[k].u -= 0x1p-24f;  // a rounding of the largest coordinate
    CHECK(verdict(beside) == OwnUv::kept);
    for (std::size_t k = 4; k < 8; ++k) beside.vertices[k].u -= 0x1p-16f;
    CHECK(verdict(beside) == OwnUv::overlapping);

    Mesh none = mesh;
    for (Vertex& v : none.vertices) v.u = v.v = 0;
    CHECK(verdict(none) == OwnUv::degenerate);
    Mesh line = mesh;
    for (Vertex& v : line.vertices) v.v = v.u;
    CHECK(verdict(line) == OwnUv::degenerate);
    for (float bad : {std::nanf(""), HUGE_VALF}) {
        Mesh broken = beside;
        broken.vertices[2].v = bad;
        CHECK(verdict(broken) == OwnUv::degenerate);
    }
    // A square, and small ones beside it, each with metres and coordinates of its own.
    auto two_squares = [](float large, float large_uv, float small, float small_uv, int smalls) {
        Mesh m;
        test::add_quad(m, {0, 0, 0}, {large, 0, 0}, {0, 0, -large}, 0);
        for (int i = 0; i < smalls; ++i) {
            const glm::vec3 at(float(i), 5, 0);
            test::add_quad(m, at, at + glm::vec3(small, 0, 0), at - glm::vec3(0, 0, small), 0);
        }
        for (std::size_t k = 0; k < m.vertices.size(); ++k) {
            Vertex& v = m.vertices[k];
            const float size = k < 4 ? large_uv : small_uv;
            v.u = v.u * size + (k < 4 ? 0 : large_uv + float(k / 4) * 2 * small_uv), v.v *= size;
        }
        return m;
    };
    // 1 and 10 in a mesh of ten small ones: the mean is 9.2, so the large one takes 9.2^2 = 84 times its area.
    CHECK(verdict(two_squares(10, 10, 0.1f, 0.01f, 10)) == OwnUv::stretched);
    // 10 and 1 with ten small ones: the mean is 1.8, and a texel of the large one covers 10.
    CHECK(verdict(two_squares(0.1f, 0.01f, 0.1f, 0.1f, 10)) == OwnUv::stretched);
    CHECK(verdict(two_squares(0.1f, 0.1f, 0.1f, 0.1f, 10)) == OwnUv::kept);
}

TEST_CASE("packing: the rules of figures 3.7 and 3.8", "[probes][IPR 3.2.1.1]") {
    auto squares = [](int n, int side) {
        return std::vector<RectangleToPack>(std::size_t(n), RectangleToPack{{side, side}, {}});
    };
    const int gap = 3, s = 10, step = s + gap;
    CHECK(pack_rectangles(squares(1, s), gap, 0, 1000).side == s);
    // The second goes to the bottom right corner, the third and fourth to the free space, the fifth to the corner
    // again.
    const Packing five = pack_rectangles(squares(5, s), gap, 0, 1000);
    REQUIRE(five.placed.size() == 5);
    CHECK(five.side == 3 * s + 2 * gap);
    CHECK(five.placed[0].origin == glm::ivec2(0));
    CHECK(five.placed[1].origin == glm::ivec2(step));
    std::set<std::pair<int, int>> others;
    for (int i : {2, 3}) others.insert({five.placed[std::size_t(i)].origin.x, five.placed[std::size_t(i)].origin.y});
    CHECK(others == std::set<std::pair<int, int>>{{0, step}, {step, 0}});
    CHECK(five.placed[4].origin == glm::ivec2(2 * step));
    CHECK(pack_rectangles(squares(9, s), gap, 0, 1000).side == 3 * s + 2 * gap);

    CHECK(pack_rectangles(squares(9, s), gap, 3 * s + 2 * gap, 1000).placed.size() == 9);
    CHECK(pack_rectangles(squares(9, s), gap, 3 * s + 2 * gap - 1, 1000).placed.empty());
    CHECK(pack_rectangles(squares(5, s), gap, 0, 3 * s + 2 * gap - 1).placed.empty());
    // The canvas grows to where it stays nearest to a square.
    CHECK(pack_rectangles({{{40, 2}, {}}, {{40, 2}, {}}}, 1, 0, 1000).side == 43);
    // A long one is turned to stay inside.
    CHECK(pack_rectangles({{{50, 1}, {}}, {{1, 50}, {}}, {{47, 50}, {}}}, 1, 51, 51).placed.size() == 3);
}

TEST_CASE("packing: nothing is nearer than the gap, and little is left", "[probes][IPR 3.2.1.1]") {
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        test::Dice dice(seed);
        const int gap = dice.below(5), n = 1 + dice.below(300), largest = 1 + dice.below(40);
        std::vector<RectangleToPack> rectangles;
        double area = 0;
        for (int i = 0; i < n; ++i) {
            const int w = 1 + dice.below(largest), h = 1 + dice.below(largest);
            rectangles.push_back({{w, h}, {}});
            if (w > 12 && h > 12) rectangles.back().holes = {{{2, 3}, {w - 7, h - 8}}};
            area += double(w + gap) * (h + gap);
        }
        const Packing rules = pack_rectangles(rectangles, gap, 0, 16384), packing = pack_closer(rectangles, gap, rules);
        REQUIRE(packing.placed.size() == rectangles.size());
        CHECK(packing.side <= rules.side);
        // Texels that a rectangle takes: all but its hole.
        Image<int> taken(packing.side, packing.side, -1);
        int outside = 0, twice = 0, near = 0;
        for (int i = 0; i < n; ++i) {
            const RectangleToPack& r = rectangles[std::size_t(i)];
            const PackedRectangle& p = packing.placed[std::size_t(i)];
            for (int y = 0; y < r.size.y; ++y)
                for (int x = 0; x < r.size.x; ++x) {
                    bool hole = false;
                    for (const TexelHole& h :
                         r.holes)  // widened by the gap: where others are at least that far from this
                        hole = hole || (x >= h.origin.x - gap && x < h.origin.x + h.size.x + gap &&
                                        y >= h.origin.y - gap && y < h.origin.y + h.size.y + gap);
                    if (hole) continue;
                    const glm::ivec2 at = p.origin + (p.turned ? glm::ivec2(r.size.y - 1 - y, x) : glm::ivec2(x, y));
                    const bool inside = at.x >= 0 && at.y >= 0 && at.x < packing.side && at.y < packing.side;
                    outside += !inside;
                    if (!inside) continue;
                    twice += taken(at.x, at.y) >= 0;
                    taken(at.x, at.y) = i;
                }
        }
        for (int y = 0; y < packing.side; ++y)
            for (int x = 0; x < packing.side; ++x)
                for (int dy = 0; dy <= gap && y + dy < packing.side && taken(x, y) >= 0; ++dy)
                    for (int dx = -gap; dx <= gap; ++dx) {
                        if (x + dx < 0 || x + dx >= packing.side || taken(x + dx, y + dy) < 0) continue;
                        near += taken(x + dx, y + dy) != taken(x, y);
                    }
        CHECK(outside == 0);
        CHECK(twice == 0);
        CHECK(near == 0);
        if (n >= 100) CHECK(area / double(packing.side + gap) / (packing.side + gap) > 0.85);
    }
}
