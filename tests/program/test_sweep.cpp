// plumb sweep and render --budget: files, keys, what is picked, and what got worse.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

const Words short_curve = {"--method", "direct", "--method", "rsm.disc", "--vary", "rsm.samples=4,16", "--spp", "16"};

Result sweep(const std::string& scene, const std::string& out, Words more) {
    more.insert(more.begin(), {"sweep", scene, "-o", out});
    return run(more);
}
Json sweep_json(const std::string& out) { return Json::parse(read(out + "/sweep.json")); }

std::string one_line(const Result& r) {
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}

}  // namespace

TEST_CASE("sweep: every file or none, stable keys, a line and a point for each setting", "[program][contract]") {
    const std::string folder = fresh_folder("sweep"), scene = small_scene(folder, "[24, 24]"), out = folder + "/out";
    set_cache(folder + "/cache");
    const Result r = sweep(scene, out, short_curve);
    INFO(r.err);
    REQUIRE(r.exit == 0);
    CHECK(files_in(out) == Words{"sweep.csv", "sweep.html", "sweep.json"});
    CHECK_THAT(r.out, Contains("rsm.samples = 16") && Contains("medians of 5 runs") && Contains("truth: 16 samples"));

    const Json json = sweep_json(out);
    CHECK(keys(json) ==
          Words{"isa", "processor", "threads", "runs", "memory", "scenes", "points", "left_out", "notes"});
    CHECK(keys(json["scenes"][0]) ==
          Words{"name", "width", "height", "content", "truth", "truth_samples", "truth_relative_error"});
    REQUIRE(json["points"].size() == 3);
    for (const Json& p : json["points"]) {
        CHECK(keys(p) == Words{"scene", "method", "curve", "settings", "changed", "frame_ms", "median_ms", "low_ms",
                               "high_ms", "stage_ms", "peak_bytes", "own", "full", "pareto", "picture"});
        CHECK(keys(p["full"]) ==
              Words{"rmse", "rel_mse", "mean_error", "standard_error", "below_noise", "truth_error"});
        CHECK(p["full"]["truth_error"] == p["full"]["standard_error"]);  // neither has noise of its own
        CHECK(p["frame_ms"].size() == 5);
        CHECK(p["low_ms"] <= p["median_ms"]);
        CHECK(p["median_ms"] <= p["high_ms"]);
        CHECK(p["stage_ms"] <= p["median_ms"]);
        CHECK(p["scene"] == scene);
    }
    CHECK(json["points"][2]["settings"] == "rsm.samples = 16");
    // What direct light leaves out against full illumination, one bounce by the disc has in part.
    CHECK(json["points"][0]["full"]["rmse"] > json["points"][2]["full"]["rmse"]);
    // Of its own transport, direct light alone, it misses nothing but shadows' edges.
    CHECK(json["points"][0]["own"]["rmse"] < json["points"][0]["full"]["rmse"]);

    const std::string csv = read(out + "/sweep.csv");
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 4);

    // Another run, with what was traced kept, on one thread: the same pictures and errors.
    Words again = short_curve;
    again.insert(again.end(), {"--threads", "1", "--json"});
    const Result second = sweep(scene, folder + "/again", again);
    REQUIRE(second.exit == 0);
    const Json other = Json::parse(second.out);
    CHECK(other == sweep_json(folder + "/again"));
    for (std::size_t i = 0; i < 3; ++i)
        for (const char* key : {"settings", "changed", "own", "full", "picture"})
            CHECK(other["points"][i][key] == json["points"][i][key]);
    CHECK(other["scenes"] == json["scenes"]);
}

