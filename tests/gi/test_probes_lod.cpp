// Level of detail: what the parameters become, what is left out, and what that leaves as it was.
#include "core/error.h"
#include "core/hash.h"
#include "gi/probes/lod.h"
#include "gi/probes/lod_reference.h"
#include "gi/probes/run_loop.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;
using namespace plumb::probes;
using Catch::Matchers::Contains;

namespace {

using Radiances = std::vector<glm::dvec3>;

// A room of 8 m with a box in it, dense enough for four levels between a corner and the opposite one.
const Bake& room() {
    static BakeGraph* graph = [] {
        static const Scene scene = furnished(4);
        BakeParams p = small();
        p.placement.count = 24, p.placement.overlaps = 4, p.receiver_rays = 32, p.receivers_per_m2 = 40, p.relight_rays = 512, p.gap = 24;
        p.cluster_receivers = 128;
        auto* g = new BakeGraph(scene, p);
        run_all(*g);
        return g;
    }();
    return graph->bake();
}
const LodBoxes& boxes() {
    static const LodBoxes b = lod_boxes(room());
    return b;
}

LodParams four(float d1 = 1, float d2 = 3, float d3 = 6) {
    LodParams p;
    p.levels = 4, p.distance_1 = d1, p.distance_2 = d2, p.distance_3 = d3;
    return p;
}
LodParams alike(LodParams p) {
    p.rays_0 = p.rays_1 = p.rays_2 = p.rays_3 = 512;
    p.degree_0 = p.degree_1 = p.degree_2 = p.degree_3 = 7;
    return p;
}

const glm::vec3 corner(-3.5f, -3, -3.5f), towards(1, 0.2f, 0.7f);

Levels levels_of(const Lod& lod, const glm::vec3& eye = corner, const glm::vec3& forward = towards) {
    return levels_at(lod, room(), boxes(), eye, forward, {});
}

// Light of many directions.
Radiances lit() {
    Radiances f;
    for (std::size_t k = 0; k < room().relight.material.size(); ++k) {
        const glm::dvec3 p(room().relight.position[k]);
        f.emplace_back(1 + 0.3 * p.x, 2 + 0.4 * p.y * p.z, p.x > 2 ? 5.0 : 0.5);
    }
    return f;
}

struct Update {
    Lod lod;
    Levels levels;
    std::vector<glm::dvec3> lambda, irradiance;
};
Update update(const LodParams& params, const glm::vec3& eye = corner, const glm::vec3& forward = towards) {
    Update u;
    u.lod = lod_of(params, room());
    u.levels = levels_of(u.lod, eye, forward);
    u.lambda = lod_lambda(room(), u.lod, u.levels, lit());
    u.irradiance = lod_irradiance(room(), u.lod, u.levels, u.lambda);
    return u;
}

// The same by the stages, in floats: all light of a ray is emitted where it ends.
struct Stages {
    RunData data;
    Image4 radiance, lambda, basis, irradiance, lightmap;
};
Stages by_stages(const Lod& lod, const Levels& levels) {
    Stages s;
    s.data = run_data(room(), lod.levels);
    const RelightHits& hits = room().relight;
    Image4 emitted(hits.rays, hits.probes);
    const Radiances f = lit();
    for (std::size_t k = 0; k < f.size(); ++k) emitted.texels[k] = glm::vec4(glm::vec3(f[k]), 0);
    const Image4 nothing(hits.rays, hits.probes), black(s.data.lightmap_size.x, s.data.lightmap_size.y);
    const Buffer<float> weights = level_weights(room().relight_directions, {lod.rays.begin(), lod.rays.begin() + lod.levels});
    UpdateBuffers b;
    b.data = &s.data, b.harmonics = &room().harmonics, b.weights = &weights;
    b.probe_level = &levels.probe, b.cluster_level = &levels.cluster;
    b.counts = {lod.levels, lod.rays, lod.coefficients};
    b.surface = b.place = b.direct = &nothing, b.emitted = &emitted, b.last_lightmap = &black;
    b.read_lambda = &s.lambda, b.read_basis = &s.basis;
    b.radiance = &s.radiance, b.lambda = &s.lambda, b.basis = &s.basis, b.irradiance = &s.irradiance, b.lightmap = &s.lightmap;
    update(b, {});
    return s;
}

int level_of_receiver(std::size_t i, int levels) { return level_of_texel(room().receivers.texel[i], levels); }

}  // namespace

