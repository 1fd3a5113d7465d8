// The run time's lightmap: receivers' texels, both rings, levels of detail; and an update from data textures.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "gi/lend.h"
#include "gi/probes/textures.h"
#include "gi/probes/update.h"
#include "probe_bakes.h"
#include "tests/parity/update_data.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

bool same_bits(const glm::vec4& a, const glm::vec4& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Receivers at texels, with places in another order, and a value each.
struct Mapped {
    Receivers receivers;
    std::vector<std::int32_t> place_of;
    Buffer<glm::vec4> values, by_place;

    Mapped(int side, float share, std::uint32_t seed) {
        receivers.size = {side, side};
        receivers.texel = made_texels(side, share, seed);
        const std::size_t n = receivers.texel.size();
        receivers.position.resize(n);
        by_place.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            place_of.push_back(std::int32_t((i * 7919 + 1) % n));
            values.push_back({5 * noise(int(i), 0, 0, seed), 5 * noise(int(i), 1, 0, seed) - 1, 5 * noise(int(i), 2, 0, seed), 1});
            by_place[std::size_t(place_of.back())] = values.back();
        }
    }
    Image<std::int32_t> cover(int levels) const { return lightmap_cover(receivers.texel, place_of, receivers.size.x, levels); }
    Image4 lightmap(int levels, const RunOptions& options = {}) const {
        const Image<std::int32_t> c = cover(levels);
        Image4 out;
        probes::run(LightmapInputs{&c, by_place.data(), int(by_place.size())}, options, out);
        return out;
    }
};

struct Texel {
    bool has = false;
    glm::dvec3 value{0};
};
// The mean of what has a value among the 8 neighbours within the square.
Texel mean_beside(const std::vector<Texel>& map, int side, int x, int y) {
    Texel t;
    int n = 0;
    for (int ny = y - 1; ny <= y + 1; ++ny)
        for (int nx = x - 1; nx <= x + 1; ++nx)
            if (nx >= 0 && ny >= 0 && nx < side && ny < side && map[std::size_t(ny * side + nx)].has)
                t.value += map[std::size_t(ny * side + nx)].value, ++n;
    if (n > 0) t.has = true, t.value /= double(n);
    return t;
}

}  // namespace

TEST_CASE("update: the lightmap is what scatter() and extend_borders() make, to the bit", "[probes][update][lightmap]") {
    for (const int side : {1, 2, 5, 64, 131})
        for (const float share : {0.03f, 0.3f, 0.9f}) {
            const Mapped m(side, share, std::uint32_t(side));
            if (m.receivers.texel.empty()) continue;
            const Image4 expected = extend_borders(m.receivers, scatter(m.receivers, m.values));
            for (const Isa isa : supported_isas())
                for (const int threads : {1, 3}) {
                    RunOptions options;
                    options.isa = isa, options.threads = threads;
                    const Image4 got = m.lightmap(1, options);
                    REQUIRE((got.width == side && got.height == side));
                    int differ = 0;
                    for (std::size_t i = 0; i < got.size(); ++i) differ += same_bits(got.texels[i], expected.texels[i]) ? 0 : 1;
                    CAPTURE(side, share, isa_name(isa));
                    CHECK(differ == 0);
                }
        }
    const Mapped some(64, 0.3f, 64);
    const Image<std::int32_t> cover = some.cover(1);
    CHECK(std::count(cover.texels.begin(), cover.texels.end(), cover_ring_1) > 100);
    CHECK(std::count(cover.texels.begin(), cover.texels.end(), cover_ring_2) > 100);
    CHECK(std::count(cover.texels.begin(), cover.texels.end(), cover_nothing) > 100);
}

