// plumb experiment defaults: what it writes, and that a default that is bad makes it red.
#include <catch2/catch.hpp>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Contains;

namespace {

const std::string cornell = std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/cornell.toml";

std::string verdict_on(const Json& json, const std::string& choice) {
    for (const Json& v : json.at("verdicts"))
        if (v.at("choice") == choice) return v.at("default");
    return "not judged";
}

}  // namespace

TEST_CASE("experiment defaults: a kernel of 64 texels is off the front, and the exit code says so", "[program][experiment][defaults]") {
    // It takes a hundred times as long as one texel, and spreads shadows over a room.
    const std::string out = fresh_folder("experiment_defaults") + "/out";
    const Result bad = run({"experiment", "defaults", cornell, "--sizes", "96", "--only", "shadow", "--runs", "2", "--spp", "16", "--json",
                            "--set", "shadow.mode=density", "--set", "shadow.kernel=64", "-o", out});
    INFO(bad.err);
    REQUIRE(bad.exit == 1);
    CHECK(files_in(out) == Words{"defaults.csv", "defaults.json", "defaults.txt"});
    const Json json = Json::parse(bad.out);
    CHECK(json.at("off") > 0);
    CHECK(verdict_on(json, "shadow.mode") == "OFF");
    CHECK(json == Json::parse(read(out + "/defaults.json")));
    for (const Json& r : json.at("rows"))
        if (!r.contains("refused")) CHECK((r.at("error") > 0 && r.at("ms") > 0));
}

TEST_CASE("experiment defaults: wrong input is refused in one line", "[program][experiment][defaults]") {
    const auto refused = [](const std::vector<std::string>& more) {
        std::vector<std::string> command = {"experiment", "defaults", cornell};
        command.insert(command.end(), more.begin(), more.end());
        const Result r = run(command);
        CHECK(r.exit == 2);
        return r.err;
    };
    CHECK_THAT(refused({"--only", "irs"}), Contains("--only irs: unknown group; the nearest known one is 'isr'"));
    CHECK_THAT(refused({"--only", "isr", "--sizes", "16", "--set", "isr.rotations=3"}), Contains("expected a power of two"));
    CHECK_THAT(refused({"--sizes", "4"}), Contains("--sizes"));
    CHECK_THAT(refused({"--only", "isr", "--sizes", "16", "--preset", "isr_prnted"}),
               Contains("--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'"));
}
