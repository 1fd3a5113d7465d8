// Level of detail: which tiles of the lightmap are written, and that nothing reads the others.
#include <cstring>
#include <limits>
#include <set>

#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lightmap_tiles.h"
#include "gi/probes/lod.h"
#include "gi/probes/run_loop.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;
using namespace plumb::probes;

namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

bool same_bits(const glm::vec4& a, const glm::vec4& b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::equal(a.texels.begin(), a.texels.end(), b.texels.begin(), [](const glm::vec4& x, const glm::vec4& y) { return same_bits(x, y); });
}

// A room of 8 m with a box in it, flat charts wide apart; and the inside of a ball, whose charts bend, with gaps that coarse levels mix.
BakeParams fine(int gap, float receivers_per_m2) {
    BakeParams p = small();
    p.placement.count = 24, p.placement.overlaps = 4, p.receiver_rays = 16, p.relight_rays = 64, p.degree = 3;
    p.receivers_per_m2 = receivers_per_m2, p.gap = gap, p.cluster_receivers = 48;
    return p;
}
struct Baked {
    Scene scene;
    BakeGraph graph;
    LodBoxes boxes;
    HitSurfaces hits;

    Baked(Scene s, const BakeParams& p) : scene(lit(std::move(s))), graph(scene, p) {
        run_all(graph);
        boxes = lod_boxes(bake()), hits = hit_surfaces(scene, bake(), {});
    }
    const Bake& bake() const { return graph.bake(); }
    static Scene lit(Scene s) {
        for (Material& m : s.materials) m.reflectance = glm::vec3(0.6f, 0.5f, 0.7f), m.emission = glm::vec3(1, 2, 0.5f);
        return s;
    }
};
const Baked& room() {
    static const Baked b(furnished(4), fine(24, 20));
    return b;
}
const Baked& ball() {
    static const Baked b(inside_of_ball(6), fine(4, 60));
    return b;
}

LodParams four(float d1 = 1, float d2 = 2.5f, float d3 = 5) {
    LodParams p;
    p.levels = 4, p.distance_1 = d1, p.distance_2 = d2, p.distance_3 = d3;
    return p;
}

struct Look {
    glm::vec3 eye, forward;
};
Look look(std::uint32_t view, float half) {
    const auto random = [&](std::uint32_t i) { return float(pcg(view * 64 + i) & 0xffffff) / 16777216.0f - 0.5f; };
    return {2 * half * glm::vec3(random(0), random(1), random(2)), glm::vec3(random(3), random(4), random(5))};
}

// Two updates, so that relight rays look up what the first has written.
struct Run {
    const Baked& baked;
    Lod lod;
    RunData data;
    Levels levels;
    std::vector<std::int32_t> basis_level;
    Buffer<float> weights;
    Image4 place, direct, before, radiance, lambda, basis, irradiance, lightmap;
    TilesToWrite tiles;

    Run(const Baked& b, const LodParams& params) : baked(b), lod(lod_of(params, b.bake())), data(run_data(b.bake(), lod.levels)) {
        weights = level_weights(b.bake().relight_directions, {lod.rays.begin(), lod.rays.begin() + lod.levels});
        place = b.hits.place, direct = Image4(place.width, place.height);
    }
    void look_from(const Look& l) {
        levels = levels_at(lod, baked.bake(), baked.boxes, l.eye, l.forward, {});
        for (std::size_t i = 0; i < levels.hit.size(); ++i) place.texels[i].z = float(levels.hit[i]);
        tiles.wanted = tiles_to_write(data.tiles, levels.cluster), basis_level = basis_levels(data, levels.cluster);
    }
    UpdateBuffers buffers() {
        UpdateBuffers b;
        b.data = &data, b.harmonics = &baked.bake().harmonics, b.weights = &weights;
        b.probe_level = &levels.probe, b.cluster_level = &levels.cluster;
        b.counts = {lod.levels, lod.rays, lod.coefficients};
        b.surface = &baked.hits.surface, b.emitted = &baked.hits.emitted, b.place = &place, b.direct = &direct;
        b.last_lightmap = &before, b.read_lambda = &lambda, b.read_basis = &basis;
        b.radiance = &radiance, b.lambda = &lambda, b.basis = &basis, b.irradiance = &irradiance, b.lightmap = &lightmap;
        return b;
    }
    // All tiles, or the wanted ones with NaN in all others.
    void update_twice(bool all) {
        before = Image4(data.lightmap_size.x, data.lightmap_size.y);
        for (int i = 0; i < 2; ++i) {
            if (i == 1) std::swap(before, lightmap);
            UpdateBuffers b = buffers();
            if (!all) {
                lightmap = Image4(data.lightmap_size.x, data.lightmap_size.y, glm::vec4(nan_value));
                tiles.written = tiles.wanted, b.tiles = &tiles, b.basis_level = &basis_level;
            }
            update(b, {});
        }
    }
};

