// plumb experiment ipr, small: files, that text, JSON, CSV and page hold the same rows, bits, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

std::string box(const std::string& folder) {
    REQUIRE(run({"make-scene", "cornell", "-o", folder}).exit == 0);
    return folder + "/cornell.toml";
}
Words ipr(const std::string& scene, const Words& more) {
    Words words = {"experiment", "ipr", scene, "--quick", "--size", "48x32", "--receivers", "64", "--samples", "32"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

Json without_times(Json json) {
    for (Json& scene : json["scenes"])
        for (Json& table : scene["tables"])
            for (Json& row : table["rows"]) row.erase("ms"), row.erase("spread"), row.erase("seconds_of_bake");
    return json;
}

}  // namespace

TEST_CASE("experiment ipr: the same rows in text, JSON, CSV and page, the same bits every time", "[program][contract]") {
    const std::string folder = fresh_folder("experiment_ipr"), scene = box(folder), out = folder + "/out";
    const Result r = run(ipr(scene, {"-o", out, "--only", "tables,lightmap", "--threads", "1", "--isa", "scalar"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json j = Json::parse(read(out + "/ipr.json"));
    const std::string csv = read(out + "/ipr.csv"), page = read(out + "/ipr.html");
    CHECK(j["version"] == 1);
    REQUIRE(j["scenes"].size() == 1);
    const Json& s = j["scenes"][0];
    REQUIRE(s["tables"].size() == 2);
    CHECK(s["tables"][0]["id"] == "table 5.1");
    CHECK(s["tables"][0]["rows"].size() == 3);
    CHECK(s["tables"][1]["rows"].size() == 2);
    for (const char* head : {"receivers", "probes", "clusters", "MB", "spread %", "SSIM", "mean %", "bias %", "rms %", "truth +- %", "thesis: receivers"}) {
        CHECK_THAT(r.out, Contains(head));
        CHECK_THAT(page, Contains(head));
    }
    for (const Json& t : s["tables"])
        for (const Json& row : t["rows"]) {
            CAPTURE(row["name"]);
            CHECK(row["bytes"] > 0);
            CHECK(row["ms"] > 0);
            CHECK(row["thesis"]["ms"] > 0);
            const Json& e = row["at_receivers"];
            CHECK((e["mean"] > 0 && e["mean"] < 2));
            CHECK(e["mean"].get<double>() >= std::abs(e["bias"].get<double>()));
            CHECK(e["noise"] > 0);
            CHECK((row["ssim"] > 0 && row["ssim"] <= 1.000001));
            CHECK_THAT(r.out, Contains(row["settings"].get<std::string>()));
        }
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 6);
    // The last column is what the others are held against; more probes err less.
    const Json& first = s["tables"][0]["rows"];
    CHECK(first[2]["ssim"].get<double>() == Approx(1));
    CHECK(first[2]["at_receivers"]["mean"] < first[0]["at_receivers"]["mean"]);
    CHECK(s["lightmap"]["receivers"] > 300);
    CHECK_THAT(page, Contains("leaks") && Contains("plumb experiment ipr"));

    const Result again = run(ipr(scene, {"--json", "--only", "tables,lightmap", "--threads", "3"}));
    REQUIRE(again.exit == 0);
    CHECK(without_times(Json::parse(again.out)) == without_times(j));
}

TEST_CASE("experiment ipr: figures, goals, quads and level of detail", "[program]") {
    const std::string folder = fresh_folder("experiment_ipr_parts"), scene = box(folder);
    const Result r = run(ipr(scene, {"--json", "--only", "figures,goals,quads,lod"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json j = Json::parse(r.out);
    const Json& s = j["scenes"][0];
    std::vector<std::string> ids;
    for (const Json& t : s["tables"]) ids.push_back(t["id"].get<std::string>());
    CHECK(ids == std::vector<std::string>{"figure 5.9", "figure 5.11", "figures 5.12, 5.15", "figure 3.32", "goal"});
    // A constant of 0 leaves what lamps light alone; the larger it is the brighter.
    const Json& feedback = s["tables"][3]["rows"];
    REQUIRE(feedback.size() == 7);
    for (std::size_t i = 2; i < 6; ++i)
        if (!feedback[i].contains("refused") && !feedback[i - 1].contains("refused"))
            CHECK(feedback[i]["at_receivers"]["bias"] > feedback[i - 1]["at_receivers"]["bias"]);
    CHECK(feedback[1]["at_receivers"]["bias"] < feedback[0]["at_receivers"]["bias"]);
    CHECK(s["goal"]["most"] == 0.03);
    CHECK(s["quads"]["ratio"] <= 1.2);
    CHECK(s["quads"]["whole"]["rms"] > 0);
    REQUIRE(s["sheets"].size() == 1);
    CHECK(s["sheets"][0]["id"] == "figure 5.13");
    // The lamp that emits and the spot: two lights; then one table each of levels, distances, degrees, rays, zones and borders.
    REQUIRE(s["lod"].size() == 8);
    for (const Json& table : s["lod"])
        for (const Json& row : table["rows"]) {
            CAPTURE(table["title"], row["setup"]);
            CHECK(row["at_pixels"]["mean"] > 0);
            CHECK(row["at_receivers"]["mean"] > 0);
            CHECK(row["ssim"] > 0);
        }
    CHECK(s["lod"][2]["rows"].size() == 5);
    CHECK(s.contains("seams"));
}

TEST_CASE("experiment ipr: spatial receivers, what moves, and graphs", "[program]") {
    const std::string out = fresh_folder("experiment_ipr_objects") + "/out";
    const Result r = run(ipr(std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/cornell_container.toml", {"-o", out, "--only", "spatial,objects,graphs", "--updates", "1"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json j = Json::parse(read(out + "/ipr.json"));
    const Json& s = j["scenes"][0];
    std::map<std::string, Json> sheets;
    for (const Json& sheet : s["sheets"]) sheets[sheet["id"].get<std::string>()] = sheet;
    // All places and those near the container make the same bits (figure 5.17: SSIM 1.0).
    const Json& active = sheets.at("figures 5.16, 5.17");
    REQUIRE(active["rows"].size() == 2);
    CHECK(active["rows"][1]["computed"] < active["rows"][0]["computed"]);
    CHECK(active["rows"][0]["computed"] == active["rows"][0]["places"]);
    CHECK(active["rows"][1]["SSIM"] == 1);
    CHECK_THAT(active["lines"][0].get<std::string>(), Contains("the same bits"));
    CHECK(active["rows"][0]["what moves: mean %"] == active["rows"][1]["what moves: mean %"]);
    const Json& density = sheets.at("table 5.3, figures 5.18, 5.19");
    REQUIRE(density["rows"].size() == 3);
    CHECK(density["rows"][2]["SSIM"].get<double>() == Approx(1));
    CHECK(density["rows"][2]["places"] > density["rows"][0]["places"]);
    CHECK(density["rows"][0]["thesis: ms"] == 4.15);
    for (const Json& row : density["rows"]) CHECK((row["what moves: mean %"] > 0 && row["what moves: mean %"] < 100));
    // Without its shadow the floor below the container is too bright.
    const Json& shadow = sheets.at("figure 5.21")["rows"];
    REQUIRE(shadow.size() == 3);
    CHECK(shadow[0]["pixels"] > 0);
    CHECK(shadow[1]["shadow: bias %"].get<double>() > shadow[0]["shadow: bias %"].get<double>() + 10);
    const Json& emit = sheets.at("figure 5.22")["rows"];
    REQUIRE(emit.size() == 4);  // three sets of surfaces that emit, and the lamps as static ones
    CHECK(emit[0]["name"] == "lamp");
    CHECK(emit[3]["name"] == "key");
    CHECK(emit[0]["what moves: mean %"] < 100);  // what black errs by; of one wall that emits highlights along the light vector are too bright for that
    for (const Json& row : emit) CHECK((row["pixels"] > 0 && row["what moves: mean %"] > 0));
    CHECK(sheets.at("figure 5.20")["rows"].size() == 4);
    CHECK_THAT(s["left_out"].dump(), Contains("figure 5.23"));
    CHECK(s["tables"][0]["rows"].size() == 4);
    const std::string parts = read(out + "/ipr_parts.csv"), page = read(out + "/ipr.html");
    CHECK_THAT(parts, Contains("cornell_container,figure 5.22,lamp,"));
    for (const char* word : {"table 5.3", "figure 5.5", "figure 5.8", "figure 5.20", "places that are computed"}) CHECK_THAT(page, Contains(word));
}

TEST_CASE("experiment ipr: normal maps of what stands still bring a picture nearer to the path traced one", "[program]") {
    const Result r = run(ipr(std::string(PLUMB_SOURCE_DIR) + "/data/scenes/objects/alcove.toml", {"--json", "--only", "spatial,objects"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json s = Json::parse(r.out)["scenes"][0];
    REQUIRE(s["sheets"].size() == 1);
    CHECK(s["sheets"][0]["id"] == "figure 5.23");
    const Json& rows = s["sheets"][0]["rows"];
    REQUIRE(rows.size() == 2);
    CHECK(rows[1]["static pixels: rms %"].get<double>() < 0.6 * rows[0]["static pixels: rms %"].get<double>());  // measured: 13 of 42
    CHECK(rows[1]["SSIM truth"] > rows[0]["SSIM truth"]);
    CHECK(s["left_out"].size() == 2);
}

TEST_CASE("experiment ipr: what is refused", "[program]") {
    const std::string folder = fresh_folder("experiment_ipr_refused"), scene = box(folder), out = folder + "/out";
    const auto refused = [&](const Words& more) {
        const Result r = run(ipr(scene, more));
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        return r.err;
    };
    CHECK_THAT(refused({"--only", "table"}), Contains("--only table") && Contains("lightmap"));
    CHECK_THAT(refused({"--samples", "0"}), Contains("--samples"));
    CHECK_THAT(refused({"--open", "nan"}), Contains("--open"));
    CHECK_THAT(refused({"--updates", "0"}), Contains("--updates"));
    CHECK_THAT(refused({"--preset", "isr_prnted"}),
               Contains("--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'"));
    CHECK_THAT(run({"experiment", "indirect-shadow", scene, "--preset", "isr_prnted"}).err,
               Contains("--preset isr_prnted: unknown preset; the nearest known one is 'isr_printed'"));
    CHECK_THAT(refused({"-o", out, "--set", "probes.degree=9"}), Contains("degree"));
    CHECK_THAT(refused({"--html", folder + "/none/page.html"}), Contains("none/page.html"));
    CHECK_THAT(refused({folder + "/none.toml"}), Contains("none.toml"));
    CHECK(!std::filesystem::exists(out));
    CHECK(run({"experiment", "ipr"}).exit == 2);
}
