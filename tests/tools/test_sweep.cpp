// Sweeps: curves from fields(), medians, the front, the setting to take, what changed beyond noise, JSON and CSV.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "tools/shared/sweep.h"

using namespace plumb;
using namespace plumb::cli;
using Catch::Matchers::Contains;

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

SweepPoint point(const std::string& settings, std::vector<double> ms, double rmse) {
    SweepPoint p;
    p.scene = "box.toml", p.method = "rsm.disc", p.settings = settings;
    p.changed = {{"rsm", "gather", std::string("disc"), ""}, {"rsm", "samples", 100.0, ""}};
    p.frame_ms = std::move(ms);
    p.full = {rmse, rmse * rmse, rmse / 2, 1e-3, false};
    p.own = {0.01, 1e-4, 0.005, 1e-3, false};
    p.peak_bytes = 123456789012;
    p.picture_hash = 0xfedcba9876543210;
    summarise(p, p.frame_ms);
    return p;
}
SweepPoint steady(const std::string& settings, double ms, double rmse) {
    return point(settings, {ms, ms, ms, ms, ms}, rmse);
}

Sweep sweep(std::vector<SweepPoint> points) {
    Sweep s;
    s.isa = "avx2", s.processor = "a processor", s.threads = 2, s.runs = 5, s.memory = "resident";
    s.scenes = {{"box.toml", 24, 16, 7, 8, 256, 0.01}};
    s.points = std::move(points);
    mark_pareto(s.points);
    return s;
}

std::vector<std::string> names(const std::vector<SweptMethod>& curves) {
    std::vector<std::string> result;
    for (const SweptMethod& c : curves) result.push_back(c.name);
    return result;
}