struct Point {
    glm::vec3 position;
    glm::vec2 uv;
};
// On all triangles: within, and on edges and corners.
std::vector<Point> surface_points(const Bake& bake, int each) {
    const Geometry& g = bake.atlas.geometry;
    std::vector<Point> points;
    for (std::uint32_t t = 0; t < g.triangles.size(); ++t)
        for (std::uint32_t s = 0; bake.atlas.chart[t] >= 0 && s < std::uint32_t(each); ++s) {
            float b = float(pcg(s * 977 + t) & 0xffff) / 65536.0f, c = float(pcg(s * 313 + 7 * t) & 0xffff) / 65536.0f;
            if (s % 5 == 1) b = 0;
            if (s % 5 == 2) c = 0;
            if (s % 5 == 3) c = 1 - b;
            if (s % 40 == 4) b = 1, c = 0;
            if (b + c > 1) b = 1 - b, c = 1 - c;
            const glm::uvec3 v = g.triangles[t];
            const auto between = [&](const auto& x, const auto& y, const auto& z) { return x + b * (y - x) + c * (z - x); };
            points.push_back({between(g.vertices[v.x].position, g.vertices[v.y].position, g.vertices[v.z].position),
                              between(bake.atlas.uv[v.x], bake.atlas.uv[v.y], bake.atlas.uv[v.z])});
        }
    return points;
}

// What probes.lookup makes of a point: the next level is read whatever its share is.
glm::vec4 looked_up(const Image4& lightmap, const LevelRule& rule, const Point& p) {
    const PointLevel l = level_at(rule, p.position);
    const LightmapArgs map{&lightmap.texels[0].x, lightmap.width, rule.levels};
    NoTap quiet;
    const vec2<float> uv{p.uv.x, p.uv.y};
    const vec3<float> e = mixed<float>(lightmap_at<float>(map, uv, l.level, quiet), lightmap_at<float>(map, uv, l.level + 1, quiet), l.share);
    return {e.x, e.y, e.z, 0};
}

struct Differ {
    std::int64_t points = 0, asked = 0;   // that are not what they are where everything is written
    std::int64_t hits = 0;                // the same of relight rays
    std::int64_t left_out = 0, tiles = 0;
    std::set<int> levels;                 // of points
};
// Over views. coarser: each cluster is said to be so many levels coarser than it is, of the tiles alone.
Differ differ(const Baked& baked, const LodParams& params, float half, int views, int coarser = 0) {
    const std::vector<Point> points = surface_points(baked.bake(), 60);
    Run whole(baked, params), part(baked, params);
    Differ d;
    for (int view = 0; view < views; ++view) {
        const Look l = look(std::uint32_t(view), half);
        whole.look_from(l), part.look_from(l);
        std::vector<std::int32_t> wrong = part.levels.cluster;
        for (std::int32_t& level : wrong) level += coarser;
        part.tiles.wanted = tiles_to_write(part.data.tiles, wrong);
        whole.update_twice(true), part.update_twice(false);
        for (std::size_t i = 0; i < whole.radiance.size(); ++i) d.hits += same_bits(whole.radiance.texels[i], part.radiance.texels[i]) ? 0 : 1;
        const LevelRule rule = fragment_rule_at(whole.lod, l.eye, l.forward);
        for (const Point& p : points) {
            ++d.asked;
            d.levels.insert(level_at(rule, p.position).level);
            d.points += same_bits(looked_up(whole.lightmap, rule, p), looked_up(part.lightmap, rule, p)) ? 0 : 1;
        }
        const Buffer<std::uint8_t>& any = part.tiles.wanted.any;
        d.tiles += std::int64_t(any.size()), d.left_out += std::count(any.begin(), any.end(), 0);
    }
    return d;
}

}  // namespace

