// probes.level, and levels of points: closed forms, and that what lies in a box has its level or a coarser one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "gi/probes/level.h"

using namespace plumb;
using namespace plumb::probes;
using Catch::Matchers::Contains;

namespace {

float noise(std::uint32_t i, std::uint32_t seed) { return float(pcg(i + 7919 * seed) & 0xffffff) / 16777216.0f; }

// Levels begin at 2, 4 and 8 m. Front within 60 degrees, behind beyond 120: cosines +-1/2, sines sqrt(3)/2.
LevelRule doubling(bool zones = false) {
    LevelRule r;
    r.levels = 4;
    r.distances = {2, 4, 8, 0}, r.widths = {1, 0.5f, 4, 0}, r.margins = {1, 2, 4, 0};
    if (zones) r.zones = {0.5f, 0.8660254f, -0.5f, 0.8660254f}, r.scales = {1, 2, 4, 0};
    return r;
}

std::vector<std::int32_t> levels_of(const Buffer<glm::vec4>& low, const Buffer<glm::vec4>& high, const LevelRule& rule,
                                    const RunOptions& options = {}) {
    std::vector<std::int32_t> levels;
    run(LevelInputs{&low, &high, rule}, options, levels);
    return levels;
}
int level_of_box(const glm::vec3& low, const glm::vec3& high, const LevelRule& rule, float margin = 0) {
    return levels_of({glm::vec4(low, margin)}, {glm::vec4(high, 0)}, rule)[0];
}

struct Case {
    LevelRule rule;
    glm::vec3 low, high;
    float margin;
};
// Cameras and boxes of any size, near and far, some around the camera.
Case random_case(std::uint32_t i) {
    Case c{doubling(i % 2 == 1), {}, {}, 0.3f * noise(i, 90)};
    const float spread = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 12.0f : 100.0f;
    glm::vec3 forward;
    for (int a = 0; a < 3; ++a) {
        const std::uint32_t s = std::uint32_t(a);
        c.rule.eye[a] = spread * (noise(i, s) - 0.5f);
        forward[a] = noise(i, 10 + s) - 0.5f;
        c.low[a] = spread * (noise(i, 20 + s) - 0.5f);
        c.high[a] = c.low[a] + (i % 5 == 0 ? 0 : 4 * noise(i, 30 + s));
    }
    c.rule.forward = glm::vec4(forward / std::sqrt(glm::dot(forward, forward)), 0);
    return c;
}

}  // namespace

TEST_CASE("probes.level: a box has the level of its nearest point", "[probes][IPR 4.2.2][analytic]") {
    const LevelRule rule = doubling();
    // Faces, an edge and a corner at a distance d: (d, 0, 0), d (3/5, 4/5, 0), d (2/7, 3/7, 6/7), of which floats are exact for 5 and 7.
    CHECK(level_of_box({-1, -1, -1}, {1, 1, 1}, rule) == 0);  // the eye is in it
    CHECK(level_of_box({1.99f, -9, -9}, {20, 9, 9}, rule) == 0);
    CHECK(level_of_box({2, -9, -9}, {20, 9, 9}, rule) == 1);  // a level begins at its distance
    CHECK(level_of_box({-20, -9, -9}, {-4, 9, 9}, rule) == 2);
    CHECK(level_of_box({-9, 7.99f, -9}, {9, 8.5f, 9}, rule) == 2);
    CHECK(level_of_box({-9, -9, -8.5f}, {9, 9, -8}, rule) == 3);
    CHECK(level_of_box({3, 4, -1}, {9, 9, 1}, rule) == 2);     // 5 m
    CHECK(level_of_box({-9, 2, 3}, {-6, 9, 9}, rule) == 2);    // 7 m
    CHECK(level_of_box({4, 4, 7}, {9, 9, 9}, rule) == 3);      // 9 m
    CHECK(level_of_box({1e9f, 0, 0}, {2e9f, 0, 0}, rule) == 3);
}

TEST_CASE("probes.level: no level beyond the last, and none that begins where the next does", "[probes][IPR table 5.10][analytic]") {
    LevelRule rule = doubling();
    rule.levels = 2;
    CHECK(level_of_box({100, 0, 0}, {101, 1, 1}, rule) == 1);
    rule.levels = 1;
    CHECK(level_of_box({100, 0, 0}, {101, 1, 1}, rule) == 0);
    rule.levels = 4, rule.distances = {0, 12, 30.5f, 0};  // setup D2: level 0 is never computed
    CHECK(level_of_box({-1, -1, -1}, {1, 1, 1}, rule) == 1);
    rule.distances = {0, 0, 0, 0};
    CHECK(level_of_box({-1, -1, -1}, {1, 1, 1}, rule) == 3);
}