TEST_CASE("lod: what is automatic follows from the scene and the bake", "[probes][lod]") {
    LodParams p;
    p.levels = 4;
    const Lod lod = lod_of(p, 80, 7, 512, 24);
    CHECK(glm::vec3(lod.rule.distances) == glm::vec3(20, 40, 80));
    CHECK(glm::vec3(lod.rule.widths) == glm::vec3(5, 5, 10));  // a quarter of 20, 20, 40 m
    CHECK(lod.rays == std::array{512, 256, 128, 64});               // figure 5.31
    CHECK(lod.degree == std::array{7, 5, 3, 2});                    // half of 14, 10, 7, 4; table 5.11: SD0
    CHECK(lod.coefficients == std::array{64, 36, 16, 9});
    CHECK(lod.notes.empty());
    const Lod small_bake = lod_of(p, 80, 4, 200, 24);
    CHECK(small_bake.rays == std::array{200, 128, 64, 64});
    CHECK(small_bake.degree == std::array{4, 3, 2, 2});
    const Lod few = lod_of(p, 80, 7, 40, 24);
    CHECK(few.rays == std::array{40, 40, 40, 40});
    CHECK(few.degree == std::array{7, 7, 7, 7});  // all that the bake has: nothing aliases that did not before
    CHECK(lod_of(LodParams{}, 80, 7, 512, 3).notes.empty());
    CHECK(lod_of(LodParams{}, 80, 7, 512, 3).off());
    p.distance_1 = 0;
    CHECK(glm::vec3(lod_of(p, 80, 7, 512, 24).rule.distances) == glm::vec3(0, 40, 80));
    p.distance_2 = 25;
    CHECK(glm::vec3(lod_of(p, 80, 7, 512, 24).rule.distances) == glm::vec3(0, 25, 80));
    p.distance_2 = 45;
    CHECK(glm::vec3(lod_of(p, 80, 7, 512, 24).rule.distances) == glm::vec3(0, 45, 90));  // at least twice as far
    p.distance_2 = 25, p.fragment_shift = 20;
    CHECK(glm::vec3(lod_of(p, 80, 7, 512, 24).fragment_distances) == glm::vec3(0, 5, 60));
}

TEST_CASE("lod: setups of table 5.4 are taken, with notes", "[probes][lod][IPR table 5.4]") {
    LodParams p = four(20, 50, 100);
    p.degree_0 = 7, p.degree_1 = 6, p.degree_2 = 4, p.degree_3 = 3;
    const Lod s0 = lod_of(p, 100, 7, 512, 3);
    CHECK(s0.degree == std::array{7, 6, 4, 3});
    REQUIRE(s0.notes.size() == 4);
    CHECK_THAT(s0.notes[0], Contains("degree_1 = 6: on 256 rays harmonics above degree 5 are not orthogonal"));
    CHECK_THAT(s0.notes[3], Contains("gap = 3: level 3 mixes charts that lie less than 24 texels apart"));
    const Lod cut = lod_of(p, 100, 5, 512, 24);
    CHECK(cut.degree == std::array{5, 5, 4, 3});
    CHECK_THAT(cut.notes[0], Contains("degree_0 = 7: cut to 5, which the bake has"));
    CHECK_THAT(cut.notes[1], Contains("degree_1 = 6: cut to 5, which the level before has"));
}

