#include <catch2/catch.hpp>

#include "core/error.h"
#include "tools/shared/options.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

std::string message(const std::function<void()>& f) {
    try {
        f();
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST_CASE("options: a value is a number, a truth value, a vector or a word", "[tools]") {
    CHECK(std::get<double>(parse_value("150")) == 150);
    CHECK(std::get<double>(parse_value(" +0.25 ")) == 0.25);
    CHECK(std::get<double>(parse_value("-1e-3")) == -1e-3);
    CHECK(std::get<bool>(parse_value("true")));
    CHECK_FALSE(std::get<bool>(parse_value("false")));
    CHECK(std::get<glm::vec3>(parse_value("[1, 2.5, -3]")) == glm::vec3(1, 2.5f, -3));
    CHECK(std::get<glm::vec3>(parse_value("1,2,3")) == glm::vec3(1, 2, 3));
    CHECK(std::get<std::string>(parse_value("disc")) == "disc");
    CHECK(std::get<std::string>(parse_value("\"150\"")) == "150");
    CHECK(std::get<std::string>(parse_value("1,2")) == "1,2");
    CHECK(std::get<std::string>(parse_value("1,2,3,4")) == "1,2,3,4");
    CHECK(std::get<std::string>(parse_value("150 samples")) == "150 samples");
    CHECK(std::get<std::string>(parse_value("")) == "");
}

TEST_CASE("options: an assignment is split at the first '=' and the first '.'", "[tools]") {
    const Assignment a = parse_assignment("rsm.samples=150");
    CHECK(a.table == "rsm");
    CHECK(a.key == "samples");
    CHECK(std::get<double>(a.value) == 150);
    CHECK(a.place == "--set rsm.samples");
    CHECK(std::get<std::string>(parse_assignment("a.b=c.d=e").value) == "c.d=e");
    for (const char* text : {"", "rsm", "rsm=1", "rsm.samples", ".samples=1", "rsm.=1", "=1", "rsm=a.b"}) {
        INFO(text);
        CHECK(message([&] { parse_assignment(text); }).find("expected table.key=value") != std::string::npos);
    }
}

TEST_CASE("options: a pixel is two whole numbers that are not negative", "[tools]") {
    CHECK(parse_pixel("12,34") == glm::ivec2(12, 34));
    CHECK(parse_pixel("0, 7") == glm::ivec2(0, 7));
    for (const char* text : {"", "1", "1,", ",1", "1,2,3", "-1,2", "1,-2", "1.5,2", "a,b", "1;2", "99999999999,1"}) {
        INFO(text);
        CHECK(message([&] { parse_pixel(text); }).find("expected X,Y") != std::string::npos);
    }
}

TEST_CASE("options: --set is later than the scene file, --method is later than both", "[tools]") {
    Scene scene;
    scene.method = "direct";
    scene.settings.push_back({"rsm", "samples", 25.0, "test.toml: line 1"});
    SceneOptions given;
    CHECK(settings_of(scene, given).rsm.samples == 25);
    CHECK(settings_of(scene, given).method == frame::Method::direct);
    CHECK(settings_of(scene, given).pruning);

    given.sets = {"rsm.samples=150", "rsm.samples=151", "render.layout=rgba16f", "rsm.gather=all"};
    given.method = "rsm";
    given.no_pruning = true;
    const frame::Settings s = settings_of(scene, given);
    CHECK(s.rsm.samples == 151);
    CHECK(s.rsm.gather == rsm::Gather::all);
    CHECK(s.layout == raster::Layout::rgba16f);
    CHECK(s.method == frame::Method::rsm);
    CHECK_FALSE(s.pruning);
}

TEST_CASE("options: what --set cannot set is named, with its place", "[tools]") {
    const Scene scene;
    auto set = [&](const char* text) {
        SceneOptions given;
        given.sets = {text};
        return message([&] { settings_of(scene, given); });
    };
    CHECK(set("rsn.samples=1") == "--set rsn.samples: unknown table [rsn]; the nearest known one is [rsm]");
    CHECK(set("rsm.sample=1") == "--set rsm.sample: unknown key 'sample'; the nearest known one is 'samples'");
    CHECK(set("rsm.samples=0") == "--set rsm.samples: samples = 0: expected 1 to 65536");
    CHECK(set("rsm.samples=1.5") == "--set rsm.samples: samples = 1.5: expected 1 to 65536");
    CHECK(set("rsm.radius=nan").find("--set rsm.radius: radius = nan: expected") == 0);
    CHECK(set("rsm.max_rays=1e40") ==
          "--set rsm.max_rays: max_rays = 1e+40: expected at least 0 rays, and no more than a float holds, 3.4e+38");
    CHECK(set("reference.max_samples=64") == "--set reference.max_samples: max_samples = 64: expected 128 to 16777216");
    CHECK(set("rsm.gather=dics") == "--set rsm.gather: gather = \"dics\": expected one of disc, all, all_rays, paths");
    CHECK(set("render.size=1").find("--set render.size: expected") == 0);
}

TEST_CASE("options: lights are found by name, and name files", "[tools]") {
    Scene scene;
    CHECK(message([&] { find_light(scene, "key"); }).find("no light") != std::string::npos);
    scene.lights.resize(4);
    scene.lights[0].name = "key";
    scene.lights[1].name = "../key";
    scene.lights[2].name = "key";
    scene.lights[3].name = "";
    CHECK(find_light(scene, "../key") == 1);
    CHECK(message([&] { find_light(scene, "kex"); }) == "--light kex: unknown light; the nearest known one is 'key'");
    CHECK(light_file_names(scene) == std::vector<std::string>{"key", "___key", "key-2", "_"});
}

TEST_CASE("options: --preset is later than the scene file, --set and --method are later than it", "[tools][preset]") {
    Scene scene;
    scene.settings = {{"rsm", "slots", 9.0, "a.toml: line 1"}, {"rsm", "radius", 0.5, "a.toml: line 2"}};
    SceneOptions given;
    given.preset = "vrsm";
    const frame::Settings s = settings_of(scene, given);
    CHECK((s.rsm.slots == 5 && s.rsm.steps == 10 && s.layout.name == "vrsm"));
    CHECK(s.rsm.radius == 0.5f);  // of the scene: the document does not say
    given.sets = {"rsm.steps=12", "render.layout=fp32"};
    given.method = "direct";
    CHECK(settings_of(scene, given).rsm.steps == 12);
    CHECK(settings_of(scene, given).layout.name == "fp32");
    CHECK(settings_of(scene, given).method == frame::Method::direct);
    given.preset = "isr_prnted";
    CHECK(message([&] { settings_of(scene, given); }) ==
          "--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'");
}