TEST_CASE("sweep: the method reference's error falls as its samples grow, by paths that its truth does not have",
          "[program]") {
    const std::string folder = fresh_folder("sweep_reference"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    const Result r = sweep(scene, folder + "/out",
                           {"--method", "reference", "--vary", "reference.samples=4,64", "--spp", "64", "--json"});
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json points = Json::parse(r.out)["points"];
    REQUIRE(points.size() == 2);
    const double few = points[0]["full"]["rmse"], many = points[1]["full"]["rmse"];
    const double noise = points[1]["full"]["standard_error"];
    // Variances: 1/4 + 1/64 against 2/64 of one sample's. Of the same paths the second would be 0.
    CHECK(few > 2 * many);
    CHECK(many > noise / 2);
    CHECK(points[0]["own"] == points[0]["full"]);
    // The truth's noise is none of the picture's: with as many samples in both it is 1 / sqrt(2) of the sum.
    const double truth_noise = points[1]["full"]["truth_error"];
    CHECK(points[0]["full"]["truth_error"] == truth_noise);
    CHECK(truth_noise > 0.5 * noise);
    CHECK(truth_noise < 0.9 * noise);
}

TEST_CASE("sweep: a budget or an error picks a point of each scene, and says so", "[program]") {
    const std::string folder = fresh_folder("sweep_pick"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    auto picked = [&](const Words& how) {
        Words words = short_curve;
        words.insert(words.end(), how.begin(), how.end());
        words.push_back("--json");
        const Result r = sweep(scene, folder + "/out", words);
        INFO(r.err);
        REQUIRE(r.exit == 0);
        const Json json = Json::parse(r.out);
        REQUIRE(json["picked"].size() == 1);
        return std::pair{json, json["picked"][0]["point"]};
    };
    const auto [json, point] = picked({"--budget", "1000s"});
    for (const Json& p : json["points"]) CHECK(point["full"]["rmse"] <= p["full"]["rmse"]);
    CHECK(picked({"--budget", "1e-9ms"}).second.is_null());
    const auto [all, fast] = picked({"--error", "1e9"});
    for (const Json& p : all["points"]) CHECK(fast["median_ms"] <= p["median_ms"]);
}

TEST_CASE("sweep: what got slower or worse since an earlier one is exit code 1", "[program]") {
    const std::string folder = fresh_folder("sweep_compare"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    REQUIRE(sweep(scene, folder + "/old", short_curve).exit == 0);
    auto compare = [&](const std::function<void(Json&)>& change) {
        Json old = sweep_json(folder + "/old");
        for (Json& p : old["points"]) change(p);
        write(folder + "/old.json", old.dump());
        Words words = short_curve;
        words.insert(words.end(), {"--compare-to", folder + "/old.json"});
        return sweep(scene, folder + "/now", words);
    };
    // Runs of the same length, so that no spread hides a difference.
    auto take = [](Json& p, double ms) {
        for (const char* key : {"median_ms", "low_ms", "high_ms", "stage_ms"}) p[key] = ms;
        for (Json& run_ms : p["frame_ms"]) run_ms = ms;
    };
    const Result faster = compare([&](Json& p) { take(p, 1e9); });
    INFO(faster.out << faster.err);
    CHECK(faster.exit == 0);
    CHECK_THAT(faster.out, Contains("3 points against") && Contains("0 worse, 3 better"));
    CHECK(files_in(folder + "/now") == Words{"sweep.csv", "sweep.html", "sweep.json"});
    const Result worse = compare([&](Json& p) {
        take(p, 1e9);
        p["full"]["rmse"] = 0.99 * p["full"]["rmse"].get<double>();
    });
    CHECK(worse.exit == 1);
    CHECK_THAT(worse.out, Contains("WORSE: ") && Contains("RMSE against full illumination"));
    CHECK(sweep_json(folder + "/now")["comparison"]["worse"].size() == 3);
    const Result none = compare([](Json& p) { p["settings"] = "something else"; });
    CHECK(none.exit == 2);
    CHECK_THAT(one_line(none), Contains("nothing can be compared"));
}

TEST_CASE("sweep: what takes longer than asked for is left out, but never all", "[program]") {
    const std::string folder = fresh_folder("sweep_longest"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    Words words = short_curve;
    words.insert(words.end(), {"--longest", "1e-9ms", "--json"});
    const Result r = sweep(scene, folder + "/out", words);
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json json = Json::parse(r.out);
    CHECK(json["points"].size() == 1);
    REQUIRE(json["left_out"].size() == 2);
    CHECK(keys(json["left_out"][0]) == Words{"scene", "curve", "settings", "reason", "too_long"});
    CHECK(json["left_out"][0]["too_long"] == true);

    // Two points that an earlier sweep has are gone: that hides no slowdown.
    REQUIRE(sweep(scene, folder + "/old", short_curve).exit == 0);
    words.insert(words.end(), {"--compare-to", folder + "/old/sweep.json"});
    const Result gone = sweep(scene, folder + "/now", words);
    CHECK(gone.exit == 1);
    std::size_t left_out = 0;
    const Json worse = sweep_json(folder + "/now")["comparison"]["worse"];
    for (const Json& what : worse)
        left_out += what.get<std::string>().find(": left out, was ") != std::string::npos;
    CHECK(left_out == 2);
}

TEST_CASE("sweep: a preset is later than the scene file, --set later than it, and the page says so", "[program][preset]") {
    const std::string folder = fresh_folder("sweep_preset"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    const auto picture = [&](const std::string& name, Words more) {
        more.insert(more.begin(), {"--method", "direct", "--spp", "16"});
        const Result r = sweep(scene, folder + "/" + name, more);
        INFO(r.err);
        REQUIRE(r.exit == 0);
        const Json json = sweep_json(folder + "/" + name);
        REQUIRE(json["points"].size() == 1);
        return json["points"][0]["picture"].dump();
    };
    const std::string plain = picture("plain", {"--set", "direct.variant=corrected"});
    const std::string printed = picture("printed", {"--preset", "vrsm_printed"});
    CHECK(printed != plain);
    CHECK(picture("again", {"--preset", "vrsm_printed"}) == printed);
    CHECK(picture("set", {"--preset", "vrsm_printed", "--set", "direct.variant=corrected"}) != printed);
    CHECK_THAT(read(folder + "/printed/sweep.html"), Contains("--preset vrsm_printed"));
}

TEST_CASE("sweep: bad words are one line, exit code 2, and nothing is written", "[program][contract]") {
    const std::string folder = fresh_folder("sweep_bad"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    write(folder + "/broken.json", "{\"isa\": 3}");
    write(folder + "/huge.json", "{\"isa\": 1e999}");
    const struct {
        Words words;
        const char* cause;
    } cases[] = {{{"--method", "rsm.dics"}, "'rsm.disc'"},
                 {{"--vary", "rsm.sampels=1,2"}, "'samples'"},
                 {{"--vary", "rsm.samples"}, "expected table.key=a,b,c"},
                 {{"--runs", "4"}, "--runs"},
                 {{"--size", "24"}, "--size 24: expected WxH"},
                 {{"--size", "24x0"}, "--size 24x0: expected WxH"},
                 {{"--budget", "-1"}, "--budget -1: expected a time"},
                 {{"--budget", "nan"}, "--budget nan: expected a time"},
                 {{"--budget", "1ms", "--error", "1"}, "expected one of them"},
                 {{"--error", "nan"}, "--error nan: expected a number"},
                 {{"--compare-to", folder + "/broken.json"}, "broken.json: isa: expected a string"},
                 {{"--compare-to", folder + "/huge.json"}, "huge.json: a number that is not finite"},
                 {{"--compare-to", folder + "/missing.json"}, "missing.json"},
                 {{"--spp", "0"}, "--spp"},
                 {{"--preset", "isr_prnted"}, "--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'"},
                 {{"--preset", ""}, "--preset"},
                 {{"--rnus", "5"}, "'--runs'"}};
    for (const auto& c : cases) {
        const Result r = sweep(scene, folder + "/out", c.words);
        INFO(c.cause << ": " << r.err);
        CHECK(r.exit == 2);
        CHECK_THAT(one_line(r), Contains(c.cause));
        CHECK(!std::filesystem::exists(folder + "/out"));
    }
    CHECK(run({"sweep", scene, scene, "-o", folder + "/out"}).exit == 2);
}

TEST_CASE("render: a budget picks the setting, says so, and finds it again at once", "[program]") {
    const std::string folder = fresh_folder("budget"), scene = small_scene(folder, "[24, 24]");
    set_cache(folder + "/cache");
    auto render = [&](const std::string& out, const std::string& budget) {
        const Result r = run({"render", scene, "-o", out, "--budget", budget});
        INFO(r.err);
        REQUIRE(r.exit == 0);
        CHECK_THAT(r.out, Contains("budget: "));
        const Json run_json = Json::parse(read(out + "/run.json"));
        CHECK(keys(run_json["chosen"]) == Words{"budget_ms", "fits", "curve", "settings", "median_ms", "rmse", "points",
                                                "cached"});
        return run_json;
    };
    const Json first = render(folder + "/first", "1000s");
    CHECK(first["chosen"]["fits"] == true);
    CHECK(first["chosen"]["cached"] == false);
    const Json second = render(folder + "/second", "999s");
    CHECK(second["chosen"]["cached"] == true);
    CHECK(second["chosen"]["settings"] == first["chosen"]["settings"]);
    CHECK(read(folder + "/first/small.exr") == read(folder + "/second/small.exr"));
    CHECK(second["settings"] == first["settings"]);

    // The settings that run.json names give the same picture without a budget.
    Words by_hand = {"render", scene, "-o", folder + "/hand"};
    for (const auto& [key, value] : first["settings"]["rsm"].items()) {
        const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
        by_hand.insert(by_hand.end(), {"--set", "rsm." + key + "=" + text});
    }
    REQUIRE(run(by_hand).exit == 0);
    CHECK(read(folder + "/hand/small.exr") == read(folder + "/first/small.exr"));

    // A file that was changed is not believed.
    std::string kept;
    for (const std::string& file : files_in(folder + "/cache"))
        if (file.ends_with(".sweep")) kept = folder + "/cache/" + file;
    REQUIRE(!kept.empty());
    std::string text = read(kept);
    text[text.find("median_ms") + 12] ^= 1;
    write(kept, text);
    CHECK(render(folder + "/third", "1000s")["chosen"]["cached"] == false);

    // What nothing fits is rendered by the fastest, and said.
    const Json none = render(folder + "/none", "1e-6ms");
    CHECK(none["chosen"]["fits"] == false);
    CHECK(one_line(run({"render", scene, "-o", folder + "/none", "--budget", "0"})).find("--budget 0") !=
          std::string::npos);
}
