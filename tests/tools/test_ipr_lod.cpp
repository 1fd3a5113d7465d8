// plumb experiment ipr, level of detail: the thesis' figures, setups, gaps, and a small bake measured.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "tests/gi/probe_bakes.h"
#include "tools/experiments/ipr_lod.h"
#include "tools/experiments/ipr_truth.h"

using namespace plumb;
using namespace plumb::cli;
using namespace plumb::test;

namespace {

// A room of 8 m under a lamp.
struct Room {
    Scene scene = furnished(4);
    probes::BakeParams params = small();
    std::unique_ptr<probes::BakeGraph> graph;

    Room() {
        Light lamp;
        lamp.type = LightType::point, lamp.position = {2, 3, 1}, lamp.intensity = {40, 30, 20};
        scene.lights = {lamp};
        scene.camera.position = {-3.5, -2, -3.5}, scene.camera.look_at = {2, -1, 2}, scene.camera.fov_y_deg = 60;
        params.placement.count = 12, params.placement.overlaps = 4, params.receiver_rays = 32, params.receivers_per_m2 = 30;
        params.relight_rays = 512, params.gap = 24;
        graph = std::make_unique<probes::BakeGraph>(scene, params);
        run_all(*graph);
    }
};
const Room& room() {
    static const Room r;
    return r;
}
const LodBench& bench() {
    static const RunOptions options;
    static const LodBench b(room().scene, room().graph->bake(), options);
    return b;
}
LodView view() { return {"corner", room().scene.camera, {96, 64}}; }

}  // namespace

TEST_CASE("experiment ipr: the thesis' speed-ups are the quotients of its times", "[experiment][probes][IPR tables 5.5 to 5.9]") {
    REQUIRE(thesis_lod_tables().size() == 6);
    for (const LodTable& t : thesis_lod_tables()) {
        if (t.number == "figure 5.32") continue;  // has no times
        const auto slowest = std::max_element(t.rows.begin(), t.rows.end(), [](const LodFigures& a, const LodFigures& b) { return a.ms < b.ms; });
        for (const LodFigures& f : t.rows) {
            CAPTURE(t.number, f.setup);
            // As they are printed: times to 0.01 ms, quotients to 0.01; table 5.8's are of times with more digits.
            CHECK(std::fabs(f.speed_up - slowest->ms / f.ms) < 0.011 + 0.005 * (slowest->ms + f.ms) / (f.ms * f.ms));
            (void)lod_setup(f.setup);
        }
    }
}

TEST_CASE("experiment ipr: setups of the thesis fit a bake of 512 rays and degree 7", "[experiment][probes]") {
    for (const char* name : {"NO LOD", "S0", "S1", "S2", "D0", "D1", "D2", "SD0", "SD1", "SD2", "LOD 0", "LOD 3", "SH 0", "SH 7"}) {
        CAPTURE(name);
        const probes::Lod lod = probes::lod_of(lod_setup(name).params, 100, 7, 512, 24);
        CHECK(lod.degree[0] == (std::string(name) == "S2" || std::string(name) == "SD1" ? 4 : std::string(name) == "SH 0" ? 0 : 7));
    }
    CHECK(probes::lod_of(lod_setup("S0").params, 100, 7, 512, 24).rays == std::array{512, 256, 128, 64});
    CHECK(probes::lod_of(lod_setup("S1").params, 100, 7, 512, 24).rays == std::array{512, 256, 128, 128});  // 64 rays integrate degree 4
    CHECK(probes::lod_of(lod_setup("SD2").params, 100, 7, 512, 24).degree == std::array{7, 2, 0, 0});
    CHECK_THROWS_AS(lod_setup("S3"), InputError);
    // Figure 5.31's prefixes of the relight rays; a level that has fewer has the degrees that these sample.
    CHECK(probes::lod_of(lod_setup("R adaptive").params, 100, 7, 512, 24).rays == std::array{512, 256, 128, 64});
    CHECK(probes::lod_of(lod_setup("R 64").params, 100, 7, 512, 24).rays[0] == 64);
    CHECK(probes::lod_of(lod_setup("R 64").params, 100, 7, 512, 24).degree[0] < 7);
    // Of a smaller scene distances are smaller; 0 and "never" stay.
    CHECK(lod_setup("D1", 0.5).params.distance_2 == 12);
    CHECK(lod_setup("D2", 0.5).params.distance_1 == 0);
    CHECK(lod_setup("LOD 0", 0.5).params.distance_1 == lod_setup("LOD 0").params.distance_1);
    CHECK(lod_setup("zones").params.zones);
    CHECK_FALSE(lod_setup("no zones").params.zones);
}