TEST_CASE("probes.level: a margin brings each boundary nearer by its multiple", "[probes][IPR figure 4.7][analytic]") {
    const LevelRule rule = doubling();  // 2 + w, 4 + 2 w, 8 + 4 w
    for (const float w : {0.25f, 0.5f}) {
        CAPTURE(w);
        const auto at = [&](float d) { return level_of_box({d, 0, 0}, {d + 1, 1, 1}, rule, w); };
        CHECK(at(2 + w - 0.01f) == 0);
        CHECK(at(2 + w) == 1);
        CHECK(at(4 + 2 * w - 0.01f) == 1);
        CHECK(at(4 + 2 * w) == 2);
        CHECK(at(8 + 4 * w - 0.01f) == 2);
        CHECK(at(8 + 4 * w) == 3);
        // A probe: its distance less its radius.
        LevelRule probe = rule;
        probe.margins = {1, 1, 1, 0};
        CHECK(level_of_box({8 + w, 0, 0}, {8 + w, 0, 0}, probe, w) == 3);
        CHECK(level_of_box({7.99f + w, 0, 0}, {7.99f + w, 0, 0}, probe, w) == 2);
    }
}

TEST_CASE("probes.level: distances count twice at the side, four times behind", "[probes][IPR figure 4.8][analytic]") {
    const LevelRule rule = doubling(true);  // looks along -z
    const auto at = [&](double degrees, float d) {
        const double a = degrees * 3.14159265358979 / 180;
        return level_at(rule, {float(d * std::sin(a)), 0, float(-d * std::cos(a))}).level;
    };
    for (const double sign : {1.0, -1.0})
        for (const double front : {0.0, 30.0, 59.9}) {
            CHECK(at(sign * front, 1.99f) == 0);
            CHECK(at(sign * front, 2.01f) == 1);
        }
    for (const double side : {60.1, 90.0, -119.9}) {
        CHECK(at(side, 0.99f) == 0);
        CHECK(at(side, 1.01f) == 1);
        CHECK(at(side, 4.01f) == 3);
    }
    for (const double back : {120.1, -150.0, 180.0}) {
        CHECK(at(back, 0.49f) == 0);
        CHECK(at(back, 0.51f) == 1);
        CHECK(at(back, 2.01f) == 3);
    }
    // A box that reaches into the front's zone is of it, however far the rest of it lies behind.
    CHECK(level_of_box({-9, -9, 1.9f}, {9, 9, 9}, rule) == 0);
    CHECK(level_of_box({-0.1f, -0.1f, 2.1f}, {0.1f, 0.1f, 2.3f}, rule) == 3);
}

TEST_CASE("blend_of: a fragment takes the next level's share over the width before its distance", "[probes][IPR 4.2.4][analytic]") {
    const LevelRule rule = doubling();  // widths 1, 1/2, 4
    const auto at = [&](float d) { return level_at(rule, {0, d, 0}); };
    CHECK(at(0).share == 0);
    CHECK(at(1).share == 0);
    CHECK(at(1.25f).share == 0.25f);
    CHECK(at(1.75f).share == 0.75f);
    CHECK(at(2).level == 1);
    CHECK(at(2).share == 0);
    CHECK(at(3.5f).share == 0);
    CHECK(at(3.75f).share == 0.5f);
    CHECK(at(5).share == 0.25f);
    CHECK(at(7).share == 0.75f);
    CHECK(at(100).share == 0);  // there is no next
    LevelRule sharp = rule;
    sharp.widths = glm::vec4(0);
    CHECK(level_at(sharp, {0, 1.9999999f, 0}).share == 0);
    sharp = rule, sharp.levels = 2;
    CHECK(level_at(sharp, {0, 3.75f, 0}).share == 0);
}

TEST_CASE("levels and shares together never step back, and jump nowhere", "[probes][IPR 4.2.4]") {
    const LevelRule rule = doubling();
    float before = 0;
    for (int i = 0; i <= 10000; ++i) {
        const PointLevel l = level_at(rule, {0, 0, 0.001f * float(i)});
        const float now = float(l.level) + l.share;
        REQUIRE(now >= before);
        REQUIRE(now - before < 0.0021f);  // a millimetre over half a metre, the narrowest width, and rounding
        before = now;
    }
    CHECK(before == 3);
}

