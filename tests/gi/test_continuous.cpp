// The choice of texels: whole texels from the one rounded projection, or each sample's own position rounded; and patterns
// of a user's own.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fmt/format.h>

#include "core/error.h"
#include "core/hash.h"
#include "gi/parity/stages.h"
#include "gi/rsm/gather.h"
#include "rsm_scenes.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/moving_scene.h"

using namespace plumb;
using plumb::test::gather;

namespace {

constexpr int map_size = 64;

float noise(int x, int y, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 11).x); }

// A map of points that lie anywhere: which texel is read shows in every bit.
const raster::Rsm& noise_map() {
    static const raster::Rsm map = [] {
        raster::Rsm m = test::plane_map(map_size, [](double, double) { return 1.0; });
        for (int j = 0; j < map_size; ++j)
            for (int i = 0; i < map_size; ++i) {
                float* r = m.records.data() + record_stride * (j * map_size + i);
                for (int c = 0; c < 3; ++c) r[c] = 2 * noise(i, j, c) - 1, r[8 + c] = noise(i, j, 3 + c);
                r[7] = noise(i, j, 6) < 0.9f ? 1.0f : 0.0f;
            }
        // As a device binds it.
        m.position = m.normal = m.flux = Image4(map_size, map_size);
        for (int i = 0; i < map_size * map_size; ++i)
            for (int c = 0; c < 4; ++c) {
                const float* r = m.records.data() + record_stride * i;
                m.position.texels[std::size_t(i)][c] = r[c], m.normal.texels[std::size_t(i)][c] = r[4 + c];
                m.flux.texels[std::size_t(i)][c] = r[8 + c];
            }
        return m;
    }();
    return map;
}

// A point a texel, each in its texel's middle, and some beside the map.
test::Points centred_points() {
    test::Points points(map_size + 8, map_size + 8);
    for (int y = 0; y < points.position.height; ++y)
        for (int x = 0; x < points.position.width; ++x) {
            const float u = (2.0f * float(x - 4) + 1) / map_size - 1, v = 1 - (2.0f * float(y - 4) + 1) / map_size;
            points.position(x, y) = glm::vec4(u, v, 2.5f, 0);
            points.normal(x, y) = glm::vec4(0, 0, -1, 1);
        }
    return points;
}

// The gathers that read a pattern, in the branches of their kernels.
std::vector<rsm::GatherParams> kinds() {
    rsm::GatherParams disc{.gather = rsm::Gather::disc}, paths;
    disc.samples = 60;
    paths.gather = rsm::Gather::paths, paths.directions = 7, paths.steps = 6;
    std::vector<rsm::GatherParams> all = {disc, paths};
    for (auto visibility : {rsm::Visibility::none, rsm::Visibility::algorithm_2}) {
        paths.visibility = visibility;
        paths.turn = rsm::Turn::tile;
        all.push_back(paths);
    }
    return all;
}

rsm::GatherParams continuous(rsm::GatherParams params) {
    params.texels = rsm::Texels::continuous;
    return params;
}

glm::ivec2 offset_of(std::int32_t packed) { return {std::int16_t(packed & 0xffff), packed >> 16}; }

// The same whole texels as positions.
rsm::Pattern as_positions(rsm::Pattern pattern) {
    for (const std::int32_t packed : pattern.offsets) {
        pattern.positions.push_back(float(offset_of(packed).x));
        pattern.positions.push_back(float(offset_of(packed).y));
    }
    pattern.offsets.clear();
    return pattern;
}