TEST_CASE("experiment ipr: the largest gap is the one below the least that shows", "[experiment][probes]") {
    const auto pair = [](int near, int far, double seen) {
        LodSeam s;
        s.near = near, s.far = far, s.seen = seen;
        return s;
    };
    CHECK(largest_gaps({pair(3, 2, 0.01), pair(3, 1, 0.019), pair(3, 0, 0.05)}).largest_gap == 2);
    CHECK(largest_gaps({pair(3, 2, 0.01), pair(3, 1, 0.03), pair(3, 0, 0.01)}).largest_gap == 1);
    CHECK(largest_gaps({pair(3, 2, 0.01), pair(3, 1, 0.01), pair(3, 0, 0.01)}).largest_gap == 3);
    const LodSeams low = largest_gaps({pair(3, 2, 0.01), pair(3, 1, 0.01), pair(3, 0, 0.05), pair(1, 0, 0.2)});
    CHECK(low.largest_gap == 0);
    CHECK(low.largest_gap_from_top == 2);
    CHECK_THROWS_AS(largest_gaps({}), InputError);
}

TEST_CASE("experiment ipr: level of detail measured in a small room", "[experiment][probes][lod]") {
    LodSetup near{"near", lod_setup("D0").params};
    near.params.distance_1 = near.params.distance_2 = near.params.distance_3 = 100;
    LodSetup plain{"plain", lod_setup("D0").params};
    plain.params.distance_1 = 1.5f, plain.params.distance_2 = 3, plain.params.distance_3 = 6;
    const std::vector<LodMeasured> m = bench().measure(view(), {near, lod_setup("LOD 1"), lod_setup("SH 7"), lod_setup("SH 3"), lod_setup("SH 0"), plain}, 1);
    REQUIRE(m.size() == 7);
    const auto all = m[0].receivers;
    CHECK(m[0].setup == "NO LOD");
    CHECK(all > 5000);
    for (const LodMeasured& row : m) {
        CAPTURE(row.setup);
        CHECK(row.ms > 0);
        REQUIRE(row.ssim);
        CHECK(*row.ssim > 0.5);
        CHECK(row.worst >= row.error);
    }
    // Where level 0 reaches everything, and where the one level has all degrees, every pixel has the same bits.
    for (const std::size_t same : {std::size_t(0), std::size_t(1), std::size_t(3)}) {
        CHECK(m[same].receivers == all);
        CHECK(m[same].error == 0);
        CHECK(m[same].picture.texels == m[0].picture.texels);
        CHECK(*m[same].ssim == Approx(1));
    }
    CHECK(std::fabs(double(m[2].receivers) / double(all) - 0.25) < 0.05);
    CHECK(m[2].error > 0);
    CHECK(m[5].error > m[4].error);  // degree 0 against degree 3
    CHECK(m[4].error > 0);
    CHECK(m[6].receivers < all);
    // Zones leave out what lies behind a viewer in the middle.
    LodSetup zones = plain;
    zones.params.zones = true;
    LodView middle = view();
    middle.camera.position = {0, 2.5, 0}, middle.camera.look_at = {4, 2, 0.1};
    const std::vector<LodMeasured> z = bench().measure(middle, {plain, zones}, 1);
    CHECK(z[2].receivers < z[1].receivers);
    CHECK(z[2].error < 0.1);
    CHECK(lod_text("room", m, &thesis_lod_tables()[3]).find("LOD 1") != std::string::npos);
}

TEST_CASE("experiment ipr: what moves has a row of its own, and no part in that of surfaces", "[experiment][probes][lod][air]") {
    static const RunOptions options;
    Scene scene = room().scene;
    Mesh thing;
    add_box(thing, glm::vec3(-0.3f), glm::vec3(0.3f), 1);
    thing.name = "thing", thing.dynamic = true, thing.material.assign(thing.triangles.size(), 1);
    thing.transform[3] = glm::dvec4(2.5, 1.5, 2.5, 1);
    scene.meshes.push_back(thing);
    probes::BakeParams params = room().params;
    params.spatial_receivers = 64;
    probes::BakeGraph graph(scene, params);
    run_all(graph);
    const LodBench moving(scene, graph.bake(), options);
    LodSetup near{"near", lod_setup("D0").params};
    near.params.distance_1 = near.params.distance_2 = near.params.distance_3 = 100;
    const std::vector<LodSetup> setups = {near, lod_setup("SD1", 0.05)};
    const std::vector<LodMeasured> m = moving.measure(view(), setups, 1), still = bench().measure(view(), setups, 1);
    REQUIRE(m.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        CAPTURE(m[i].setup);
        REQUIRE(m[i].air);
        CHECK_FALSE(still[i].air);
        CHECK(m[i].receivers == still[i].receivers);
        CHECK((m[i].picture.texels == still[i].picture.texels));
        CHECK(m[i].air->read == 8);
        CHECK(m[i].air->computed == 8);
        CHECK(m[i].air->ms > 0);
        CHECK(m[i].air->least > 0.1);  // nothing is black
        CHECK(m[i].air->worst >= m[i].air->error);
    }
    // 8 receivers of each direction; near is what there is without levels.
    CHECK(m[0].air->counts.receivers == 6 * 8);
    CHECK(m[1].air->error == 0);
    CHECK(m[1].air->counts.bytes == m[0].air->counts.bytes);
    // Of degree 0 a 64th of the matrices is read.
    const probes::LodCounts& far = m[2].air->counts;
    CHECK(far.clusters[3] > 0);
    CHECK(far.basis_terms * 64 == m[0].air->counts.basis_terms);
    CHECK(m[2].air->error > 0.001);
    const std::string text = lod_text("room", m, nullptr);
    CHECK(text.find("what moves: 8 places in the air are read") != std::string::npos);
    CHECK(lod_json(m)[2]["air"]["places"] == 8);
    CHECK(lod_json(still)[2]["air"].is_null());
}

