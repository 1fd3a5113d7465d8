// What cannot be rendered is said in one line before anything is computed, and nothing is written.
#include <algorithm>
#include <catch2/catch.hpp>

#include "program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

const std::string in_halves = "[render]\nlayout = \"rgba16f\"\n";

// A small scene with its first `from` replaced.
std::string scene_with(const std::string& folder, const std::string& from, const std::string& to) {
    const std::string path = small_scene(folder);
    std::string text = read(path);
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    write(path, text.replace(at, from.size(), to));
    return path;
}

void check_refused(const std::string& folder, const std::vector<Words>& commands, const std::string& message) {
    const Words before = files_in(folder);
    for (const Words& words : commands) {
        const Result r = run(words);
        CAPTURE(words, r.err);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK_THAT(r.err, Contains(message));
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    }
    CHECK(files_in(folder) == before);
}

}  // namespace

TEST_CASE("refusals: a light that a half cannot hold ends every command that renders with one line",
          "[program][refusals]") {
    const std::string folder = fresh_folder("refused_flux"), out = folder + "/out";
    const std::string scene = scene_with(folder, "intensity = ", "intensity = [1e9, 1e9, 1e9] # ");
    set_cache(folder + "/cache");
    CHECK(run({"plan", scene}).exit == 0);  // in fp32
    write(scene, read(scene) + in_halves);
    check_refused(folder,
                  {{"plan", scene},
                   {"render", scene, "-o", out},
                   {"render", scene, "-o", out, "--budget", "1000s"},
                   {"render", scene, "-o", out, "--frames", "2"},
                   {"explain", scene, "--pixel", "3,4"},
                   {"export", scene, "-o", out, "--stage", "compose"},
                   {"sweep", scene, "-o", out, "--method", "rsm"}},
                  "does not fit rgba16f (65504 W), which layout \"rgba16f\"");
}

TEST_CASE("refusals: of many frames the one at fault is found before the first is rendered", "[program][refusals]") {
    const std::string folder = fresh_folder("refused_frame"), scene = small_scene(folder, "[16, 12]");
    write(scene, read(scene) + in_halves + R"(
[[keyframe]]
frame = 0
light.key.intensity = [1, 1, 1]
[[keyframe]]
frame = 4
light.key.intensity = [4e9, 4e9, 4e9]
)");
    auto render = [&](const Words& more) {
        Words words = {"render", scene, "-o", folder + "/out"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    };
    check_refused(folder, {render({"--frames", "3"}), render({"--frames", "3", "--budget", "1000s"})}, "frame 1: ");
    check_refused(folder, {render({"--first", "2"})}, "light \"key\": flux up to");
    CHECK(run(render({"--frames", "1"})).exit == 0);
}

TEST_CASE("refusals: a sweep leaves out the points that are refused, and says why", "[program][refusals]") {
    // Direct light reads the maps' depth alone: a flux that does not fit is no matter to it.
    const std::string folder = fresh_folder("refused_point");
    const std::string scene = scene_with(folder, "intensity = ", "intensity = [1e9, 1e9, 1e9] # ");
    set_cache(folder + "/cache");
    write(scene, read(scene) + in_halves);
    const Result r = run({"sweep", scene, "-o", folder + "/out", "--size", "16x12", "--method", "direct", "--method",
                          "rsm.disc", "--vary", "rsm.samples=4,8", "--spp", "4", "--json"});
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json json = Json::parse(r.out);
    REQUIRE(json["points"].size() == 1);
    CHECK(json["points"][0]["curve"] == "direct");
    REQUIRE(json["left_out"].size() == 2);
    for (const Json& point : json["left_out"]) {
        CHECK(point["curve"] == "rsm.disc");
        CHECK_THAT(point["reason"].get<std::string>(), Contains("does not fit rgba16f"));
    }
}