// The loop over rows against one texel after the other: covers of anything, values that are none, squares that nobody wants.
TEST_CASE("update: the lightmap's rows are the kernel's texels, whatever covers hold", "[probes][update][lightmap][bits]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), odd[] = {-nan, -0.0f, std::numeric_limits<float>::infinity(), 1e-42f, -3e38f};
    const std::int32_t least = std::numeric_limits<std::int32_t>::min(), most = std::numeric_limits<std::int32_t>::max();
    for (const glm::ivec2 size : {glm::ivec2(1, 1), {2, 3}, {3, 1}, {15, 5}, {16, 40}, {17, 33}, {34, 70}, {131, 37}})
        for (const float rings : {0.1f, 0.6f}) {
            const int places = 40;
            Image<std::int32_t> cover(size.x, size.y);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const float kind = noise(x, y, 0, 93), which = noise(x, y, 1, 93);
                    const std::int32_t others[] = {-1, -4, places, most, least, 0, places - 1};
                    cover(x, y) = kind < rings ? (which < 0.6f ? -2 : -3) : kind < 0.8f ? int(which * places) : others[int(which * 7)];
                }
            // w is not read; a tenth of all numbers are odd ones.
            Buffer<glm::vec4> irradiance(places);
            for (int i = 0; i < 4 * places; ++i)
                irradiance[std::size_t(i / 4)][i % 4] = noise(i, 2, 0, 93) < 0.1f ? odd[i % 5] : 4 * noise(i, 3, 0, 93) - 1;
            Image4 expected(size.x, size.y);
            LightmapView view{{size.x, size.y, places, 0}, cover.data(), &irradiance[0].x, nullptr};
            NoTap tap;
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x)
                    number<float>::store4(&expected(x, y).x, 0, probes::lightmap<float>(view, x, y, tap), true);
            const glm::vec4 kept(7, 8, 9, 10);
            for (const Isa isa : supported_isas())
                for (const bool some : {false, true}) {
                    raster::Covered wanted(size, 1);
                    for (std::size_t i = 0; some && i < wanted.any.size(); ++i) wanted.any[i] = i % 3 != 0;
                    StageData data = data_of(LightmapInputs{&cover, irradiance.data(), places});
                    if (some) lend_tiles(data, &wanted);
                    RunOptions options;
                    options.isa = isa, options.threads = 2;
                    Image4 out(size.x, size.y, kept);
                    Bundle outputs;
                    lend(outputs, "lightmap", {size.y, size.x, 4}, &out.texels[0].x);
                    stage<LightmapKernel>().bind(data)->run(options, {}, outputs);
                    int differ = 0;
                    for (int y = 0; y < size.y; ++y)
                        for (int x = 0; x < size.x; ++x) differ += same_bits(out(x, y), wanted.row(y)[x / 16] ? expected(x, y) : kept) ? 0 : 1;
                    CAPTURE(size.x, size.y, rings, isa_name(isa), some);
                    CHECK(differ == 0);
                }
        }
}

TEST_CASE("update: each level shows every 2^k-th receiver, with rings of its own", "[probes][update][lightmap][lod]") {
    for (const int side : {37, 64}) {
        const int levels = 4;
        const Mapped m(side, 0.6f, 3);
        const Image4 strip = m.lightmap(levels);
        REQUIRE((strip.width == side && strip.height == lightmap_rows(side, levels)));
        int first = 0, covered = 0, rings = 0;
        std::vector<std::uint8_t> of_level(strip.size(), 0);
        for (int k = 0; k < levels; ++k) {
            const int own = int(std::ceil(side / std::exp2(k)));  // T_k
            std::vector<Texel> map(std::size_t(own * own));
            for (std::size_t i = 0; i < m.receivers.texel.size(); ++i) {
                const glm::ivec2 t = m.receivers.texel[i];
                if (t.x % (1 << k) == 0 && t.y % (1 << k) == 0)
                    map[std::size_t((t.y >> k) * own + (t.x >> k))] = {true, glm::dvec3(m.values[i])};
            }
            for (int ring = 0; ring < border_rings; ++ring) {
                const std::vector<Texel> before = map;
                for (int y = 0; y < own; ++y)
                    for (int x = 0; x < own; ++x)
                        if (Texel& t = map[std::size_t(y * own + x)]; !t.has) t = mean_beside(before, own, x, y), rings += t.has ? 1 : 0;
            }
            for (int y = 0; y < own; ++y)
                for (int x = 0; x < own; ++x) {
                    const Texel& t = map[std::size_t(y * own + x)];
                    const glm::vec4 got = strip(x, first + y);
                    CAPTURE(side, k, x, y);
                    CHECK(got.w == (t.has ? 1 : 0));
                    // 8 sums of positive and negative numbers below 5, and a division, twice.
                    CHECK(glm::length(glm::dvec3(got) - t.value) <= 20 * 5 * 0x1p-24);
                    of_level[std::size_t((first + y) * side + x)] = 1, covered += t.has ? 1 : 0;
                }
            first += own + 2;
        }
        for (std::size_t i = 0; i < strip.size(); ++i)
            if (!of_level[i]) CHECK(same_bits(strip.texels[i], glm::vec4(0)));
        CHECK(first - 2 == strip.height);
        CHECK((covered > 500 && rings > 100));
    }
}

