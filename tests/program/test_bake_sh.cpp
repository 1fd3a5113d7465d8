// plumb bake --export-sh: what probes see, for engines.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/program/bake_runs.h"

namespace plumb::program {

using nlohmann::json;
namespace fs = std::filesystem;

TEST_CASE("bake --export-sh: every form of the same light", "[program][export]") {
    const std::string folder = fresh_folder("bake_sh"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    std::vector<json> files;
    const std::vector<std::string> names = {"threejs", "l1", "geomerics", "unity", "unreal"};
    for (const std::string& name : names) {
        succeed(baked(scene, folder + "/a.bake", {"--export-sh", folder + "/" + name + ".json", "--sh-order", name}));
        files.push_back(json::parse(read(folder + "/" + name + ".json")));
        CHECK(files.back().at("order") == name);
        CHECK(files.back().at("probes").size() == files[0].at("probes").size());
        CHECK(files.back().at("rounds").get<int>() > 1);
    }
    REQUIRE(files[0].at("probes").size() > 0);
    for (std::size_t p = 0; p < files[0].at("probes").size(); ++p) {
        const auto sh = [&](int file) { return files[std::size_t(file)].at("probes").at(p).at("sh"); };
        const auto at = [&](int file, int c) { return files[std::size_t(file)].at("probes").at(p).at("position").at(std::size_t(c)).get<double>(); };
        REQUIRE(sh(0).size() == 9);
        REQUIRE(sh(1).size() == 4);
        REQUIRE(sh(3).size() == 3);
        REQUIRE(sh(3).at(0).size() == 9);
        const double l00 = sh(0).at(0).at(0).get<double>();
        CHECK(l00 > 0);
        for (std::size_t i = 0; i < 4; ++i) CHECK(sh(1).at(i) == sh(0).at(i));
        // R0 = L00 Y00; Unity's first is pi / pi of the same; Unreal's is L00 itself, Y10 along its z is Y1-1 along our y.
        CHECK(sh(2).at(0).at(0).get<double>() == Approx(0.28209479 * l00).epsilon(1e-6));
        CHECK(sh(3).at(0).at(0).get<double>() == Approx(0.28209479 * l00).epsilon(1e-6));
        CHECK(sh(4).at(0).at(0).get<double>() == Approx(l00).epsilon(1e-6));
        CHECK(sh(4).at(0).at(2).get<double>() == Approx(sh(0).at(1).at(0).get<double>()).epsilon(1e-5).margin(1e-6 * l00));
        CHECK(at(3, 2) == -at(0, 2));
        CHECK(at(4, 2) == Approx(100 * at(0, 1)).epsilon(1e-6));
    }
    // The same bytes for every instruction set and number of threads.
    const std::string first = read(folder + "/unity.json");
    succeed(baked(scene, folder + "/a.bake", {"--no-cache", "--threads", "1", "--isa", "scalar", "--export-sh", folder + "/again.json", "--sh-order", "unity"}));
    CHECK(read(folder + "/again.json") == first);
}

TEST_CASE("bake --export-sh: wrong usage is one line", "[program][export]") {
    const std::string folder = fresh_folder("bake_sh_usage"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    const std::string out = folder + "/x.json";
    const auto complains = [&](const Words& more) {
        const Result r = run(baked(scene, folder + "/x.bake", more));
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK_FALSE(fs::exists(out));
        CHECK_FALSE(fs::exists(folder + "/x.bake"));
        return r.err;
    };
    using Catch::Contains;
    CHECK_THAT(complains({"--export-sh", out}), Contains("expected --sh-order as well"));
    CHECK_THAT(complains({"--sh-order", "unity"}), Contains("--sh-order is of --export-sh"));
    CHECK_THAT(complains({"--export-sh", out, "--sh-order", "unty"}), Contains("the nearest known one is 'unity'"));
    CHECK_THAT(complains({"--export-sh", out, "--sh-order", "unity", "--set", "probes.degree=1"}), Contains("probes.degree = 1"));
    CHECK_THAT(complains({"--export-sh", folder + "/x.bake", "--sh-order", "unity"}), Contains("twice"));
    const Result part = run({"bake", scene, "--part", "1/2", "--export-sh", out, "--sh-order", "unity"});
    CHECK(part.exit == 2);
    CHECK_THAT(part.err, Contains("not for a part"));
}

}  // namespace plumb::program