TEST_CASE("lod: says what it cannot use", "[probes][lod][refusal]") {
    const auto refusal = [](auto change, const std::string& says) {
        LodParams p;
        p.levels = 4;
        change(p);
        CAPTURE(says);
        CHECK_THROWS_WITH(lod_of(p, 80, 7, 512, 24), Contains(says));
    };
    refusal([](LodParams& p) { p.levels = 5; }, "levels");
    refusal([](LodParams& p) { p.distance_1 = NAN; }, "distance_1");
    refusal([](LodParams& p) { p.distance_1 = -0.5f; }, "distance_1 = -0.5 m: expected 0 m or more, or -1");
    refusal([](LodParams& p) { p.distance_1 = 5, p.distance_3 = 4; }, "distance_3 = 4 m: a level before has 5 m");
    refusal([](LodParams& p) { p.distance_2 = 5; }, "distance_2 = 5 m is less than 20 m of the level before");
    refusal([](LodParams& p) { p.degree_1 = 3, p.degree_3 = 4; }, "degree_3 = 4: a level before has 3");
    refusal([](LodParams& p) { p.rays_1 = 100; }, "rays_1 = 100: expected 0, or a power of two of 32 or more");
    refusal([](LodParams& p) { p.rays_1 = 16; }, "rays_1 = 16");
    refusal([](LodParams& p) { p.rays_0 = 1024; }, "rays_0 = 1024: the bake has 512 relight rays a probe");
    refusal([](LodParams& p) { p.rays_1 = 128, p.rays_2 = 256; }, "rays_2 = 256: the level before has 128");
    refusal([](LodParams& p) { p.rays_1 = 64, p.degree_1 = 5; }, "degree_1 = 5: the weights of 64 rays integrate harmonics up to degree 4");
    refusal([](LodParams& p) { p.zones = true, p.side_angle = 30; }, "side_angle = 30 is less than front_angle = 60");
    refusal([](LodParams& p) { p.zones = true, p.behind_scale = 1; }, "behind_scale = 1 is less than side_scale = 2");
    refusal([](LodParams& p) { p.smoothing = 1.5f; }, "smoothing");
    CHECK_THROWS_WITH(lod_of(LodParams{}, 0, 7, 512, 3), Contains("no extent"));
    CHECK_THROWS_WITH(rule_at(Lod{}, {}, {0, 0, 0}), Contains("no direction"));
    CHECK_THROWS_WITH(rule_at(Lod{}, {}, {NAN, 0, 0}), Contains("no direction"));
}

TEST_CASE("lod: a receiver's level is the number of zero bits that both coordinates end in", "[probes][lod][IPR 4.2.3][analytic]") {
    CHECK(level_of_texel({0, 0}, 4) == 3);
    CHECK(level_of_texel({1, 0}, 4) == 0);
    CHECK(level_of_texel({2, 4}, 4) == 1);
    CHECK(level_of_texel({12, 4}, 4) == 2);
    CHECK(level_of_texel({8, 16}, 4) == 3);
    CHECK(level_of_texel({8, 16}, 3) == 2);
    CHECK(level_of_texel({8, 16}, 1) == 0);
    // Of 16 x 16 texels a quarter has each next level: table 5.8 has 67 682, 16 857, 4 210, 1 073 receivers.
    std::array<int, 4> at_least{};
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
            for (int k = 0; k < 4; ++k) at_least[std::size_t(k)] += is_computed(level_of_texel({x, y}, 4), k) ? 1 : 0;
    CHECK(at_least == std::array{256, 64, 16, 4});
}

TEST_CASE("lod: levels that are all alike change no bit of what is computed", "[probes][lod][pruning]") {
    const Update without = update(LodParams{});
    for (const glm::vec3 eye : {corner, glm::vec3(0, 3, 0), glm::vec3(40, 0, 0)}) {
        const Update with = update(alike(four()), eye);
        CHECK(with.lambda == without.lambda);  // the same rays, weights and degree for all probes
        std::int64_t computed = 0, wrong = 0;
        for (std::size_t i = 0; i < without.irradiance.size(); ++i) {
            const std::int32_t c = room().flat.cluster_of[i];
            const bool here = c >= 0 && is_computed(level_of_receiver(i, 4), with.levels.cluster[std::size_t(c)]);
            computed += here ? 1 : 0;
            wrong += with.irradiance[i] == (here ? without.irradiance[i] : glm::dvec3(0)) ? 0 : 1;
        }
        CHECK(wrong == 0);
        CHECK(computed == lod_counts(with.lod, room(), with.levels).receivers);
        CHECK(computed < std::int64_t(without.irradiance.size()));
    }
    // Where level 0 reaches everything nothing is left out.
    const Update near = update(alike(four(1e3f, 1e3f, 1e3f)));
    CHECK(near.irradiance == without.irradiance);
    CHECK(lod_counts(near.lod, room(), near.levels).receivers == lod_counts(without.lod, room(), without.levels).receivers);
}

