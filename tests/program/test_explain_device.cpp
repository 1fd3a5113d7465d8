// plumb explain --device: our values and those of lavapipe side by side. Its profile draws and rounds as lavapipe does,
// so that all values are the same bits, until the twin is broken.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <iostream>

#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

bool has_lavapipe() {
    const Result r = run({"devices", "--json"});
    if (r.exit == 0)
        for (const Json& device : Json::parse(r.out))
            if (device["name"].get<std::string>().find("llvmpipe") != std::string::npos) return true;
    std::cout << "SKIPPED: no lavapipe here (mesa-vulkan-drivers), or built without Vulkan\n";
    return false;
}

Words explain(const std::string& scene, const std::string& pixel, const Words& more = {}) {
    Words words = {"explain", scene, "--pixel", pixel, "--device", "llvmpipe"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

// Values that the twin names too.
int compared(const Json& explanation) {
    int n = 0;
    for (const Json& v : explanation["values"]) n += v.contains("gpu");
    return n;
}

void check_same(const Json& explanation) {
    INFO(explanation["stage"]);
    CHECK(explanation["parts_at"].is_null());
    for (const Json& v : explanation["values"])
        if (v.contains("gpu")) CHECK(v["gpu"] == v["value"]);
}

// A bulb in the box's middle: six maps.
std::string bulb_scene(const std::string& folder) {
    const std::string scene = small_scene(folder);
    std::string text = read(scene);
    const std::size_t key = text.find("[[light]]"), rsm = text.find("[rsm]");
    text = text.substr(0, key) +
           "[[light]]\nname = \"bulb\"\ntype = \"point\"\nposition = [0.2, 1.2, 0.1]\nintensity = [3, 3, 3]\n"
           "rsm_size = 24\n" +
           text.substr(rsm);
    write(scene, text);
    return scene;
}

}  // namespace

TEST_CASE("explain --device: every stage's values are the same bits", "[program][vulkan]") {
    if (!has_lavapipe()) return;
    const std::string folder = fresh_folder("explain_device"), scene = small_scene(folder);
    for (const char* pixel : {"30,21", "12,30", "45,35"}) {
        const Result r = run(explain(scene, pixel, {"--json"}));
        INFO(pixel << "\n" << r.err);
        REQUIRE(r.exit == 0);
        const Json all = Json::parse(r.out);
        Words stages;
        for (const Json& e : all["stages"]) {
            CHECK(keys(e) == Words{"stage", "pixel", "values", "device", "profile", "parts_at"});
            CHECK(e["pixel"] == all["pixel"]);
            CHECK(compared(e) >= 3);
            check_same(e);
            stages.push_back(e["stage"]);
        }
        CHECK(stages == Words{"gbuffer", "shadow (key)", "rsm.disc (key)", "shadow (sun)", "rsm.disc (sun)", "direct",
                              "compose", "tonemap"});
    }
    const Json texel = Json::parse(run(explain(scene, "20,31", {"--stage", "rsm", "--json"})).out);
    check_same(texel);
    CHECK(compared(texel) >= 8);
    const Json whole = Json::parse(run(explain(scene, "30,21", {"--stage", "rsm.all", "--set", "rsm.gather=all",
                                                                "--json"})).out);
    check_same(whole);
    CHECK(compared(whole) > 48 * 48);
}

TEST_CASE("explain --device: text says so in its last line", "[program][vulkan]") {
    if (!has_lavapipe()) return;
    const std::string folder = fresh_folder("explain_device_text"), scene = small_scene(folder);
    const Result r = run(explain(scene, "30,21", {"--stage", "compose"}));
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Contains("compose at 30,21, on llvmpipe") && Contains("profile lavapipe-22.3"));
    CHECK_THAT(r.out, Contains("values are the same bits\n"));
    CHECK_THAT(r.out, !Contains("part") && !Contains("check:"));

    // Outside of the box there is nothing to see.
    write(scene, read(scene) + "[environment]\nradiance = [0.5, 0.5, 0.5]\n");
    const Result sky = run(explain(scene, "0,0", {"--set", "render.method=direct"}));
    INFO(sky.out << sky.err);
    CHECK(sky.exit == 0);
}

