// plumb experiment ddgi, small: files, that text, JSON and page hold the same numbers, bits, and what is refused.
#include <catch2/catch.hpp>
#include <filesystem>

#include "program.h"

namespace {

using namespace plumb::program;
using Catch::Matchers::Contains;

std::string box(const std::string& folder) {
    REQUIRE(run({"make-scene", "cornell", "-o", folder}).exit == 0);
    return folder + "/cornell.toml";
}
Words small(const std::string& scene, Words more = {}) {
    Words words = {"experiment", "ddgi", scene, "--lightmap", "40", "--samples", "64", "--grids", "3", "--sides", "6", "--rays", "64", "--probes", "6"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

}  // namespace

TEST_CASE("experiment ddgi: the same numbers in text, JSON and page", "[program][contract]") {
    const std::string folder = fresh_folder("experiment_ddgi"), scene = box(folder), out = folder + "/out";
    const Result r = run(small(scene, {"-o", out}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    for (const char* file : {"ddgi.json", "ddgi.txt", "ddgi.html"}) CHECK(std::filesystem::exists(out + "/" + file));
    const Json j = Json::parse(read(out + "/ddgi.json"));
    CHECK(j["version"] == 1);
    CHECK(j["receivers"] > 200);
    CHECK(j["truth"]["noise"] > 0);
    // One volume, a bake in two forms, and all that a part of DDGI is worth.
    REQUIRE(j["rows"].size() > 10);
    int variants = 0;
    for (const Json& row : j["rows"]) {
        CHECK((row["rms"] >= 0 && row["rms"] < 2));
        CHECK(row["bytes"] > 0);
        CHECK((row["leaking"] >= 0 && row["leaking"] <= 1));
        CHECK_THAT(r.out, Contains(row["setting"].get<std::string>()));
        variants += row["variant"] == true ? 1 : 0;
    }
    CHECK(variants == int(j["rows"].size()) - 3);
    CHECK(j["rows"][0]["probes"] == 27);
    CHECK(j["rows"][0]["method"] == "DDGI");
    CHECK(j["rows"][1]["method"] == "clusters");
    CHECK(j["left_out"] == 0);
    // What the published energy takes away is light.
    const auto bias = [&](const std::string& setting) {
        for (const Json& row : j["rows"])
            if (row["setting"] == setting) return row["bias"].get<double>();
        FAIL(setting);
        return 0.0;
    };
    CHECK(bias("95 % of the energy, as published") < j["rows"][0]["bias"].get<double>() - 0.02);
    CHECK(bias("means of square roots, as published") < j["rows"][0]["bias"].get<double>());
    const std::string page = read(out + "/ddgi.html");
    CHECK_THAT(page, Contains("DDGI and clustered transport") && Contains("plumb experiment ddgi"));
}

TEST_CASE("experiment ddgi: the same numbers for any number of threads and instruction set", "[program][bits]") {
    const std::string folder = fresh_folder("experiment_ddgi_bits"), scene = box(folder);
    std::string first;
    for (const Words& more : {Words{"--threads", "1"}, Words{"--threads", "3", "--isa", "scalar"}}) {
        Words words = small(scene, {"--no-variants", "--json"});
        words.insert(words.end(), more.begin(), more.end());
        const Result r = run(words);
        REQUIRE(r.exit == 0);
        Json j = Json::parse(r.out);
        REQUIRE(j["rows"].size() == 3);
        for (Json& row : j["rows"]) row.erase("seconds"), row.erase("seconds_of_bake");
        if (first.empty()) first = j.dump();
        CHECK(j.dump() == first);
    }
}

TEST_CASE("experiment ddgi: what is refused", "[program]") {
    const std::string folder = fresh_folder("experiment_ddgi_refused"), scene = box(folder), out = folder + "/out";
    const auto refused = [&](Words more) {
        const Result r = run(small(scene, std::move(more)));
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        return r.err;
    };
    CHECK_THAT(refused({"--volume", "bias"}), Contains("KEY=VALUE"));
    CHECK_THAT(refused({"--volume", "biass=1"}), Contains("bias"));
    CHECK_THAT(refused({"--volume", "bias=nan"}), Contains("bias"));
    CHECK_THAT(refused({"--volume", "bias=1x"}), Contains("number"));
    CHECK_THAT(refused({"--volume", "rays=8"}), Contains("--rays"));
    CHECK_THAT(refused({"--grids", "0"}), Contains("--grids"));
    CHECK_THAT(refused({"--samples", "0"}), Contains("--samples"));
    CHECK_THAT(refused({"--open", "2"}), Contains("--open"));
    CHECK_THAT(refused({"--open", "nan"}), Contains("--open"));
    CHECK_THAT(refused({"-o", out, "--set", "probes.degree=9"}), Contains("degree"));
    CHECK(!std::filesystem::exists(out));
    CHECK(run({"experiment", "ddgi", folder + "/none.toml"}).exit == 2);
}