TEST_CASE("lod: the stages leave each level's texels as they are without level of detail, to the bit", "[probes][lod][pruning]") {
    const Lod lod = lod_of(alike(four()), room());
    const Levels levels = levels_of(lod);
    Levels all = levels;
    std::fill(all.cluster.begin(), all.cluster.end(), 0), std::fill(all.probe.begin(), all.probe.end(), 0);
    const Stages with = by_stages(lod, levels), without = by_stages(lod, all);
    std::array<std::int64_t, 4> kept{}, changed{};
    for (int k = 0, first = 0, side = room().receivers.size.x; k < 4; first += side + 2, side = (side + 1) / 2, ++k)
        for (int y = first; y < first + side; ++y)
            for (int x = 0; x < side; ++x) {
                const std::int32_t place = with.data.cover(x, y);
                if (place < 0 || with.data.cluster[std::size_t(place)] < 0) continue;
                const int level = levels.cluster[std::size_t(with.data.cluster[std::size_t(place)])];
                if (!is_computed(with.data.receiver_level[std::size_t(place)], level)) {
                    REQUIRE(level > k);
                    REQUIRE(glm::vec3(with.lightmap(x, y)) == glm::vec3(0));  // never stale
                    continue;
                }
                ++(with.lightmap(x, y) == without.lightmap(x, y) ? kept : changed)[std::size_t(k)];
            }
    for (std::size_t k = 0; k < 4; ++k) CHECK(kept[k] > 20);
    CHECK(changed == std::array<std::int64_t, 4>{});
    CHECK(with.lambda.texels == without.lambda.texels);
    CHECK(with.basis.texels == without.basis.texels);
}

TEST_CASE("lod: the stages compute what the formulas say, to rounding", "[probes][lod]") {
    for (const bool published : {false, true}) {
        LodParams p = four();
        if (published) p.probe_level = ProbeLevel::radius;
        const Update u = update(p);
        const Stages s = by_stages(u.lod, u.levels);
        double most = 0, worst = 0;
        std::int64_t computed = 0;
        for (std::size_t i = 0; i < u.irradiance.size(); ++i) {
            const glm::vec4 stage = s.irradiance.texels[std::size_t(s.data.place_of[i])];
            computed += stage.w == 1 ? 1 : 0;
            for (int c = 0; c < 3; ++c) {
                most = std::max(most, std::fabs(u.irradiance[i][c]));
                worst = std::max(worst, std::fabs(double(stage[c]) - u.irradiance[i][c]));
            }
        }
        CHECK(computed == lod_counts(u.lod, room(), u.levels).receivers);
        CHECK(most > 1);
        CHECK(worst < 2e-5 * most);  // sums of 512 rays, 1,500 coefficients and 32 singular values: some 30 roundings of 6e-8 by chance
    }
}

TEST_CASE("lod: fewer rays and coefficients far away leave what level 0 computes of probes of level 0 as it was",
          "[probes][lod][pruning]") {
    const Update without = update(LodParams{}), with = update(four());
    std::array<int, 4> kept{}, changed{};
    for (std::size_t i = 0; i < without.irradiance.size(); ++i) {
        const std::int32_t c = room().flat.cluster_of[i];
        if (c < 0) continue;
        const std::size_t level = std::size_t(with.levels.cluster[std::size_t(c)]);
        if (!is_computed(level_of_receiver(i, 4), int(level))) continue;
        ++(with.irradiance[i] == without.irradiance[i] ? kept : changed)[level];
    }
    CHECK(kept[0] > 100);
    CHECK(changed[0] == 0);  // probes of a cluster of level 0 are of level 0
    CHECK(changed[1] > 100);
    CHECK(changed[2] + changed[3] > 10);
}