TEST_CASE("lod tiles: nothing that looks up the lightmap reads a tile that is left out, to the bit", "[probes][lod][tiles][pruning]") {
    for (const bool zones : {false, true})
        for (const float shift : {0.0f, 0.4f})
            for (const HitLevel hit : {HitLevel::own, HitLevel::coarsest}) {
                LodParams params = four();
                params.zones = zones, params.fragment_shift = shift, params.hit_level = hit;
                CAPTURE(zones, shift, int(hit));
                const Differ d = differ(room(), params, 4, 4);
                CHECK(d.levels.size() == 4);
                CHECK(d.points == 0);
                CHECK(d.hits == 0);
                CHECK(d.asked > 5000);
                CHECK(d.left_out > d.tiles / 4);
            }
    const Differ bent = differ(ball(), four(0.5f, 1, 2), 1.5f, 12);
    CHECK(bent.levels.size() >= 3);
    CHECK(bent.points == 0);
    CHECK(bent.hits == 0);
    CHECK(bent.left_out > 0);
    // Without levels of detail: what no chart comes near.
    for (const Baked* b : {&room(), &ball()}) {
        const Differ off = differ(*b, LodParams{}, 1, 1);
        CHECK((off.points == 0 && off.hits == 0));
    }
}

TEST_CASE("lod tiles: a level too few is seen, in points and in what relight rays bring", "[probes][lod][tiles]") {
    const Differ d = differ(room(), four(), 4, 4, 1);
    CHECK(d.points > d.asked / 50);
    CHECK(d.hits > 0);
}

TEST_CASE("lod tiles: of the tiles that are written more than a third are read", "[probes][lod][tiles]") {
    // A mask that keeps everything would do, too. Boxes of clusters and their margins make some tiles written that nobody looks at: 56 % here.
    Run run(room(), four());
    const std::vector<Point> points = surface_points(room().bake(), 400);
    std::int64_t written = 0, read = 0;
    for (std::uint32_t view = 0; view < 3; ++view) {
        const Look l = look(view, 4);
        run.look_from(l), run.update_twice(true);
        const LevelRule rule = fragment_rule_at(run.lod, l.eye, l.forward);
        raster::Covered touched(run.data.lightmap_size);
        for (const Point& p : points) {
            const PointLevel at = level_at(rule, p.position);
            for (int k = at.level; k <= std::min(at.level + 1, 3); ++k) {
                const LightmapLevel<float> level = lightmap_level<float>(run.data.lightmap_size.x, 4, k);
                const glm::ivec2 low(glm::floor((p.uv * float(run.data.lightmap_size.x) - 0.5f) * level.scale));
                for (int n = 0; n < 4; ++n) {
                    const glm::ivec2 texel = glm::clamp(low + glm::ivec2(n % 2, n / 2), glm::ivec2(0), glm::ivec2(level.side - 1));
                    touched.any[std::size_t((level.first + texel.y) >> 4) * std::size_t(touched.tiles.x) + std::size_t(texel.x >> 4)] = 1;
                }
            }
        }
        for (std::size_t t = 0; t < touched.any.size(); ++t) {
            const bool wanted = run.tiles.wanted.any[t] != 0;
            if (touched.any[t]) CHECK(wanted);
            written += wanted ? 1 : 0, read += touched.any[t] ? 1 : 0;
        }
    }
    CAPTURE(read, written);
    CHECK(read > written / 3);
}