TEST_CASE("experiment ipr: seams grow with the gap, and there is none within a degree", "[experiment][probes][lod]") {
    const LodSeams seams = bench().seams();
    REQUIRE(seams.pairs.size() == 36);
    for (const LodSeam& s : seams.pairs) {
        CAPTURE(s.near, s.far);
        CHECK(s.seen <= s.tenth);
        if (s.gap() == 0) CHECK(s.tenth == 0);
        if (s.gap() > 0) CHECK(s.tenth > 0);
    }
    CHECK(seams.pairs[7].near == 7);
    CHECK(seams.pairs[7].far == 0);
    CHECK(seams.pairs[7].visible());  // a constant radiance for all that a probe sees
    CHECK(seams.largest_gap < 7);
    CHECK(seams.largest_gap_from_top >= seams.largest_gap);
    CHECK(seams_text(seams).find("thesis: 2") != std::string::npos);
}

TEST_CASE("experiment ipr: every row of level of detail has its error against the path tracer", "[experiment][probes][lod]") {
    static const RunOptions options;
    const probes::Bake& bake = room().graph->bake();
    IprRequest request;
    request.samples = 2048, request.receivers = 128;
    const IprTruth truth = trace_receivers(room().scene, bake.receivers, request, Rays::exact, options);
    LodView lit = view();
    lit.name = "traced", lit.samples = 64, lit.receivers = &truth, lit.levels = true;
    const std::vector<LodMeasured> m = bench().measure(lit, lod_setups({"SH 7", "SH 0", "D0"}, 0.1), 1, "SH 7");
    // The finest level is still seen.
    const std::vector<LodMeasured> b = bench().measure(lit, lod_setups({"borders: all", "borders: level 0", "borders: none"}, 0.25), 1);
    REQUIRE((m.size() == 4 && b.size() == 4));
    std::vector<LodMeasured> all = m;
    all.insert(all.end(), b.begin(), b.end());
    for (const LodMeasured& row : all) {
        CAPTURE(row.setup);
        REQUIRE((row.at_pixels && row.ssim_truth));
        CHECK(row.at_pixels->mean > 0.005);
        CHECK(row.at_pixels->mean >= std::fabs(row.at_pixels->bias));
        CHECK(row.at_pixels->noise > 0);
        CHECK(*row.ssim_truth < 1);
        CHECK(row.error_picture.size() == row.picture.size());
    }
    // All receivers are computed without levels, fewer with them. Degree 0 sees no direction.
    REQUIRE((m[0].at_receivers && m[3].at_receivers));
    CHECK(m[0].at_receivers->count == int(truth.index.size()));
    CHECK(m[3].at_receivers->count < int(truth.index.size()));
    CHECK(m[2].at_pixels->rms > m[1].at_pixels->rms);
    CHECK(m[0].at_pixels->mean == m[1].at_pixels->mean);
    // Light that ends at borders is missing beside them; in coarse levels more than in the finest.
    CHECK(b[3].at_pixels->bias < b[2].at_pixels->bias);
    CHECK(b[2].at_pixels->bias <= b[1].at_pixels->bias);
    // The reference is the one that was asked for.
    CHECK(*m[1].ssim == Approx(1));
    CHECK(*m[2].ssim < 1);
    CHECK_THROWS_AS(bench().measure(lit, {}, 1, "SH 9"), InputError);
    // Level 0 is red, others are not; what is not computed is black.
    const auto red = [](const glm::vec4& c) { return c.x > 2 * c.y && c.x > 2 * c.z; };
    CHECK(std::all_of(m[0].levels.texels.begin(), m[0].levels.texels.end(), [&](const glm::vec4& c) { return red(c) || c == glm::vec4(0); }));
    CHECK(std::any_of(m[3].levels.texels.begin(), m[3].levels.texels.end(), [&](const glm::vec4& c) { return c.w > 0 && !red(c); }));
    CHECK(lod_text("room", b, nullptr).find("borders: none") != std::string::npos);
    CHECK(lod_json(m)[2]["at_pixels"]["mean"] == m[2].at_pixels->mean);
}