TEST_CASE("lod: each coefficient that a cluster reads is computed", "[probes][lod][pruning]") {
    LodParams p = four();
    std::array<std::int64_t, 3> missing{};
    for (const ProbeLevel from : {ProbeLevel::centre, ProbeLevel::radius, ProbeLevel::clusters}) {
        p.probe_level = from;
        const Lod lod = lod_of(p, room());
        const Levels levels = levels_of(lod);
        for (std::size_t c = 0; c < levels.cluster.size(); ++c)
            for (std::int32_t k = room().flat.first_probe[c]; k < room().flat.first_probe[c + 1]; ++k) {
                const std::size_t probe = std::size_t(room().flat.probes[std::size_t(k)]);
                const int has = lod.coefficients[std::size_t(levels.probe[probe])], reads = lod.coefficients[std::size_t(levels.cluster[c])];
                missing[std::size_t(from)] += std::max(reads - has, 0);
            }
    }
    CHECK(missing[std::size_t(ProbeLevel::centre)] > 0);   // figure 4.6
    CHECK(missing[std::size_t(ProbeLevel::radius)] < missing[std::size_t(ProbeLevel::centre)]);
    CHECK(missing[std::size_t(ProbeLevel::clusters)] == 0);
}

namespace {

// Points on surfaces, the four texels that a lookup of their level reads, and for a texel beside charts the receivers that its two
// rings take: what lookup_reach says. Adds up over views.
struct Found {
    std::array<std::int64_t, 4> of_level{};  // lookups
    std::int64_t read = 0, black = 0;        // receivers; of them not computed
    std::int64_t beyond = 0;                 // of them farther than the margin says
};

struct Point {
    glm::vec3 position;
    glm::vec2 uv;
};
std::vector<Point> surface_points(int each) {
    const Geometry& g = room().atlas.geometry;
    std::vector<Point> points;
    for (std::uint32_t t = 0; t < g.triangles.size(); ++t)
        for (std::uint32_t s = 0; s < std::uint32_t(each); ++s) {
            float b = float(pcg(s * 977 + t) & 0xffff) / 65536.0f, c = float(pcg(s * 313 + 7 * t) & 0xffff) / 65536.0f;
            if (b + c > 1) b = 1 - b, c = 1 - c;
            const glm::uvec3 v = g.triangles[t];
            const auto between = [&](const auto& x, const auto& y, const auto& z) { return x + b * (y - x) + c * (z - x); };
            points.push_back({between(g.vertices[v.x].position, g.vertices[v.y].position, g.vertices[v.z].position),
                              between(room().atlas.uv[v.x], room().atlas.uv[v.y], room().atlas.uv[v.z])});
        }
    return points;
}

void look_up(const Image<std::int32_t>& at, const Point& p, int level, const Levels& levels, Found& found) {
    ++found.of_level[std::size_t(level)];
    const int wide = 1 << level;
    const auto texel = [&](float u) { return int(std::floor((u * float(at.width) - 0.5f) / float(wide))); };
    for (int y = texel(p.uv.y) - 2; y <= texel(p.uv.y) + 3; ++y)
        for (int x = texel(p.uv.x) - 2; x <= texel(p.uv.x) + 3; ++x) {
            if (x < 0 || y < 0 || x * wide >= at.width || y * wide >= at.height || at(x * wide, y * wide) < 0) continue;
            const std::size_t i = std::size_t(at(x * wide, y * wide));
            if (room().flat.cluster_of[i] < 0) continue;
            const std::size_t cluster = std::size_t(room().flat.cluster_of[i]);
            ++found.read;
            found.black += is_computed(level_of_texel({x * wide, y * wide}, 4), levels.cluster[cluster]) ? 0 : 1;
            const glm::dvec3 d = glm::dvec3(room().receivers.position[i]) - glm::dvec3(p.position);
            found.beyond += std::sqrt(glm::dot(d, d)) > double(wide) * double(boxes().cluster_low[cluster].w) ? 1 : 0;
        }
}

Found fragments_of(const LodParams& params, const LodBoxes& of) {
    const Bake& bake = room();
    Image<std::int32_t> at(bake.receivers.size.x, bake.receivers.size.y, -1);
    for (std::size_t i = 0; i < bake.receivers.texel.size(); ++i) at(bake.receivers.texel[i].x, bake.receivers.texel[i].y) = std::int32_t(i);
    const std::vector<Point> points = surface_points(300);
    const Lod lod = lod_of(params, bake);
    Found found;
    for (std::uint32_t view = 0; view < 24; ++view) {
        const auto random = [&](std::uint32_t i) { return float(pcg(view * 64 + i) & 0xffffff) / 16777216.0f; };
        const glm::vec3 eye = 8.0f * glm::vec3(random(0), random(1), random(2)) - 4.0f;
        const glm::vec3 forward = glm::vec3(random(3), random(4), random(5)) - 0.5f;
        const Levels levels = levels_at(lod, bake, of, eye, forward, {});
        const LevelRule rule = fragment_rule_at(lod, eye, forward);
        for (const Point& p : points) {
            const PointLevel l = level_at(rule, p.position);
            look_up(at, p, l.level, levels, found);
            if (l.share > 0) look_up(at, p, l.level + 1, levels, found);
        }
    }
    return found;
}

}  // namespace