TEST_CASE("run data: levels of texels, and covers that are refused", "[probes][update][lod]") {
    // Trailing zero bits of both coordinates, at most levels - 1 (IPR 4.2.3).
    CHECK(level_of_texel({0, 0}, 4) == 3);
    CHECK(level_of_texel({8, 16}, 4) == 3);
    CHECK(level_of_texel({8, 16}, 2) == 1);
    CHECK(level_of_texel({2, 4}, 4) == 1);
    CHECK(level_of_texel({4, 12}, 4) == 2);
    CHECK(level_of_texel({1, 0}, 4) == 0);
    CHECK(level_of_texel({6, 5}, 4) == 0);
    CHECK(level_of_texel({0, 0}, 1) == 0);
    // A square of 16 x 16 shows 256, 64, 16 and 4 receivers.
    int shown[4] = {};
    for (int i = 0; i < 256; ++i)
        for (int k = 0; k <= level_of_texel({i % 16, i / 16}, 4); ++k) ++shown[k];
    CHECK((shown[0] == 256 && shown[1] == 64 && shown[2] == 16 && shown[3] == 4));

    CHECK_THROWS_WITH(lightmap_cover({{1, 1}, {1, 1}}, {0, 1}, 4, 1), Catch::Contains("two receivers at texel 1, 1"));
    CHECK_THROWS_WITH(lightmap_cover({{1, 4}}, {0}, 4, 1), Catch::Contains("receiver 0 at texel 1, 4"));
    CHECK_THROWS_AS(lightmap_cover({{1, -1}}, {0}, 4, 1), InputError);
    CHECK_THROWS_AS(lightmap_cover({{1, 1}}, {0}, 4, 0), InputError);
    CHECK_THROWS_AS(lightmap_cover({{1, 1}}, {0}, 4, 5), InputError);
}

TEST_CASE("update: a lone receiver's value is in its 25 texels; NaN shows in them alone", "[probes][update][lightmap]") {
    // A mean of one, and means of these: equal values, whatever their number is, add up to a multiple that is divided again; of 0.75
    // exactly.
    for (const float value : {0.75f, std::numeric_limits<float>::quiet_NaN()}) {
        const Image<std::int32_t> cover = lightmap_cover({{4, 5}}, {0}, 12, 1);
        const glm::vec4 e(value, value, value, 1);
        Image4 out;
        probes::run(LightmapInputs{&cover, &e, 1}, {}, out);
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 12; ++x) {
                const bool within = std::abs(x - 4) <= 2 && std::abs(y - 5) <= 2;
                CHECK(out(x, y).w == (within ? 1 : 0));
                CHECK((within && value != value ? std::isnan(out(x, y).y) : out(x, y).y == (within ? value : 0)));
            }
    }
    // A place that is not there, or a ring that nothing lies beside: 0.
    Image<std::int32_t> cover(3, 1, 1);
    cover(1, 0) = cover_ring_1, cover(2, 0) = -4;
    const glm::vec4 e(1);
    Image4 out;
    probes::run(LightmapInputs{&cover, &e, 1}, {}, out);
    CHECK(same_bits(out(0, 0), glm::vec4(0)));
    CHECK(same_bits(out(1, 0), glm::vec4(0, 0, 0, 1)));
    CHECK(same_bits(out(2, 0), glm::vec4(0)));
    cover = Image<std::int32_t>();
    CHECK_THROWS_WITH(probes::run(LightmapInputs{&cover, &e, 1}, {}, out), Catch::Contains("no cover"));
}

// IPR 3.2.5: each pass can be fed from the data textures alone.
TEST_CASE("update: of data textures that were written and read back the same bits", "[probes][update][textures]") {
    BakeParams params = small();
    params.cluster_receivers = 150;
    const Scene scene = furnished();
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& bake = graph.bake();
    const BakeArrays arrays = arrays_of(all_textures(arrays_of(bake)));
    const RunData a = run_data(bake, 3), b = run_data(arrays, bake.receivers.size.x, 3);
    CHECK((a.probes == b.probes && a.rays == b.rays && a.coefficients == b.coefficients && a.singular_values == b.singular_values));
    CHECK(a.receiver == b.receiver);
    CHECK(a.cluster == b.cluster);
    CHECK(a.receiver_level == b.receiver_level);
    CHECK(a.cluster_probes == b.cluster_probes);
    CHECK(a.u == b.u);
    CHECK(a.matrix == b.matrix);
    CHECK(a.clusters == b.clusters);
    CHECK(a.cover.texels == b.cover.texels);
    CHECK(std::equal(bake.harmonics.begin(), bake.harmonics.end(), arrays.sh.begin(), arrays.sh.end()));

    const auto updated = [&](const RunData& d) {
        const Buffer<glm::vec4> lambda = made_lambda(d.probes, d.coefficients, 4);
        const std::vector<std::int32_t> level(d.clusters.size(), 0);
        Buffer<glm::vec4> basis, irradiance;
        Image4 lightmap;
        BasisInputs in;
        in.clusters = &d, in.cluster_level = level.data(), in.lambda = lambda.data(), in.probes = d.probes;
        probes::run(in, {}, basis);
        probes::run(IrradianceInputs{&d, level.data(), d.receiver_level.data(), basis.data()}, {}, irradiance);
        probes::run(LightmapInputs{&d.cover, irradiance.data(), d.count()}, {}, lightmap);
        return lightmap;
    };
    const Image4 x = updated(a), y = updated(b);
    CHECK(std::equal(x.texels.begin(), x.texels.end(), y.texels.begin(), y.texels.end(), same_bits));
    CHECK(std::any_of(x.texels.begin(), x.texels.end(), [](const glm::vec4& t) { return t.x != 0; }));
}
