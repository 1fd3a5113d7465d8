// The pattern of rsm.paths: where its samples lie and what they weigh (VRSM 3.2, Algorithm 1).
#include <catch2/catch.hpp>
#include <set>

#include "core/error.h"
#include "core/host_math.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

constexpr int map_size = 512;

rsm::GatherParams paths_params() {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths;
    params.spacing = rsm::Spacing::uniform;  // the others: test_paths_spacing.cpp
    return params;
}

glm::ivec2 offset(const rsm::Pattern& p, int k, int i) {
    const std::int32_t packed = p.offsets[std::size_t(k) * p.rotations + i];
    return glm::ivec2(std::int16_t(packed & 0xffff), packed >> 16);
}
double weight(const rsm::Pattern& p, int k, int i) { return p.weights[std::size_t(k) * p.rotations + i]; }
double weight_of_rotation(const rsm::Pattern& p, int i) {
    double sum = 0;
    for (int k = 0; k < p.samples; ++k) sum += weight(p, k, i);
    return sum;
}
double disc(const rsm::GatherParams& params) {
    const double r = double(params.radius) * map_size;
    return host::pi * r * r;
}

}  // namespace

TEST_CASE("rsm.paths: weights sum to the disc in every rotation, without jitter", "[rsm][paths][VRSM 3.2][analytic]") {
    for (auto [directions, steps] : {std::pair{15, 10}, {1, 1}, {7, 3}, {64, 32}})
        for (float radius : {0.05f, 0.3f, 1.7f}) {
            rsm::GatherParams params = paths_params();
            params.directions = directions, params.steps = steps, params.radius = radius, params.jitter = 0;
            const rsm::Pattern p = rsm::paths_pattern(params, map_size, 1);
            REQUIRE(p.samples == directions * steps);
            REQUIRE(p.rotations == 64);
            CAPTURE(directions, steps, radius);
            for (int i = 0; i < p.rotations; ++i)
                CHECK(weight_of_rotation(p, i) == Approx(disc(params)).epsilon(1e-6).margin(0));
        }
}

TEST_CASE("rsm.paths: with jitter weights sum to the disc on the average", "[rsm][paths][VRSM 3.2][analytic]") {
    // Over the 64 rotations a sample's places in its step are 1/64 apart, so their mean is off by half of that at most:
    // all samples at once by 1 / (64 K), relative.
    for (float jitter : {0.3f, 1.0f}) {
        rsm::GatherParams params = paths_params();
        params.jitter = jitter;
        const rsm::Pattern p = rsm::paths_pattern(params, map_size, 3);
        double sum = 0, largest = 0;
        for (int i = 0; i < p.rotations; ++i) {
            const double of = weight_of_rotation(p, i) / disc(params);
            sum += of / p.rotations, largest = std::max(largest, std::abs(of - 1));
        }
        CAPTURE(jitter, sum, largest);
        CHECK(sum == Approx(1).epsilon(1.0 / (64 * params.steps)).margin(0));
        CHECK(largest > 1e-4);                  // a rotation alone does not
        CHECK(largest < jitter / params.steps);  // were all samples jittered alike
    }
}

TEST_CASE("rsm.paths: published weights integrate a constant exactly", "[rsm][paths][VRSM 3.2][published]") {
    for (float jitter : {0.0f, 1.0f}) {
        rsm::GatherParams params = paths_params();
        params.variant = rsm::Variant::published, params.jitter = jitter;
        const rsm::Pattern p = rsm::paths_pattern(params, map_size, 1);
        for (int i = 0; i < p.rotations; ++i)
            CHECK(weight_of_rotation(p, i) == Approx(disc(params)).epsilon(1e-6).margin(0));
        // In the proportion of the squared distances.
        if (jitter == 0) CHECK(weight(p, 9, 0) / weight(p, 2, 0) == Approx(19.0 * 19 / 25).epsilon(1e-6));
    }
}