TEST_CASE("lod: every fragment finds its receivers computed", "[probes][lod][pruning]") {
    LodParams params = four();
    for (const bool zones : {false, true})
        for (const float shift : {0.0f, 0.5f}) {
            CAPTURE(zones, shift);
            params.zones = zones, params.fragment_shift = shift;
            const Found found = fragments_of(params, boxes());
            for (const std::int64_t n : found.of_level) CHECK(n > 40);
            CHECK(found.read > 500000);
            CHECK(found.beyond == 0);
            CHECK(found.black == 0);
        }
    // As published, by the boxes of receivers alone, some read what is not computed.
    LodBoxes bare = boxes();
    for (glm::vec4& low : bare.cluster_low) low.w = 0;
    params.zones = false, params.fragment_shift = 0;
    CHECK(fragments_of(params, bare).black > 0);
}

TEST_CASE("lod: counts of what is left out, by hand", "[probes][lod]") {
    // All in level k: a quarter of the receivers each, but for the edges of charts; a power of the coefficients.
    std::int64_t before = 0;
    for (int k = 0; k < 4; ++k) {
        const float far = 1e3f;
        LodParams p = four(k > 0 ? 0 : far, k > 1 ? 0 : far, k > 2 ? 0 : far);
        const Update u = update(p);
        const LodCounts n = lod_counts(u.lod, room(), u.levels);
        const std::size_t level = std::size_t(k);
        CHECK(n.clusters[level] == room().flat.count());
        CHECK(n.probes[level] == 24);
        CHECK(n.rays == 24 * (512 >> k));
        CHECK(n.lambda_terms == n.rays * u.lod.coefficients[level]);
        std::int64_t terms = 0;
        for (const Cluster& c : room().clusters.clusters) terms += std::int64_t(c.probes.size()) * c.rank * u.lod.coefficients[level];
        CHECK(n.basis_terms == terms);
        const std::int64_t nonzero = std::count_if(u.irradiance.begin(), u.irradiance.end(), [](const glm::dvec3& e) { return e != glm::dvec3(0); });
        CHECK(n.receivers == nonzero);
        if (k > 0) CHECK(std::fabs(double(n.receivers) / double(before) - 0.25) < 0.08);
        before = n.receivers;
        CHECK(n.bytes == 16 * n.rays + 4 * (n.basis_terms + n.irradiance_terms) + 16 * n.receivers);
    }
    CHECK(charts_missing(room(), 4)[0] == 0);
}