TEST_CASE("what lies in a box has the box's level or a coarser one, in any view", "[probes][IPR 4.2.3]") {
    // Of c > k follows: no point within margin m_k of the box has level k or a finer one. So each fragment that reads the cluster in
    // level k, from that far at most, finds it computed.
    std::int64_t finer = 0, asked = 0, zones_met = 0;
    for (std::uint32_t i = 0; i < 40000; ++i) {
        const Case c = random_case(i);
        const int box = level_of_box(c.low, c.high, c.rule, c.margin);
        for (std::uint32_t j = 0; j < 8; ++j) {
            const int k = int(j % 4);
            glm::vec3 p, away;
            for (int a = 0; a < 3; ++a) {
                const float t = j < 4 ? noise(8 * i + j, 40 + std::uint32_t(a)) : float(pcg(8 * i + j + std::uint32_t(a)) & 1);
                p[a] = std::clamp(c.low[a] + t * (c.high[a] - c.low[a]), c.low[a], c.high[a]);
                away[a] = noise(8 * i + j, 50 + std::uint32_t(a)) - 0.5f;
            }
            // Within the margin but for the thousandth that lod_boxes() adds.
            if (k < 3) p += away * (0.999f * c.margin * c.rule.margins[k] / std::sqrt(glm::dot(away, away)));
            const int point = level_at(c.rule, p).level;
            ++asked;
            finer += box > k && point <= k ? 1 : 0;
            zones_met += point != level_at(doubling(), p - glm::vec3(c.rule.eye)).level ? 1 : 0;
        }
    }
    CHECK(asked == 320000);
    CHECK(zones_met > 20000);
    CHECK(finer == 0);
}

TEST_CASE("probes.level: points of a list have the level that level_at has", "[probes]") {
    Buffer<glm::vec4> points;
    const LevelRule rule = [] {
        LevelRule r = random_case(7).rule;
        r.eye = {0.5f, 0.25f, 0.5f, 0};
        return r;
    }();
    for (std::uint32_t i = 0; i < 3000; ++i) points.push_back({8 * noise(i, 1) - 4, 8 * noise(i, 2) - 4, 8 * noise(i, 3) - 4, 0});
    std::vector<std::int32_t> expected;
    for (const glm::vec4& p : points) expected.push_back(level_at(rule, glm::vec3(p)).level);
    for (int level = 0; level < 4; ++level) CHECK(std::count(expected.begin(), expected.end(), level) > 20);
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            CAPTURE(isa_name(isa), threads);
            CHECK(levels_of(points, points, rule, options) == expected);
        }
}

TEST_CASE("probes.level: says what it cannot use", "[probes][refusal]") {
    const auto refusal = [](const Buffer<glm::vec4>& low, const Buffer<glm::vec4>& high, const LevelRule& rule, const std::string& says) {
        CAPTURE(says);
        CHECK_THROWS_WITH(levels_of(low, high, rule), Contains(says));
    };
    const Buffer<glm::vec4> one = {{0, 0, 0, 0}};
    const LevelRule good = doubling();
    refusal({}, {}, good, "no boxes");
    refusal(one, {}, good, "1 low corners and 0 high ones");
    refusal({{1, 0, 0, 0}}, one, good, "box 0: low is above high");
    refusal({{NAN, 0, 0, 0}}, one, good, "box 0: expected coordinates");
    refusal(one, {{INFINITY, 0, 0, 0}}, good, "box 0: expected coordinates");
    refusal({{0, 0, 0, -1}}, one, good, "margin -1");
    refusal({{0, 0, 0, NAN}}, one, good, "margin nan");
    const auto with = [&](auto change) {
        LevelRule r = good;
        change(r);
        return r;
    };
    refusal(one, one, with([](LevelRule& r) { r.levels = 5; }), "levels");
    refusal(one, one, with([](LevelRule& r) { r.levels = 0; }), "levels");
    refusal(one, one, with([](LevelRule& r) { r.forward = {0, 0, -2, 0}; }), "forward: expected a unit vector");
    refusal(one, one, with([](LevelRule& r) { r.forward = glm::vec4(NAN); }), "forward: expected a unit vector");
    refusal(one, one, with([](LevelRule& r) { r.eye.x = NAN; }), "eye");
    refusal(one, one, with([](LevelRule& r) { r.distances = {2, 1, 3, 0}; }), "distances: expected ascending");
    refusal(one, one, with([](LevelRule& r) { r.scales = {1, 4, 2, 0}; }), "scales: expected ascending");
    refusal(one, one, with([](LevelRule& r) { r.margins = {2, 1, 4, 0}; }), "margins: expected ascending");
    refusal(one, one, with([](LevelRule& r) { r.zones.x = NAN; }), "zones");
}