TEST_CASE("lod tiles: without levels the lightmap is what it is with all tiles, to the bit", "[probes][lod][tiles][pruning]") {
    for (const Baked* b : {&room(), &ball()}) {
        Run whole(*b, LodParams{}), part(*b, LodParams{});
        whole.look_from({{}, {1, 0, 0}}), part.look_from({{}, {1, 0, 0}});
        whole.before = part.before = Image4(whole.data.lightmap_size.x, whole.data.lightmap_size.y);
        update(whole.buffers(), {});
        UpdateBuffers buffers = part.buffers();
        buffers.tiles = &part.tiles;
        update(buffers, {});
        CHECK(same_bits(whole.lightmap, part.lightmap));
        // And where all clusters have level 0.
        Run near(*b, four(1e3f, 1e3f, 1e3f)), all(*b, four(1e3f, 1e3f, 1e3f));
        near.look_from({{}, {1, 0, 0}}), all.look_from({{}, {1, 0, 0}});
        near.before = all.before = Image4(all.data.lightmap_size.x, all.data.lightmap_size.y);
        buffers = near.buffers(), buffers.tiles = &near.tiles;
        update(buffers, {}), update(all.buffers(), {});
        CHECK(same_bits(near.lightmap, all.lightmap));
    }
}

TEST_CASE("lod tiles: what was shown before and is not now is 0, whatever was seen in between", "[probes][lod][tiles][bits]") {
    Run run(room(), four()), whole(room(), four());
    std::int64_t cleared = 0;
    for (std::uint32_t view = 0; view < 6; ++view)
        for (const Isa isa : supported_isas()) {
            RunOptions options;
            options.isa = isa, options.threads = 1 + int(view % 3);
            const raster::Covered before = run.tiles.written;
            run.look_from(look(view, 4)), whole.look_from(look(view, 4));
            run.before = whole.before = Image4(run.data.lightmap_size.x, run.data.lightmap_size.y);
            UpdateBuffers b = run.buffers();
            b.tiles = &run.tiles;
            update(b, options), update(whole.buffers(), {});
            std::int64_t wrong = 0;
            for (int y = 0; y < run.lightmap.height; ++y)
                for (int x = 0; x < run.lightmap.width; ++x) {
                    const bool wanted = run.tiles.wanted.row(y)[x >> 4] != 0;
                    wrong += same_bits(run.lightmap(x, y), wanted ? whole.lightmap(x, y) : glm::vec4(0)) ? 0 : 1;
                    cleared += !before.any.empty() && before.row(y)[x >> 4] && !wanted ? 1 : 0;
                }
            CAPTURE(view, isa_name(isa));
            CHECK(wrong == 0);
        }
    CHECK(cleared > 1000);
}

TEST_CASE("lod tiles: clusters of which nothing is computed take no coefficients, and no receiver tells", "[probes][lod][tiles][pruning]") {
    Run all(room(), four(0, 0, 0)), some(room(), four(0, 0, 0));
    all.look_from({{}, {1, 0, 0}}), some.look_from({{}, {1, 0, 0}});
    all.before = some.before = Image4(all.data.lightmap_size.x, all.data.lightmap_size.y);
    UpdateBuffers b = some.buffers();
    b.basis_level = &some.basis_level;
    update(all.buffers(), {}), update(b, {});
    CHECK(same_bits(all.irradiance, some.irradiance));
    const std::size_t clusters = all.data.clusters.size();
    std::vector<std::int32_t> computed(clusters, 0);
    for (std::size_t i = 0; i < all.data.cluster.size(); ++i)
        if (all.data.cluster[i] >= 0 && all.irradiance.texels[i].w > 0) ++computed[std::size_t(all.data.cluster[i])];
    std::int64_t without = 0;
    for (std::size_t c = 0; c < clusters; ++c) {
        REQUIRE(some.levels.cluster[c] == 3);
        CHECK(some.basis_level[c] == (computed[c] > 0 ? 3 : -1));
        without += computed[c] > 0 ? 0 : 1;
    }
    CHECK((without > 0 && without < std::int64_t(clusters)));
    CHECK_FALSE(same_bits(all.basis, some.basis));
    CHECK(basis_levels(all.data, std::vector<std::int32_t>(clusters, 0)) == std::vector<std::int32_t>(clusters, 0));
}