std::string message(const std::function<void()>& f) {
    try {
        f();
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST_CASE("sweep: quantiles lie between the two nearest values", "[sweep]") {
    CHECK(quantile({3, 1, 2}, 0.5) == 2);
    CHECK(quantile({4, 1, 3, 2}, 0.5) == 2.5);
    CHECK(quantile({5, 1, 4, 2, 3}, 0.25) == 2);
    CHECK(quantile({5, 1, 4, 2, 3}, 0.75) == 4);
    CHECK(quantile({7}, 0.75) == 7);
    CHECK(std::isnan(quantile({}, 0.5)));
}

TEST_CASE("sweep: the front has the points that none beats, and none without an error", "[sweep]") {
    std::vector<SweepPoint> points = {steady("fast", 10, 0.5),       steady("near", 100, 0.1),
                                      steady("beaten", 110, 0.2),    steady("as near, slower", 120, 0.1),
                                      steady("no number", 1, undefined),   steady("infinite", 1, infinite),
                                      steady("twin", 10, 0.5),       steady("no time", undefined, 0.01)};
    SweepPoint elsewhere = steady("elsewhere", 500, 3);
    elsewhere.scene = "other.toml";
    points.push_back(elsewhere);
    mark_pareto(points);
    std::vector<std::string> front;
    for (const SweepPoint& p : points)
        if (p.pareto) front.push_back(p.settings);
    CHECK(front == std::vector<std::string>{"fast", "near", "twin", "elsewhere"});
}

TEST_CASE("sweep: the setting to take is the nearest in time, or the fastest that is near enough", "[sweep]") {
    const Sweep s = sweep({steady("a", 10, 0.5), steady("b", 50, 0.2), steady("c", 60, 0.2), steady("d", 200, 0.1),
                           steady("e", 5, undefined), steady("f", undefined, 0)});
    auto name = [](const SweepPoint* p) { return p ? p->settings : "none"; };
    CHECK(name(best_within(s, "box.toml", 100)) == "b");
    CHECK(name(best_within(s, "box.toml", 10)) == "a");
    CHECK(name(best_within(s, "box.toml", 1000)) == "d");
    CHECK(name(best_within(s, "box.toml", 9.99)) == "none");
    CHECK(name(best_within(s, "box.toml", undefined)) == "none");
    CHECK(name(best_within(s, "other.toml", 100)) == "none");
    CHECK(name(fastest_with(s, "box.toml", 0.2)) == "b");
    CHECK(name(fastest_with(s, "box.toml", 0.15)) == "d");
    CHECK(name(fastest_with(s, "box.toml", 0.05)) == "none");
    CHECK(name(fastest_with(s, "box.toml", undefined)) == "none");
    CHECK(name(fastest(s, "box.toml")) == "a");
}

TEST_CASE("sweep: a median that moved within the spread of its runs is no regression", "[sweep]") {
    const Sweep before = sweep({point("noisy", {80, 90, 100, 110, 120}, 0.1), point("steady", {99, 100, 100, 100, 101}, 0.1)});

    SECTION("the same again") { CHECK(compare_sweeps(before, before).worse.empty()); }
    SECTION("a tenth slower: beyond what steady runs explain, within what noisy ones do") {
        const Sweep now =
            sweep({point("noisy", {88, 99, 110, 121, 132}, 0.1), point("steady", {109, 110, 110, 110, 111}, 0.1)});
        const SweepComparison c = compare_sweeps(before, now);
        REQUIRE(c.worse.size() == 1);
        CHECK(c.worse[0].now->settings == "steady");
        CHECK_THAT(c.worse[0].what, Contains("box.toml: rsm.disc, steady") && Contains("+10.0 %"));
        // The other way round it got better.
        REQUIRE(compare_sweeps(now, before).better.size() == 1);
        CHECK(compare_sweeps(now, before).worse.empty());
    }
    SECTION("less than 5 % is no news, however steady") {
        CHECK(compare_sweeps(before, sweep({steady("steady", 104, 0.1)})).worse.empty());
        CHECK(compare_sweeps(before, sweep({steady("steady", 106, 0.1)})).worse.size() == 1);
    }
    SECTION("one slow run does not hide the others, nor make a regression alone") {
        CHECK(compare_sweeps(before, sweep({point("steady", {100, 100, 900, 100, 100}, 0.1)})).worse.empty());
        CHECK(compare_sweeps(before, sweep({point("steady", {150, 150, 900, 150, 150}, 0.1)})).worse.size() == 1);
    }
    SECTION("a time that is no number is slower") {
        CHECK(compare_sweeps(before, sweep({steady("steady", undefined, 0.1)})).worse.size() == 1);
    }
    SECTION("another machine's times say nothing") {
        for (int what = 0; what < 3; ++what) {
            Sweep now = sweep({steady("steady", 200, 0.1)});
            if (what == 0) now.processor = "another";
            if (what == 1) now.isa = "sse";
            if (what == 2) now.threads = 1;
            const SweepComparison c = compare_sweeps(before, now);
            CHECK(c.worse.empty());
            REQUIRE(!c.notes.empty());
            CHECK_THAT(c.notes[0], Contains("times are not compared"));
        }
    }
}

TEST_CASE("sweep: an error that grew is a regression, beyond rounding or the noise of two truths", "[sweep]") {
    const Sweep before = sweep({steady("a", 100, 0.1)});
    CHECK(compare_sweeps(before, sweep({steady("a", 100, 0.1 * (1 + 1e-7))})).worse.empty());
    CHECK(compare_sweeps(before, sweep({steady("a", 100, 0.1 * (1 + 1e-5))})).worse.size() == 1);
    CHECK(compare_sweeps(before, sweep({steady("a", 100, 0.1 * (1 - 1e-5))})).better.size() == 1);
    CHECK(compare_sweeps(before, sweep({steady("a", 100, undefined)})).worse.size() == 1);
    CHECK(compare_sweeps(sweep({steady("a", 100, undefined)}), before).worse.empty());

    // Each truth has a standard error of 1e-3.
    Sweep other = sweep({steady("a", 100, 0.1019)});
    other.scenes[0].truth = 9;
    CHECK(compare_sweeps(before, other).worse.empty());
    other.points[0].full.rmse = 0.1021;
    CHECK(compare_sweeps(before, other).worse.size() == 1);

    Sweep own = before;
    own.points[0].own.rmse = 0.011;
    REQUIRE(compare_sweeps(before, own).worse.size() == 1);
    CHECK_THAT(compare_sweeps(before, own).worse[0].what, Contains("its own transport"));
}

TEST_CASE("sweep: what stands in one sweep alone is said, and another scene is not compared", "[sweep]") {
    const Sweep before = sweep({steady("a", 100, 0.1), steady("b", 100, 0.1)});
    const Sweep now = sweep({steady("a", 100, 0.1), steady("c", 100, 0.1)});
    const SweepComparison c = compare_sweeps(before, now);
    CHECK(c.compared == 1);
    REQUIRE(c.notes.size() == 2);
    CHECK_THAT(c.notes[0], Contains("c: new"));
    CHECK_THAT(c.notes[1], Contains("b: not measured"));

    Sweep changed = before;
    changed.scenes[0].content = 1;
    CHECK(compare_sweeps(before, changed).compared == 0);
}

TEST_CASE("sweep: a point that is left out now is worse, one that was not asked for is a note", "[sweep]") {
    const Sweep before = sweep({steady("a", 100, 0.1), steady("b", 100, 0.1)});
    Sweep now = sweep({steady("a", 100, 0.1)});
    CHECK(compare_sweeps(before, now).worse.empty());
    for (const bool too_long : {true, false}) {
        now.left_out = {{"box.toml", "rsm.disc", "b", "took 9000 ms", too_long}};
        const SweepComparison c = compare_sweeps(before, now);
        REQUIRE(c.worse.size() == 1);
        CHECK_THAT(c.worse[0].what, Contains("box.toml: rsm.disc, b: left out") && Contains("took 9000 ms"));
        CHECK(c.worse[0].before == &before.points[1]);
        CHECK(c.notes.empty());
        // What is left out took no time that another machine's could be held against; a refusal is one anywhere.
        Sweep elsewhere = now;
        elsewhere.processor = "another";
        CHECK(compare_sweeps(before, elsewhere).worse.size() == (too_long ? 0u : 1u));
        Sweep changed = now;
        changed.scenes[0].content = 1;
        CHECK(compare_sweeps(before, changed).worse.empty());
    }
    // Another curve, scene or setting that is left out is another point.
    for (const LeftOut& other : {LeftOut{"x.toml", "rsm.disc", "b", "", true}, LeftOut{"box.toml", "rsm.all", "b", "", true},
                                 LeftOut{"box.toml", "rsm.disc", "c", "", true}}) {
        now.left_out = {other};
        CHECK(compare_sweeps(before, now).worse.empty());
    }
}

TEST_CASE("sweep: JSON reads back as it was, also what is no number", "[sweep][contract]") {
    Sweep s = sweep({point("a", {1.5, 2.25, 0.1, 7, 3}, 0.1), steady("b", 2, undefined)});
    s.points[0].own.below_noise = true;
    s.points[0].base = frame::Method::direct;
    s.left_out = {{"box.toml", "rsm.all", "", "took 9000 ms", true}};
    s.notes = {"a note"};
    const Json json = sweep_json(s);
    const Sweep again = sweep_of(json_text(json), "text");
    CHECK(sweep_json(again) == json);
    CHECK(again.points[0].frame_ms == s.points[0].frame_ms);
    CHECK(again.points[0].picture_hash == s.points[0].picture_hash);
    CHECK(again.points[0].base == frame::Method::direct);
    CHECK(std::get<double>(again.points[0].changed[1].value) == 100);
    CHECK(std::isnan(again.points[1].full.rmse));
    CHECK(again.left_out[0].reason == "took 9000 ms");
    CHECK(again.left_out[0].too_long);
}

TEST_CASE("sweep: a file that is no sweep is refused at its first fault", "[sweep][contract]") {
    const Json good = sweep_json(sweep({steady("a", 1, 0.1)}));
    auto refused = [&](const std::function<void(Json&)>& break_it) {
        Json json = good;
        break_it(json);
        return message([&] { sweep_of(json_text(json), "old.json"); });
    };
    CHECK(refused([](Json&) {}) == "no error");
    CHECK(message([] { sweep_of("{", "old.json"); }) == "old.json: byte 2: no JSON");
    CHECK(message([] { sweep_of("[]", "old.json"); }) == "old.json: the whole: expected an object");
    CHECK(refused([](Json& j) { j.erase("points"); }) == "old.json: points: expected a value");
    CHECK(refused([](Json& j) { j["points"][0]["median_ms"] = "1"; }) == "old.json: points[0].median_ms: expected a number");
    CHECK(refused([](Json& j) { j["points"][0]["median_ms"] = -1; }) ==
          "old.json: points[0].median_ms: expected a number of at least 0");
    // Where a sweep always writes a number, null is none.
    for (const char* key : {"median_ms", "low_ms", "high_ms", "stage_ms"})
        CHECK(refused([&](Json& j) { j["points"][0][key] = nullptr; }) ==
              std::string("old.json: points[0].") + key + ": expected a number");
    CHECK(refused([](Json& j) { j["points"][0]["frame_ms"][2] = nullptr; }) ==
          "old.json: points[0].frame_ms[2]: expected a number");
    CHECK(refused([](Json& j) { j["points"][0]["changed"][1]["value"] = nullptr; }) ==
          "old.json: points[0].changed[1].value: expected a number");
    CHECK(refused([](Json& j) { j["points"][0]["median_ms"] = 0; }) ==
          "old.json: points[0].median_ms: expected a number above 0");
    CHECK(message([] { sweep_of("{\"runs\": 1e999}", "old.json"); }) == "old.json: a number that is not finite");
    CHECK(refused([](Json& j) { j["points"][0]["full"]["rmse"] = nullptr; }) == "no error");
    CHECK(refused([](Json& j) { j["points"][0]["picture"] = "0"; }) ==
          "old.json: points[0].picture: expected 16 hexadecimal digits");
    CHECK(refused([](Json& j) { j["points"][0]["frame_ms"] = Json::array(); }) ==
          "old.json: points[0].frame_ms: expected at least one run");
    CHECK_THAT(refused([](Json& j) { j["points"][0]["method"] = "rms"; }),
               Contains("old.json: points[0].method") && Contains("direct, rsm, isr, probes, radiosity, zbuffer, reference"));
    CHECK(refused([](Json& j) { j["threads"] = -1; }) ==
          "old.json: threads: expected a whole number from 0 to 2147483647");
}

TEST_CASE("sweep: CSV has a line a point, and quotes what is text", "[sweep][contract]") {
    SweepPoint p = steady("rsm.samples = 50, rsm.radius = 0.5", 2, 0.25);
    p.scene = "a \"box\".toml";
    const std::string csv = sweep_csv(sweep({p}));
    const std::string expected =
        "scene,method,curve,settings,median_ms,low_ms,high_ms,stage_ms,runs,peak_bytes,own_rmse,own_rel_mse,"
        "own_mean_error,own_standard_error,full_rmse,full_rel_mse,full_mean_error,full_standard_error,pareto,picture\n"
        "\"a \"\"box\"\".toml\",rsm,\"rsm.disc\",\"rsm.samples = 50, rsm.radius = 0.5\",2,2,2,2,5,123456789012,0.01,0.0001,"
        "0.005,0.001,0.25,0.0625,0.125,0.001,1,fedcba9876543210\n";
    CHECK(csv == expected);
}

TEST_CASE("sweep: curves follow from what fields() say", "[sweep]") {
    const frame::Settings settings;
    // rsm: a curve for each gather, and of the disc for each other value of what changes its bias; gather.cpp.
    CHECK(names(swept_methods(settings, {}, {})) ==
          std::vector<std::string>{"direct", "rsm.disc", "rsm.disc, variant = published", "rsm.disc, radius = 0.15",
                                   "rsm.disc, radius = 0.6", "rsm.disc, rotations = 1", "rsm.disc, sample_area = texels", "rsm.all", "rsm.all_rays",
                                   "rsm.paths", "rsm.paths, visibility = none", "rsm.paths, visibility = algorithm_2",
                                   "rsm.paths, slots = 9", "rsm.paths, turn = hash", "isr", "isr, reach = 0.5", "isr, reach = 1", "isr, bounces = 2", "probes", "probes, degree_0 = 4", "probes, hit_level = coarsest",
                                   "probes, zones = true", "radiosity", "zbuffer", "zbuffer, technique = CAD",
                                   "zbuffer, technique = CADS", "reference"});
    const std::vector<SweptMethod> disc = swept_methods(settings, {"rsm.disc"}, {});
    REQUIRE(disc.size() == 6);
    const std::vector<SweptSettings> points = points_of(disc[0]);
    REQUIRE(points.size() == 6);
    CHECK(points.front().text == "rsm.samples = 25");
    const frame::Settings last = apply(settings, disc[0].method, points.back().changed);
    CHECK(last.rsm.samples == 800);
    CHECK(last.rsm.gather == rsm::Gather::disc);
    // A parameter that another one silences: until_error decides how many samples are taken.
    frame::Settings until = settings;
    until.reference.until_error = 0.1f;
    const SweptMethod reference = swept_methods(until, {"reference"}, {}).at(0);
    CHECK(apply(until, reference.method, points_of(reference)[0].changed).reference.until_error == 0);
    // Of probes what is left out of far away: lod.cpp.
    const std::vector<SweptMethod> probes = swept_methods(settings, {"probes"}, {});
    REQUIRE(probes.size() == 4);
    const std::vector<SweptSettings> levels = points_of(probes[3]);
    REQUIRE(levels.size() == 4);
    CHECK(levels[3].text == "lod.levels = 4");
    const frame::Settings coarse = apply(settings, probes[3].method, levels[3].changed);
    CHECK((coarse.lod.levels == 4 && coarse.lod.zones));
    // The scene's own value has no second curve.
    frame::Settings wide = settings;
    wide.rsm.radius = 0.6f;
    CHECK(names(swept_methods(wide, {"rsm.disc"}, {}))[3] == "rsm.disc, radius = 0.3");
}

TEST_CASE("sweep: --vary takes the place of the ranges of the curves that it concerns", "[sweep]") {
    const frame::Settings settings;
    const std::vector<SweptMethod> curves =
        swept_methods(settings, {"rsm"}, {"rsm.samples=10,20", "rsm.radius=0.1,0.2,0.4"});
    CHECK(names(curves) ==
          std::vector<std::string>{"rsm.disc, samples = 10", "rsm.disc, samples = 20", "rsm.all", "rsm.all_rays", "rsm.paths", "rsm.paths, visibility = none",
                                   "rsm.paths, visibility = algorithm_2", "rsm.paths, slots = 9", "rsm.paths, turn = hash"});
    // The last one runs along the curve; each value of the one before it is a curve, so that none goes back and forth.
    CHECK(points_of(curves[0]).size() == 3);
    CHECK(points_of(curves[1])[2].text == "rsm.radius = 0.4");
    const frame::Settings corner = apply(settings, curves[1].method, points_of(curves[1])[2].changed);
    CHECK((corner.rsm.samples == 20 && corner.rsm.radius == 0.4f));
    CHECK(points_of(curves[2]).size() == 1);
    CHECK(points_of(curves[3]).size() == 4);
    // Three of them: a curve for each pair; what is of another table says so.
    CHECK(names(swept_methods(settings, {"rsm.disc"}, {"shadow.kernel=1,4", "rsm.radius=0.1,0.2", "rsm.samples=10,20"})) ==
          std::vector<std::string>{"rsm.disc, shadow.kernel = 1, radius = 0.1", "rsm.disc, shadow.kernel = 1, radius = 0.2",
                                   "rsm.disc, shadow.kernel = 4, radius = 0.1", "rsm.disc, shadow.kernel = 4, radius = 0.2"});
    // What all methods share varies on every curve; which gathers there are can be said, too.
    CHECK(names(swept_methods(settings, {}, {"rsm.gather=all", "shadow.kernel=1,4"})) ==
          std::vector<std::string>{"direct", "rsm.all", "isr", "probes", "radiosity", "zbuffer", "reference"});
    // What one method alone reads varies on no other's curves, whatever its table is called.
    const std::vector<SweptMethod> far = swept_methods(settings, {}, {"lod.levels=1,4", "probes.count=8,16"});
    for (const SweptMethod& curve : far) {
        CAPTURE(curve.name);
        for (const Variation& v : curve.varied) CHECK((v.table == "lod" || v.table == "probes") == (curve.name.starts_with("probes,")));
        if (curve.name.starts_with("probes")) CHECK(points_of(curve).size() == 2);
    }

    auto refused = [&](std::vector<std::string> methods, std::vector<std::string> vary) {
        return message([&] { swept_methods(settings, methods, vary); });
    };
    CHECK_THAT(refused({"rsm.dics"}, {}), Contains("--method rsm.dics") && Contains("'rsm.disc'"));
    CHECK_THAT(refused({}, {"rms.samples=1"}), Contains("--vary rms.samples") && Contains("[rsm]"));
    CHECK_THAT(refused({}, {"rsm.sample=1"}), Contains("'samples'"));
    CHECK_THAT(refused({}, {"rsm.samples=1,x"}), Contains("--vary rsm.samples: samples = \"x\""));
    CHECK_THAT(refused({}, {"rsm.samples=0"}), Contains("1 to 65536"));
    CHECK_THAT(refused({}, {"rsm.samples="}), Contains("expected table.key=a,b,c"));
    CHECK_THAT(refused({}, {"rsm.samples=1,1"}), Contains("twice"));
    CHECK_THAT(refused({}, {"rsm.samples=1", "rsm.samples=2"}), Contains("twice"));
    CHECK_THAT(refused({"rsm.all"}, {"rsm.samples=1"}), Contains("changes nothing"));
}