bool same_bits(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

// A pattern of rotation 0 as a user would write it to a file.
SampleRowsPtr rows_of(const rsm::Pattern& pattern) {
    SampleRows own{"own.npy", "folder/own.npy", {}};
    for (int k = 0; k < pattern.samples; ++k) {
        const std::size_t at = std::size_t(k) * std::size_t(pattern.rotations);
        const float weight = pattern.weights[pattern.weights.size() == pattern.offsets.size() ? at : std::size_t(k)];
        own.rows.push_back({offset_of(pattern.offsets[at]), weight});
    }
    return std::make_shared<const SampleRows>(own);
}

rsm::GatherParams with_own(rsm::GatherParams params, std::vector<glm::dvec3> rows) {
    params.pattern = "own.npy";
    params.own = std::make_shared<const SampleRows>(SampleRows{"own.npy", "folder/own.npy", std::move(rows)});
    return params;
}

std::string error_of(const rsm::GatherParams& params) {
    try {
        rsm::pattern_of(params, map_size, 1);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("continuous: whole offsets from the middle of a texel read the texels that the whole-texel gather reads",
          "[rsm][continuous][analytic]") {
    const test::Points points = centred_points();
    for (const rsm::GatherParams& params : kinds()) {
        CAPTURE(int(params.gather), int(params.visibility));
        const rsm::Pattern whole = rsm::pattern_of(params, map_size, 1), positions = as_positions(whole);
        const Image4 expected = gather(params, points, noise_map(), &whole);
        CHECK(std::any_of(expected.texels.begin(), expected.texels.end(), [](glm::vec4 e) { return e.x > 0; }));
        CHECK(same_bits(gather(continuous(params), points, noise_map(), &positions), expected));

        // Half a texel more and the texels are others: the comparison can fail.
        rsm::Pattern moved = positions;
        for (float& d : moved.positions) d += 0.5f;
        CHECK_FALSE(same_bits(gather(continuous(params), points, noise_map(), &moved), expected));
    }
}

TEST_CASE("continuous: a sample's texel holds the projection plus its offset", "[rsm][continuous][tap]") {
    test::Points point({0.337f, -0.211f, 1.5f}, {0, 0, -1});
    for (const rsm::GatherParams& whole : kinds()) {
        const rsm::GatherParams params = continuous(whole);
        const rsm::Pattern pattern = rsm::pattern_of(params, map_size, 1);
        REQUIRE(pattern.offsets.empty());
        REQUIRE(pattern.positions.size() == 2 * std::size_t(pattern.samples * pattern.rotations));
        const std::vector<TapValue> taps =
            rsm::explain(params, {&point.position, &point.normal, &noise_map(), &pattern, 1}, {0, 0});
        glm::vec2 projection(0), place(0);
        int rotation = -1, samples = 0;
        for (const TapValue& t : taps) {
            if (t.name == "projection") projection = {t.value[0], t.value[1]};
            if (t.name == "rotation") rotation = int(t.value[0]);
            if (t.name == "place") place = {t.value[0], t.value[1]};
            if (t.name != "texel") continue;
            const std::size_t at = 2 * std::size_t(t.sample * pattern.rotations + rotation);
            CHECK(place.x == projection.x + pattern.positions[at]);
            CHECK(place.y == projection.y + pattern.positions[at + 1]);
            CHECK(t.value[0] == std::floor(place.x));
            CHECK(t.value[1] == std::floor(place.y));
            ++samples;
        }
        // (x + 1) / 2 and (1 - y) / 2 of 64 texels
        CHECK(projection.x == Approx(1.337 * 32).epsilon(1e-6));
        CHECK(projection.y == Approx(1.211 * 32).epsilon(1e-6));
        CHECK(samples == pattern.samples);
    }
}

TEST_CASE("continuous: both choices of texels converge to the same integral", "[rsm][continuous][LRA 4.3.3]") {
    constexpr int size = 256;
    const raster::Rsm map = test::plane_map(size, [](double x, double y) { return 1 + 0.8 * x + 3 * y * y; });
    test::Points points(4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            points.position(x, y) = glm::vec4(0.11f * float(x) - 0.2f, 0.13f * float(y) - 0.2f, 0.5f, 0);
            points.normal(x, y) = glm::vec4(0, 0, -1, 1);
        }
    auto apart = [&](rsm::GatherParams params) {
        const rsm::Pattern whole = rsm::pattern_of(params, size, 1), own = rsm::pattern_of(continuous(params), size, 1);
        const Image4 a = gather(params, points, map, &whole), b = gather(continuous(params), points, map, &own);
        double worst = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            worst = std::max(worst, std::abs(double(b.texels[i].x) / double(a.texels[i].x) - 1));
        return worst;
    };
    rsm::GatherParams disc{.gather = rsm::Gather::disc}, paths;
    paths.gather = rsm::Gather::paths, paths.visibility = rsm::Visibility::none;
    disc.samples = 25, paths.directions = 8, paths.steps = 4;
    const double coarse[] = {apart(disc), apart(paths)};
    disc.samples = 6400, paths.directions = 120, paths.steps = 60;
    const double fine[] = {apart(disc), apart(paths)};
    INFO(fmt::format("disc {:.2e} -> {:.2e}, paths {:.2e} -> {:.2e}", coarse[0], fine[0], coarse[1], fine[1]));
    // What is left is the whole texels' disc about a texel's middle: half a texel of 77, over a smooth integrand.
    for (int i = 0; i < 2; ++i) {
        CHECK(fine[i] > 0);
        CHECK(fine[i] < 0.4 * coarse[i]);
        CHECK(fine[i] < 6e-3);
    }
}

TEST_CASE("continuous: no rounding brings a sample to the map of what reach says is not near", "[rsm][continuous][reach]") {
    // Points on a line that leaves the map, each against a reach that holds everything.
    test::Points points(256, 1);
    for (int x = 0; x < 256; ++x) {
        points.position(x, 0) = glm::vec4(0.02f * float(x) - 2.56f, 0.3f, 2.5f, 0);
        points.normal(x, 0) = glm::vec4(0, 0, -1, 1);
    }
    for (const rsm::GatherParams& whole : kinds()) {
        const rsm::GatherParams params = continuous(whole);
        const rsm::Pattern pattern = rsm::pattern_of(params, map_size, 1);
        CHECK(rsm::reach_of(pattern) >= int(0.3 * map_size));
        CHECK(rsm::reach_of(pattern) <= int(0.3 * map_size) + 3);
        StageData data = rsm::data_of(params, {&points.position, &points.normal, &noise_map(), &pattern, 1});
        const StageBinding& binding = parity::find_binding(data.stage, "test");
        auto run = [&] {
            Bundle out = make_outputs(binding, data);
            binding.bind(data)->run({}, {}, out);
            return image4(out.arrays.at(0));
        };
        const Image4 near = run();
        const double wide = 32769;
        set_uniform(binding, data, "reach", {&wide, 1}, "test");
        CHECK(same_bits(near, run()));
    }
}

TEST_CASE("own pattern: the default pattern as rows is the default pattern", "[rsm][pattern]") {
    for (rsm::GatherParams params : kinds()) {
        params.rotations = params.turn == rsm::Turn::tile ? 16 : 1;
        if (params.rotations != 1) continue;
        const rsm::Pattern made = rsm::pattern_of(params, map_size, 1);
        rsm::GatherParams own = params;
        own.pattern = "own.npy", own.own = rows_of(made);
        own.samples = 7;  // the file's number counts
        const rsm::Pattern read = rsm::pattern_of(own, map_size, 1);
        CHECK(read.samples == made.samples);
        CHECK(read.offsets == made.offsets);
        CHECK(read.weights == made.weights);
        const test::Points points = centred_points();
        CHECK(same_bits(gather(own, points, noise_map(), &read), gather(params, points, noise_map(), &made)));
    }
}

TEST_CASE("own pattern: rotations turn it by parts of a circle, or of a path's sector", "[rsm][pattern]") {
    rsm::GatherParams params = with_own({.gather = rsm::Gather::disc}, {{0, 10, 2.5}, {6.75, -3, 0.25}});
    params.rotations = 4, params.texels = rsm::Texels::continuous;
    const rsm::Pattern disc = rsm::pattern_of(params, map_size, 1);
    CHECK(disc.weights == Buffer<float>{2.5f, 0.25f});
    const glm::vec2 turned[2][4] = {{{0, 10}, {10, 0}, {0, -10}, {-10, 0}},
                                    {{6.75f, -3}, {-3, -6.75f}, {-6.75f, 3}, {3, 6.75f}}};
    for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t i = 0; i < 4; ++i) {
            CHECK(disc.positions[2 * (4 * k + i)] == Approx(turned[k][i].x).margin(1e-5));
            CHECK(disc.positions[2 * (4 * k + i) + 1] == Approx(turned[k][i].y).margin(1e-5));
        }

    params.gather = rsm::Gather::paths, params.directions = 2, params.steps = 1, params.rotations = 2;
    const rsm::Pattern paths = rsm::pattern_of(params, map_size, 1);
    CHECK(paths.weights == Buffer<float>{2.5f, 2.5f, 0.25f, 0.25f});
    // Half of a sector of half a circle.
    CHECK(paths.positions[2] == Approx(10));
    CHECK(paths.positions[3] == Approx(0).margin(1e-5));
}

TEST_CASE("own pattern: what does not fit is refused by the file's name", "[rsm][pattern][errors]") {
    using Catch::Matchers::Contains;
    rsm::GatherParams params = with_own({.gather = rsm::Gather::disc}, {{0, 10, 1}, {3, 4, 1}});
    CHECK(error_of(params) == "");
    params.gather = rsm::Gather::paths;
    CHECK_THAT(error_of(params), Contains("folder/own.npy: rsm.paths: has 2 samples: expected directions = 10 x steps = 15"));
    params.directions = 2, params.steps = 1;
    CHECK(error_of(params) == "");

    // Turned by an eighth of a circle the corner of the square leaves the range.
    params = with_own({.gather = rsm::Gather::disc}, {{32767, 32767, 1}});
    params.rotations = 1;
    CHECK(error_of(params) == "");
    params.rotations = 8;
    CHECK_THAT(error_of(params), Contains("folder/own.npy") && Contains("row 0, rotation 1") && Contains("32767"));

    // A name alone, or another file's rows.
    params = {};
    params.pattern = "else.npy";
    CHECK_THAT(error_of(params), Contains("pattern = \"else.npy\": the file was not read"));
    params = with_own({.gather = rsm::Gather::disc}, {{0, 0, 1}});
    params.pattern = "else.npy";
    CHECK_THAT(error_of(params), Contains("pattern = \"else.npy\": the file was not read"));
    params.gather = rsm::Gather::all;
    CHECK(error_of(params) == "");
}

TEST_CASE("own pattern: other rows of the same name are another gather for what is kept", "[rsm][pattern][frame]") {
    const Scene scene = moving::scene();
    auto keys = [&](std::vector<glm::dvec3> rows) {
        frame::Settings settings;
        settings.rsm = with_own({.gather = rsm::Gather::disc}, std::move(rows));
        return test::keys_of(scene, settings);
    };
    CHECK(keys({{0, 1, 1}, {2, 3, 4}}) == keys({{0, 1, 1}, {2, 3, 4}}));
    CHECK(keys({{0, 1, 1}, {2, 3, 4}}) != keys({{0, 1, 1}, {2, 3, 5}}));
}

TEST_CASE("continuous: how many pixels have a choice of texel within the bound", "[rsm][continuous][parity]") {
    // Points that project anywhere, 60 samples a pixel: each projection of two coordinates is a choice, or each sample's.
    test::Points points(64, 48);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            points.position(x, y) = glm::vec4(1.8f * noise(x, y, 20) - 0.9f, 1.8f * noise(x, y, 21) - 0.9f, 2.5f, 0);
            points.normal(x, y) = glm::vec4(0, 0, -1, 1);
        }
    auto open = [&](const rsm::GatherParams& params) {
        const rsm::Pattern pattern = rsm::pattern_of(params, map_size, 1);
        const StageData data = rsm::data_of(params, {&points.position, &points.normal, &noise_map(), &pattern, 1});
        const auto bound = parity::find_binding(data.stage, "test").bind(data);
        int several = 0;
        std::vector<Outcome> out;
        for (int i = 0; i < 64 * 48; ++i) {
            bound->outcomes({i % 64, i / 64}, {}, {}, {}, out);
            several += out.size() > 1 || out.at(0).ambiguous;
        }
        return several;
    };
    rsm::GatherParams params{.gather = rsm::Gather::disc};
    params.samples = 60;
    const int whole = open(params), own = open(continuous(params));
    INFO(fmt::format("of {} pixels: whole {}, continuous {}", 64 * 48, whole, own));
    // A coordinate c is within the bound b of a border with the chance 2 b; 120 coordinates a pixel have 60 times the
    // chance of two.
    CHECK(own > 10 * whole);
    CHECK(own > 0);
    CHECK(own < 64 * 48 / 4);
}