TEST_CASE("rsm.paths: samples lie on straight paths, from near to far, and a step apart", "[rsm][paths][VRSM 3.2]") {
    rsm::GatherParams params = paths_params();
    const double r = double(params.radius) * map_size, step = r / params.steps;
    for (float jitter : {0.0f, 0.6f, 1.0f}) {
        params.jitter = jitter;
        const rsm::Pattern p = rsm::paths_pattern(params, map_size, 5);
        double smallest = 1, largest = 0;
        for (int i = 0; i < p.rotations; ++i)
            for (int k = 0; k < p.samples; ++k) {
                const int path = k / params.steps, at = k % params.steps;
                const double angle = 2 * host::pi * (path + (i + 0.5) / p.rotations) / params.directions;
                const glm::ivec2 o = offset(p, k, i);
                // Off the path by the rounding to texels alone; along it within its step, or in the step's middle.
                const double across = o.x * std::cos(angle) - o.y * std::sin(angle);
                const double along = o.x * std::sin(angle) + o.y * std::cos(angle);
                CHECK(std::abs(across) < 0.7072);
                CHECK(std::abs(along - (at + 0.5) * step) < 0.7072 + jitter * step / 2);
                // The weight is that of the place before it was rounded.
                const double rho = weight(p, k, i) * params.directions / (2 * host::pi * step);
                CHECK(rho == Approx(along).margin(0.7072));
                const double place = rho / step - at;
                smallest = std::min(smallest, place), largest = std::max(largest, place);
            }
        CHECK(smallest == Approx(0.5 - jitter / 2).margin(0.02));
        CHECK(largest == Approx(0.5 + jitter / 2).margin(0.02));
        CHECK((smallest >= -1e-6 && largest <= 1 + 1e-6));
    }
}

TEST_CASE("rsm.paths: over all rotations every sample is jittered evenly", "[rsm][paths][pattern]") {
    rsm::GatherParams params = paths_params();
    const rsm::Pattern p = rsm::paths_pattern(params, map_size, 5);
    const double step = double(params.radius) * map_size / params.steps;
    std::set<int> first_rotation;
    for (int k = 0; k < p.samples; ++k) {
        std::set<int> cells;
        for (int i = 0; i < p.rotations; ++i) {
            const double rho = weight(p, k, i) * params.directions / (2 * host::pi * step);
            const double place = rho / step - k % params.steps;
            cells.insert(int(place * 64 + 1e-4 * (place > 0.5 ? -1 : 1)));
            if (i == 0) first_rotation.insert(int(place * 16));
        }
        // 64 places in 64 cells, but for those on a border of two.
        CHECK(cells.size() >= 60);
    }
    CHECK(first_rotation.size() >= 14);  // in one rotation samples are jittered otherwise
}

TEST_CASE("rsm.paths: turn_jitter strays across a path by its sector at most", "[rsm][paths][pattern]") {
    rsm::GatherParams params = paths_params();
    params.turn_jitter = 1;
    const rsm::Pattern p = rsm::paths_pattern(params, map_size, 5);
    double largest = 0;
    for (int i = 0; i < p.rotations; ++i)
        for (int k = params.steps - 1; k < p.samples; k += params.steps) {
            const double angle = 2 * host::pi * (k / params.steps + (i + 0.5) / p.rotations) / params.directions;
            const glm::ivec2 o = offset(p, k, i);
            const double across = std::atan2(o.x * std::cos(angle) - o.y * std::sin(angle),
                                             o.x * std::sin(angle) + o.y * std::cos(angle));
            largest = std::max(largest, std::abs(across) * params.directions / (2 * host::pi));
        }
    CHECK(largest > 0.45);
    CHECK(largest < 0.52);  // half a sector, and half a texel's diagonal at 138 texels
}

TEST_CASE("rsm.paths: the seed chooses the jitter and nothing else", "[rsm][paths][pattern]") {
    rsm::GatherParams params = paths_params();
    const rsm::Pattern a = rsm::paths_pattern(params, map_size, 1), b = rsm::paths_pattern(params, map_size, 2);
    CHECK_FALSE(std::equal(a.weights.begin(), a.weights.end(), b.weights.begin()));
    params.jitter = 0;
    const rsm::Pattern c = rsm::paths_pattern(params, map_size, 1), d = rsm::paths_pattern(params, map_size, 2);
    CHECK(std::equal(c.weights.begin(), c.weights.end(), d.weights.begin()));
    CHECK(std::equal(c.offsets.begin(), c.offsets.end(), d.offsets.begin()));
}

