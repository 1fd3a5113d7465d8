// plumb experiment probe-ladder, small: JSON, tables and page hold the same rungs, bits, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

Result ladder(const std::string& scene, Words more) {
    Words words = {"experiment", "probe-ladder", scene, "--receivers", "32", "--truth-rays", "256", "--most-probes", "4"};
    for (const char* set : {"probes.lightmap_size=24", "probes.count=2", "probes.receiver_rays=64"})
        words.insert(words.end(), {"--set", set});
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}

Json without_seconds(Json json) {
    for (Json& rung : json["rungs"]) rung.erase("seconds");
    return json;
}

}  // namespace

TEST_CASE("experiment probe-ladder: the same rungs in JSON, tables and page, the same bits every time", "[program]") {
    const std::string folder = fresh_folder("probe_ladder"), scene = small_scene(folder);
    const Words axes = {"--axes", "probes,degree,relight,clusters,receivers"};
    Words first = axes, second = axes;
    first.insert(first.end(), {"--json", "--threads", "1", "--isa", "scalar", "-o", folder + "/tables.txt", "--html",
                               folder + "/page.html"});
    second.insert(second.end(), {"--json", "--threads", "3"});
    const Result r = ladder(scene, first);
    INFO(r.err);
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    const Json json = Json::parse(r.out);
    CHECK(without_seconds(json) == without_seconds(Json::parse(ladder(scene, second).out)));
    std::map<std::string, int> rungs;
    const std::string tables = read(folder + "/tables.txt"), page = read(folder + "/page.html");
    for (const Json& rung : json["rungs"]) {
        ++rungs[rung["axis"].get<std::string>()];
        CHECK(rung["rms"].get<double>() >= std::abs(rung["bias"].get<double>()));
        CHECK(rung["bytes"].get<double>() > 0);
        CHECK((rung["black"].get<double>() >= 0 && rung["black"].get<double>() <= 1));
        const std::string settings = rung["settings"].get<std::string>();
        if (rung["axis"] != "receivers") CHECK_THAT(page, Contains(settings));
    }
    CHECK(rungs["default"] == 1);
    CHECK(rungs["probes"] == 3);  // 1, 2, 4
    CHECK(rungs["degree"] == 8);
    CHECK(rungs["relight"] == 12);   // 64 to 2048, two kinds of weights
    CHECK(rungs["clusters"] == 21);  // seven numbers of singular values, three ways to split
    // Five sizes of the lightmap, 48 to 3; the least have no room for all charts.
    CHECK(rungs["receivers"] >= 2);
    CHECK(rungs["receivers"] + int(json["left_out"].size()) == 5);
    CHECK(rungs.count("products") == 0);
    for (const char* head :
         {"probes", "degree", "relight, quadrature weights", "relight, 4 pi / N", "clusters, by size alone", "receivers"})
        CHECK_THAT(tables, Contains(head));
    CHECK_THAT(page, Contains("Is the default on the front?"));
}

TEST_CASE("experiment probe-ladder: what is refused", "[program]") {
    const std::string folder = fresh_folder("probe_ladder_refused"), scene = small_scene(folder);
    const auto refused = [&](Words more) {
        const Result r = ladder(scene, more);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        return r.err;
    };
    CHECK_THAT(refused({"--axes", "probe"}), Contains("--axes probe") && Contains("overlaps"));
    CHECK_THAT(refused({"--truth-rays", "65"}), Contains("--truth-rays"));
    CHECK_THAT(refused({"--receivers", "0"}), Contains("--receivers"));
    CHECK_THAT(refused({"--set", "probes.degree=9"}), Contains("degree"));
    CHECK_THAT(refused({"--axes", "degree", "--html", folder + "/none/page.html"}), Contains("none/page.html"));
    CHECK(run({"experiment", "probe-ladder", folder + "/none.toml"}).exit == 2);
}
