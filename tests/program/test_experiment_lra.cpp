// plumb experiment lra, small: files, that text, JSON, CSV and page hold the same rows, counts that are known, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

Words lra(const Words& more) {
    Words words = {"experiment", "lra", "--quick", "--divide", "16", "--triangles", "20000"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}
// By their names; what was counted stands in the rows whose times it explains.
std::map<std::string, Json> sheets_of(const Json& json) {
    std::map<std::string, Json> sheets;
    for (const Json& sheet : json["sheets"]) {
        const std::string id = sheet["id"], counts = " counts";
        if (!id.ends_with(counts)) {
            sheets[id] = sheet;
            continue;
        }
        Json& rows = sheets.at(id.substr(0, id.size() - counts.size()))["rows"];
        REQUIRE(sheet["rows"].size() == rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i].update(sheet["rows"][i]);
    }
    return sheets;
}
Json row_of(const Json& sheet, const std::string& name) {
    for (const Json& row : sheet["rows"])
        if (row["name"] == name) return row;
    FAIL("no row " + name);
    return {};
}
// Of every row but times, and what is made of them.
Json counts(Json json) {
    for (const char* key : {"isa", "threads", "load_before"}) json.erase(key);
    for (Json& sheet : json["sheets"]) {
        sheet.erase("lines");
        for (Json& row : sheet["rows"]) {
            Json kept;
            for (const auto& [key, value] : row.items())
                if (key.starts_with("thesis") || (key.find("ms") == key.npos && !key.starts_with("ratio"))) kept[key] = value;
            row = kept;
        }
    }
    return json;
}

}  // namespace

TEST_CASE("experiment lra: every table, the thesis' numbers beside ours, the same counts every time", "[program][contract][LRA 7]") {
    const std::string out = fresh_folder("experiment_lra") + "/out";
    const Result r = run(lra({"-o", out, "--threads", "1", "--isa", "scalar"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    CHECK(files_in(out) == Words{"lra.csv", "lra.html", "lra.json", "lra.txt"});
    const Json j = Json::parse(read(out + "/lra.json"));
    const std::string csv = read(out + "/lra.csv"), page = read(out + "/lra.html"), text = read(out + "/lra.txt");
    const auto sheets = sheets_of(j);
    const std::map<std::string, std::size_t> sizes = {{"table 7.1", 8}, {"table 7.2", 7}, {"table 7.3", 5}, {"table 7.4", 6}, {"table 7.5", 5}, {"table 7.6", 4}, {"one of many", 4}};
    REQUIRE(sheets.size() == sizes.size());
    for (const auto& [id, count] : sizes) {
        CAPTURE(id);
        CHECK(sheets.at(id)["rows"].size() == count);
        for (const std::string* where : {&page, &text, &csv}) CHECK_THAT(*where, Contains(id));
    }

    // What has no stage is said, with the thesis' numbers and without ours.
    const bool has_is = j["not_run"].empty();
    if (!has_is) CHECK_THAT(text, Contains("IS has no stage in this program"));
    for (const Json& row : sheets.at("table 7.1")["rows"]) {
        const std::string name = row["name"];
        CAPTURE(name);
        CHECK(row["thesis FPS"] > 18);
        const bool ran = has_is || name.find("IS") == name.npos;
        CHECK(row["settings"] == (ran ? "" : "not run: no stage"));
        CHECK(row["ms of all"].is_null() != ran);
        CHECK(row["covered pixels"].is_null() != ran);
        if (!ran) continue;
        // Samples are of pixels that see the model; a map has its texels.
        const double seen = row["covered pixels"];
        CHECK(seen > 100);
        CHECK(row["samples, millions"].get<double>() == Approx(name.find("ID") != name.npos ? 2e-4 * seen : 0).epsilon(0.02));
        CHECK(row["maps"] == 1);
        CHECK(row["map texels, millions"].get<double>() == Approx(128 * 128e-6));
        CHECK((row["IS ms"] > 0) == (name.find("IS") != name.npos));
        CHECK((row["AO ms"] > 0) == (name.find("AO") != name.npos));
        CHECK((row["ID ms"] > 0) == (name.find("ID") != name.npos));
        CHECK(row["fragments"] >= row["fragments that pass"]);
        CHECK(row["fragments that pass"] >= row["covered pixels"]);
    }
    CHECK(row_of(sheets.at("table 7.1"), "ID")["thesis ms"] == 42.28);
    CHECK(row_of(sheets.at("table 7.6"), "2")["thesis FPS"] == 11.35);

    // More of the model: more triangles, and never fewer fragments.
    const Json& share = sheets.at("table 7.2")["rows"];
    for (std::size_t i = 1; i < share.size(); ++i) {
        CHECK(share[i]["triangles"] > share[i - 1]["triangles"]);
        CHECK(share[i]["fragments"] >= share[i - 1]["fragments"]);
    }
    // A light more: as many samples and a map more.
    const Json& lights = sheets.at("table 7.4")["rows"];
    for (const Json& row : lights) {
        const double n = std::stod(row["name"].get<std::string>());
        CHECK(row["maps"] == n);
        CHECK(row["samples, millions"].get<double>() == Approx(n * lights[0]["samples, millions"].get<double>()).epsilon(1e-9));
    }
    CHECK(row_of(sheets.at("table 7.3"), "spot 2")["maps"] == 2);
    const Json point = row_of(sheets.at("table 7.3"), "point 1");
    CHECK((point["maps"] >= 1 && point["maps"] <= 6));
    CHECK(point["thesis FPS"].is_null());
    // What the model covers grows with the height of the frame alone: (720/800)^2, of 45 and 50 rows here.
    const Json &square = row_of(sheets.at("table 7.5"), "800 x 800"), &wide = row_of(sheets.at("table 7.5"), "1280 x 720");
    CHECK(wide["covered pixels"].get<double>() / square["covered pixels"].get<double>() == Approx(0.81).margin(0.02));

    // Who moves is drawn and gathered again, and nobody else.
    for (const Json& row : sheets.at("table 7.6")["rows"]) {
        const double n = std::stod(row["name"].get<std::string>());
        CHECK(row["maps drawn"] == n);
        CHECK(row["gathers"] == n);
        CHECK((row["stages that ran"] == 0) == (n == 0));
    }
    for (const Json& row : sheets.at("one of many")["rows"]) {
        CHECK(row["maps drawn"] == 1);
        CHECK(row["gathers"] == 1);
        CHECK(row["gathers MB"].get<double>() == Approx(50 * 50 * 16e-6 * std::stod(row["name"].get<std::string>().substr(7))));
    }

    const Result again = run(lra({"--json", "--threads", "3"}));
    REQUIRE(again.exit == 0);
    CHECK(counts(Json::parse(again.out)) == counts(j));
}

TEST_CASE("experiment lra: what it cannot do is refused before anything is measured or written", "[program]") {
    const std::string out = fresh_folder("experiment_lra_refused") + "/out";
    for (const auto& [words, why] : std::vector<std::pair<Words, std::string>>{{{"--only", "table"}, "--only table: expected algorithms, share,"},
                                                                              {{"--divide", "31"}, "--divide"},
                                                                              {{"--triangles", "10"}, "--triangles"},
                                                                              {{"--map", "9000"}, "--map"}}) {
        Words all = lra({"-o", out});
        all.insert(all.end(), words.begin(), words.end());
        const Result r = run(all);
        CHECK(r.exit == 2);
        CHECK_THAT(r.err, Contains(why));
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK_FALSE(std::filesystem::exists(out));
    }
}
