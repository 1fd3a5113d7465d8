// plumb experiment screen, small: files, rows, that each curve gains by what it pays for, and what is refused.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

const std::string scenes = std::string(PLUMB_SOURCE_DIR) + "/data/scenes/";

// The rows of a curve, in its order.
std::vector<Json> curve_of(const Json& sheet, const std::string& name) {
    std::vector<Json> rows;
    for (const Json& row : sheet["rows"])
        if (row["name"] == name) rows.push_back(row);
    INFO(name);
    REQUIRE(!rows.empty());
    return rows;
}
Json sheet_of(const Json& json, const std::string& scene, const std::string& id) {
    for (const Json& s : json["scenes"])
        if (s["name"] == scene)
            for (const Json& sheet : s["sheets"])
                if (sheet["id"] == id) return sheet;
    FAIL("no " + id + " of " + scene);
    return {};
}

}  // namespace

TEST_CASE("experiment screen: what is paid for is gained, on a scene with mirrors and on one without", "[program][contract]") {
    const std::string out = fresh_folder("experiment_screen") + "/out";
    const Result r = run({"experiment", "screen", scenes + "cornell/cornell_mirror.toml", scenes + "cornell/cornell.toml", "--size", "48x48", "--spp", "16", "--repeats", "1",
                          "--frames", "17", "-o", out});
    INFO(r.err);
    REQUIRE(r.exit == 0);
    CHECK(files_in(out) == Words{"screen.csv", "screen.html", "screen.json", "screen.txt"});
    const Json j = Json::parse(read(out + "/screen.json"));
    REQUIRE(j["scenes"].size() == 2);
    CHECK(j["scenes"][0]["sheets"].size() == 4);
    CHECK(j["scenes"][1]["sheets"].size() == 2);  // nothing mirrors

    const Json ao = sheet_of(j, "cornell", "ambient occlusion");
    CHECK(ao["rows"].size() == 6 + 6 + 4 + 2 + 2 + 2 + 5 + 4 + 4 + 4 + 4 + 4 + 5 + 4);
    const std::vector<Json> horizons = curve_of(ao, "horizons, 4 slices"), ssao = curve_of(ao, "ssao, camera");
    CHECK(horizons.front()["mean error"] > horizons.back()["mean error"]);
    CHECK(ssao.back()["mean error"] > horizons.back()["mean error"]);  // its bias stays
    for (const Json& row : ao["rows"]) {
        CHECK(row["mean error"] > 0);
        CHECK(row["mean error"] <= row["rms"]);
        CHECK(row["rms"] < 0.5);
        CHECK(row["ms, first quartile"] <= row["ms"]);
        CHECK(row["ms"] <= row["ms, third quartile"]);
    }
    // Each radius has its own truth: of a smaller ball more is open, and both err less.
    const std::vector<Json> radius = curve_of(ao, "ssao, camera: radius");
    CHECK(radius[0]["mean error"] < 0.5 * double(radius[3]["mean error"]));

    const Json mirrors = sheet_of(j, "cornell_mirror", "reflections");
    for (const Json& row : mirrors["rows"]) {
        double sum = 0;
        for (const char* of : {"right", "wrong", "missed", "right in map", "wrong in map", "missed in map", "right in layer", "wrong in layer", "missed in layer", "unseen", "open"}) sum += double(row[of]);
        CHECK(sum == Approx(100).margin(1e-6));
    }
    const std::vector<Json> steps = curve_of(mirrors, "steps, camera"), lights = curve_of(mirrors, "steps, camera and lights"), halvings = curve_of(mirrors, "64 steps, halvings");
    CHECK(steps[0]["missed"] > steps[2]["missed"]);
    CHECK(steps[2]["right in map"] == 0);
    CHECK(lights[2]["right in map"] > 0);
    CHECK(lights[2]["unseen"] < steps[2]["unseen"]);
    CHECK(halvings[0]["right"] < halvings[3]["right"]);
    const std::vector<Json> layers = curve_of(mirrors, "texel to texel, camera, thin, layers"), eye = curve_of(mirrors, "64 steps, attenuation, for the eye");
    CHECK(double(layers[0]["right in layer"]) + double(layers[0]["wrong in layer"]) > 0);
    CHECK(eye[0]["bias"] < eye[2]["bias"]);  // half is left at 1 m, at 16 m
    const Json rough = sheet_of(j, "cornell_mirror", "rough reflections");
    const std::vector<Json> rays = curve_of(rough, "steps, camera and lights");
    CHECK(rays[0]["rms"] > rays[2]["rms"]);
    CHECK(rays[2]["rms"] > rays[2]["mean error"]);

    const Json reuse = sheet_of(j, "cornell", "gathered light of frames before");
    const std::vector<Json> one = curve_of(reuse, "one frame"), shared = curve_of(reuse, "25 samples a frame");
    CHECK(one.front()["rms"] > one.back()["rms"]);
    CHECK(shared.front()["at"] == 1);
    CHECK(shared[0]["rms"] == Approx(double(one[0]["rms"])).epsilon(0.3));  // a mean of one, turned otherwise
    CHECK(shared[2]["rms"] < 0.7 * double(shared[0]["rms"]));
    // A camera that moves, up to the same picture: most of what was seen before is found again, and nothing where no plane is near.
    const std::vector<Json> moving = curve_of(reuse, "25 samples a frame, moving"), planes = curve_of(reuse, "25 samples of 16 frames, moving: sigma of depths");
    CHECK(moving[1]["rms"] < 0.8 * double(shared[0]["rms"]));
    CHECK(planes[2]["rms"] == moving[1]["rms"]);  // of the default, 0.02
}

TEST_CASE("experiment screen: what is refused, and nothing written", "[program]") {
    const std::string out = fresh_folder("experiment_screen_refused") + "/out", scene = scenes + "cornell/cornell.toml";
    const auto refused = [&](Words words) {
        words.insert(words.begin(), {"experiment", "screen"}), words.insert(words.end(), {"-o", out});
        const Result r = run(words);
        CHECK(r.exit == 2);
        CHECK(!std::filesystem::exists(out + "/screen.json"));
        return r.err;
    };
    CHECK_THAT(refused({"nosuch.toml"}), Contains("nosuch.toml"));
    CHECK_THAT(refused({scene, "--size", "0x4"}), Contains("--size"));
    CHECK_THAT(refused({scene, "--set", "ao.smaples=3"}), Contains("samples"));
    CHECK_THAT(refused({scene, "--frames", "1"}), Contains("--frames"));
    CHECK_THAT(refused({scene, "--preset", "isr_prnted"}),
               Contains("--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'"));
}