TEST_CASE("lod tiles: a mask by hand", "[probes][lod][tiles][analytic]") {
    // Tiles of: cluster 0 in levels up to 0; clusters 0 in 1 and 2 in 0; nothing; what is always looked up.
    LightmapTiles t;
    t.size = {64, 16}, t.always = {0, 0, 0, 1}, t.first = {0, 1, 3, 3, 3}, t.shows = {4 * 0 + 0, 4 * 0 + 1, 4 * 2 + 0};
    const auto mask = [&](std::vector<std::int32_t> levels) {
        const raster::Covered c = tiles_to_write(t, levels);
        return std::vector<int>(c.any.begin(), c.any.end());
    };
    CHECK(mask({}) == std::vector<int>{1, 1, 0, 1});
    CHECK(mask({0, 3, 3}) == std::vector<int>{1, 1, 0, 1});
    CHECK(mask({1, 3, 3}) == std::vector<int>{0, 1, 0, 1});
    CHECK(mask({2, 0, 1}) == std::vector<int>{0, 0, 0, 1});
    CHECK(mask({2, 0, 0}) == std::vector<int>{0, 1, 0, 1});

    // One receiver, of level 1 of two, at texel (18, 12) of 40 x 40: in level 0 within 3 texels, (15..21, 9..15): tiles (0, 0) and (1, 0).
    // Level 1 begins in row 42 and has it at (9, 6), row 48: (6..12, 45..51): tiles (0, 2) and (0, 3).
    Bake bake;
    bake.receivers.size = bake.atlas.size = {40, 40}, bake.receivers.texel = {{18, 12}}, bake.receivers.triangle = {0};
    bake.atlas.chart = {0}, bake.atlas.geometry.triangles = {{0, 1, 2}};
    const glm::vec2 at(18.5f / 40, 12.5f / 40);
    bake.atlas.uv = {at, at + glm::vec2(0.005f, 0), at + glm::vec2(0, 0.005f)};
    const LightmapTiles one = lightmap_tiles(bake, 2, {0}, {1});
    REQUIRE(one.size == glm::ivec2(40, 62));
    std::vector<int> expected(12, 0);  // 3 x 4 tiles
    expected[0] = expected[1] = expected[6] = expected[9] = 1;
    const auto shown = [](const raster::Covered& c) { return std::vector<int>(c.any.begin(), c.any.end()); };
    CHECK(shown(tiles_to_write(one, {0})) == expected);
    expected[0] = expected[1] = 0;
    CHECK(shown(tiles_to_write(one, {1})) == expected);
    CHECK(shown(tiles_to_write(one, {2})) == std::vector<int>(12, 0));
    // Without a cluster its 25 texels are 0 for ever, but covered: (16..20, 10..14), (7..11, 46..50); and so is what is looked up there.
    const LightmapTiles none = lightmap_tiles(bake, 2, {-1}, {1});
    expected[1] = 1;
    CHECK(shown(tiles_to_write(none, {3})) == expected);
    bake.atlas.chart = {-1};  // whether something is looked up there or not
    CHECK(shown(tiles_to_write(lightmap_tiles(bake, 2, {-1}, {1}), {3})) == expected);
    // A chart without a receiver near: the receiver is another chart's. What is looked up there, an eighth of a texel about: columns 17 to
    // 19 of rows 11 to 13, and 8 to 10 of 47 to 49.
    bake.atlas.chart = {1, 0}, bake.receivers.triangle = {1};
    bake.atlas.geometry.triangles.push_back({0, 0, 0});
    CHECK(shown(tiles_to_write(lightmap_tiles(bake, 2, {0}, {1}), {3})) == expected);

    // A square may lie in two levels: (0, 2) has rows 32 to 47. It shows the cluster in level 0 by a receiver at (4, 36), in level 1 by
    // one at (4, 4), row 44 there.
    bake.receivers.texel = {{4, 36}, {4, 4}}, bake.receivers.triangle = {1, 1}, bake.atlas.chart = {-1, -1};
    const LightmapTiles both = lightmap_tiles(bake, 2, {0, 0}, {0, 1});
    CHECK(tiles_to_write(both, {1}).any[6] == 1);
    CHECK(tiles_to_write(both, {2}).any[6] == 0);
}
