// plumb experiment shadows, small: what it counts of a test that is known to fail, bits, files, and what is refused.
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
Json rows_of(const Words& words) {
    const Result r = run(words);
    INFO(r.err);
    REQUIRE(r.exit == 0);
    return Json::parse(r.out)["rows"];
}

}  // namespace

TEST_CASE("experiment shadows: acne, leaks and edges of the Cornell box", "[program][shadow]") {
    const std::string folder = fresh_folder("experiment_shadows"), scene = box(folder), out = folder + "/out";
    const Json rows = rows_of({"experiment", "shadows", scene, "--sizes", "96", "--maps", "64", "--json", "-o", out});
    REQUIRE(rows.size() == 11);
    auto row = [&](const std::string& way) {
        for (const Json& r : rows)
            if (r["shadow"] == way) return r;
        FAIL(way);
        return Json();
    };
    for (const Json& r : rows) {
        CAPTURE(r.dump());
        CHECK(r["lit"] == rows[0]["lit"]);    // rays know no filter
        CHECK(r["dark"] == rows[0]["dark"]);
        CHECK(r["lit"].get<int>() > 3000);
        CHECK(r["dark"].get<int>() > 200);
        CHECK((r["beside"] >= 0 && r["beside"] <= r["light"]));
        CHECK(r["edge"].get<int>() > 0);
        CHECK(std::filesystem::exists(out + "/" + "shadows.csv"));
    }
    // By planes nothing is in its own shadow, but a few pixels of wide filters whose texels of 130 mm see an edge that the eight points
    // around do not; with the plane of the point alone corners have seams.
    for (const char* way : {"hard", "pcf 1", "pcf 2"}) {
        CAPTURE(way);
        CHECK(row(way)["acne"] == 0);
    }
    for (const char* way : {"density 4", "pcf 3", "pcf 4"}) {
        CAPTURE(way);
        CHECK(row(way)["beside"].get<double>() < 2e-4);
    }
    CHECK(row("density 4, depth")["beside"].get<double>() > 2e-3);
    CHECK(row("hard, plane")["acne"].get<int>() > 100);
    CHECK(row("hard")["leak"].get<int>() <= row("hard, depth")["leak"].get<int>());
    CHECK(row("density 4")["leak"].get<int>() < row("density 4, depth")["leak"].get<int>());
    // Without any bias every surface shadows itself.
    const Json without = rows_of({"experiment", "shadows", scene, "--sizes", "96", "--maps", "64", "--json", "--way", "hard, depth", "--set",
                                  "shadow.bias=0", "--set", "shadow.slope_bias=0"});
    CHECK(without[0]["acne"].get<int>() > 1000);
    CHECK(without[0]["beside"].get<double>() > 0.2);
}

TEST_CASE("experiment shadows: a preset lies under what a way sets", "[program][preset]") {
    const std::string folder = fresh_folder("experiment_shadows_preset"), scene = box(folder);
    const auto rows = [&](Words more) {
        Words words = {"experiment", "shadows", scene, "--sizes", "48", "--maps", "64", "--json", "--way", "density 4, depth"};
        words.insert(words.end(), more.begin(), more.end());
        return rows_of(words)[0];
    };
    // Algorithm 4 as printed: light and shadow change places.
    const Json plain = rows({}), printed = rows({"--preset", "vrsm_printed"});
    CHECK(printed["acne"].get<int>() > 9 * plain["acne"].get<int>() + 400);
    CHECK(rows({"--preset", "vrsm_printed", "--set", "shadow.variant=corrected"})["acne"].get<int>() < 500);
}

TEST_CASE("experiment shadows: the same numbers for any number of threads and instruction set", "[program][bits]") {
    const std::string folder = fresh_folder("experiment_shadows_bits"), scene = box(folder);
    std::string first;
    for (const Words& more : {Words{"--threads", "1"}, Words{"--threads", "3", "--isa", "scalar"}}) {
        Words words = {"experiment", "shadows", scene, "--sizes", "48", "--maps", "32", "--json", "--way", "pcf 3", "--way", "hard, depth"};
        words.insert(words.end(), more.begin(), more.end());
        Json rows = rows_of(words);
        REQUIRE(rows.size() == 2);
        for (Json& row : rows) row.erase("ms");
        if (first.empty()) first = rows.dump();
        CHECK(rows.dump() == first);
    }
}

TEST_CASE("experiment shadows: what is refused", "[program]") {
    const std::string folder = fresh_folder("experiment_shadows_refused"), scene = box(folder), out = folder + "/out";
    const auto refused = [&](Words more) {
        Words words = {"experiment", "shadows", scene, "-o", out};
        words.insert(words.end(), more.begin(), more.end());
        const Result r = run(words);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        return r.err;
    };
    CHECK_THAT(refused({"--way", "soft"}), Contains("--way \"soft\"") && Contains("density 4, depth"));
    CHECK_THAT(refused({"--sizes", "0"}), Contains("--sizes"));
    CHECK_THAT(refused({"--maps", "20000"}), Contains("--maps"));
    CHECK_THAT(refused({"--set", "shadow.pcf_kernel=0"}), Contains("pcf_kernel"));
    CHECK_THAT(refused({"--set", "shadow.tests=plane"}), Contains("tests"));
    CHECK_THAT(refused({"--preset", "isr_prnted"}),
               Contains("--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'"));
    CHECK(!std::filesystem::exists(out));
    CHECK(run({"experiment", "shadows", folder + "/none.toml"}).exit == 2);
}