TEST_CASE("rsm: a square tile deals out every rotation once, neighbours in other quarters", "[rsm][paths][pattern]") {
    const raster::Rsm map = plane_map(16, [](double, double) { return 1.0; });
    Points points(32, 16);
    for (glm::vec4& n : points.normal.texels) n = {0, 0, -1, 1};
    for (const rsm::Gather kind : {rsm::Gather::disc, rsm::Gather::paths})
        for (const int tile : {2, 4, 8, 16}) {
            rsm::GatherParams params = paths_params();
            params.gather = kind, params.turn = rsm::Turn::tile;
            params.samples = params.directions = params.steps = 1;
            params.rotations = tile * tile;
            CAPTURE(int(kind), tile);
            const rsm::Pattern pattern = rsm::pattern_of(params, 16, 1);
            auto rotation = [&](int x, int y) {
                const rsm::GatherInputs in{&points.position, &points.normal, &map, &pattern, 1};
                for (const TapValue& v : rsm::explain(params, in, {x, y}))
                    if (v.name == "rotation") return int(v.value[0]);
                return -1;
            };
            std::set<int> met;
            for (int y = 0; y < tile; ++y)
                for (int x = 0; x < tile; ++x) {
                    met.insert(rotation(x, y));
                    CHECK(rotation(32 - tile + x, 16 - tile + y) == rotation(x, y));
                    std::set<int> quarters;
                    for (int j = 0; j < 2; ++j)
                        for (int i = 0; i < 2; ++i)
                            quarters.insert(rotation((x + i) % tile, (y + j) % tile) * 4 / params.rotations);
                    CHECK(quarters.size() == 4);
                }
            CHECK(met.size() == std::size_t(params.rotations));
            CHECK((*met.begin() == 0 && *met.rbegin() == params.rotations - 1));
        }
    rsm::GatherParams params = paths_params();
    params.turn = rsm::Turn::tile, params.rotations = 8;
    const std::string refusal = "rsm.paths: rotations = 8: turn = \"tile\" deals out 4, 16, 64, 256, 1024 or 4096, over a square";
    CHECK_THROWS_WITH(rsm::pattern_of(params, 16, 1), refusal);
    const rsm::Pattern pattern = rsm::paths_pattern(params, 16, 1);
    CHECK_THROWS_WITH(gather(params, points, map, &pattern), refusal);
    params.turn = rsm::Turn::automatic;
    CHECK(rsm::turn_of(params) == rsm::Turn::hash);
    params.rotations = 256;
    CHECK(rsm::turn_of(params) == rsm::Turn::hash);
    params.rotations = 64;
    CHECK(rsm::turn_of(params) == rsm::Turn::tile);
}

TEST_CASE("rsm.paths: bad parameters and patterns are refused by name", "[rsm][paths][errors]") {
    const raster::Rsm map = plane_map(16, [](double, double) { return 1.0; });
    const Points point({0, 0, 1}, {0, 0, -1});
    auto refusal = [&](auto change) {
        rsm::GatherParams params = paths_params();
        const rsm::Pattern pattern = rsm::paths_pattern(params, 16, 1);
        change(params);
        try {
            gather(params, point, map, &pattern);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    using P = rsm::GatherParams;
    CHECK(refusal([](P&) {}) == "");
    using Catch::Contains;
    CHECK_THAT(refusal([](P& p) { p.slots = 1; }), Contains("rsm.paths") && Contains("slots") && Contains("2"));
    CHECK_THAT(refusal([](P& p) { p.slots = 33; }), Contains("slots") && Contains("32"));
    CHECK_THAT(refusal([](P& p) { p.directions = 0; }), Contains("directions"));
    CHECK_THAT(refusal([](P& p) { p.steps = 1025; }), Contains("steps"));
    CHECK_THAT(refusal([](P& p) { p.jitter = 1.5f; }), Contains("jitter"));
    CHECK_THAT(refusal([](P& p) { p.growth = 0.5f; }), Contains("growth"));
    CHECK_THAT(refusal([](P& p) { p.rotations = 6; }), Contains("power of two"));
    CHECK_THAT(refusal([](P& p) { p.directions = p.steps = 300; }), Contains("65536"));
    CHECK_THAT(refusal([](P& p) { p.steps = 11; }), Contains("rsm.paths: pattern has "));
    P large = paths_params();
    large.directions = large.steps = 1024;
    CHECK_THROWS_WITH(rsm::pattern_of(large, 16, 1), Contains("expected at most 65536 samples"));
    large.directions = large.steps = 256, large.rotations = 4096;
    CHECK_THROWS_WITH(rsm::pattern_of(large, 16, 1), Contains("65536 samples x rotations = 4096: expected at most 67108864"));
    CHECK(refusal([](P& p) { p.steps = 11; }).find('\n') == std::string::npos);
}