TEST_CASE("explain --device: of a point light the map that serves the pixel", "[program][vulkan]") {
    if (!has_lavapipe()) return;
    const std::string folder = fresh_folder("explain_device_bulb"), scene = bulb_scene(folder);
    // Each pixel is served by one of the six maps; which one, the wall that it sees says: the floor lies below (-y).
    const Json floor = Json::parse(run(explain(scene, "30,40", {"--stage", "shadow", "--json"})).out);
    CHECK(floor["stage"] == "shadow (bulb) ny");
    check_same(floor);
    const Json wall = Json::parse(run(explain(scene, "17,20", {"--stage", "shadow", "--json"})).out);
    CHECK(wall["stage"] == "shadow (bulb) nx");
    check_same(wall);
    // All of them gather.
    const Json gathers = Json::parse(run(explain(scene, "30,40", {"--stage", "rsm.disc", "--json"})).out);
    REQUIRE(keys(gathers) == Words{"pixel", "stages"});
    CHECK(gathers["stages"].size() >= 5);
    for (const Json& e : gathers["stages"]) check_same(e);
    // The maps lie side by side: this is -y, the fourth.
    const Json texel = Json::parse(run(explain(scene, "82,7", {"--stage", "rsm", "--json"})).out);
    CHECK(texel["stage"] == "rsm (bulb) ny");
    CHECK(texel["pixel"] == Json{82, 7});
    CHECK(compared(texel) >= 8);
    check_same(texel);
}

TEST_CASE("explain --device: a broken shader is marked where it first parts", "[program][vulkan]") {
    if (!has_lavapipe()) return;
    const std::string folder = fresh_folder("explain_device_broken"), scene = small_scene(folder);
    // The build's tapped text of the gather, with the sample's normal negated from where it is read.
    std::string twin = read(PLUMB_BINARY_DIR "/twins/tapped/gi.rsm.gather.comp");
    const std::string fetch = "vec3 n_p = texelFetch(";
    REQUIRE(twin.find(fetch) != std::string::npos);
    twin.replace(twin.find(fetch), fetch.size(), "vec3 n_p = -texelFetch(");
    write(folder + "/broken.comp", twin);
    const std::string spirv = folder + "/broken.spv";
    const std::string compile = "glslangValidator -V --quiet --target-env vulkan1.1 -o " + spirv + " " + folder +
                                "/broken.comp > /dev/null 2>&1";
    if (std::system(compile.c_str()) != 0) {
        std::cout << "SKIPPED: no glslangValidator here (glslang-tools)\n";
        return;
    }
    const Words arguments = {"--stage", "rsm.disc", "--light", "key", "--spirv", spirv};
    const Result text = run(explain(scene, "40,33", arguments));
    CHECK(text.exit == 1);
    CHECK(text.err.empty());
    const std::size_t mark = text.out.find("<-- here they part");
    REQUIRE(mark != std::string::npos);
    CHECK(text.out.find("<-- here they part", mark + 1) == std::string::npos);
    const std::string line = text.out.substr(text.out.rfind('\n', mark) + 1, mark);
    CHECK_THAT(line.substr(0, line.find('\n')), Contains(" 0  n_p "));
    CHECK_THAT(text.out, Contains("they part at n_p, sample 0: "));

    Words with_json = arguments;
    with_json.push_back("--json");
    const Json json = Json::parse(run(explain(scene, "40,33", with_json)).out);
    const Json& first = json["values"].at(json["parts_at"].get<std::size_t>());
    CHECK(first["name"] == "n_p");
    CHECK(first["sample"] == 0);
    for (std::size_t i = 0; i < json["parts_at"]; ++i) CHECK(json["values"][i]["gpu"] == json["values"][i]["value"]);
    CHECK(json["values"].back()["gpu"] != json["values"].back()["value"]);
}

TEST_CASE("explain --device: what cannot run is refused in one line", "[program][vulkan]") {
    const std::string folder = fresh_folder("explain_device_refused"), scene = small_scene(folder);
    const Result none = run({"explain", scene, "--pixel", "1,1", "--device", "no such device"});
    CHECK(none.exit == 2);
    CHECK(std::count(none.err.begin(), none.err.end(), '\n') == 1);
    CHECK_THAT(none.err, Contains("--device"));
    CHECK(run({"explain", scene, "--pixel", "1,1", "--spirv", "x.spv"}).err ==
          "plumb: --spirv: expected --device and --stage: where it runs, and in place of what\n");
    if (!has_lavapipe()) return;
    const Result rays = run(explain(scene, "1,1", {"--stage", "rsm.all_rays", "--set", "rsm.gather=all_rays"}));
    CHECK(rays.exit == 2);
    CHECK(rays.err == "plumb: --device: rsm.all_rays runs on the processor alone: it has no twin\n");
    const Result missing = run(explain(scene, "1,1", {"--stage", "compose", "--spirv", folder + "/missing.spv"}));
    CHECK(missing.exit == 2);
    CHECK_THAT(missing.err, Contains("missing.spv"));
}
