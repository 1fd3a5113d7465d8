// plumb experiment hemicube, small: files, that text, JSON, CSV and page hold the same rows, bits, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

Words hemicube(const Words& more) {
    Words words = {"experiment", "hemicube", "--quick"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}
std::map<std::string, Json> sheets_of(const Json& json) {
    std::map<std::string, Json> sheets;
    for (const Json& sheet : json["sheets"]) sheets[sheet["id"].get<std::string>()] = sheet;
    return sheets;
}
// Times, and the exponents that are fitted to them.
Json without_times(Json json) {
    json.erase("isa"), json.erase("threads");
    for (Json& sheet : json["sheets"]) {
        sheet.erase("lines");
        for (Json& row : sheet["rows"]) {
            Json kept;
            for (const auto& [key, value] : row.items()) {
                const bool time = key == "s" || key.ends_with(" s") || key.ends_with("ms") || key.ends_with(" us") || key.starts_with("their time") || key.find("100 ns") != key.npos || key.find("share") != key.npos || key == "times ours";
                if (!time) kept[key] = value;
            }
            row = kept;
        }
    }
    return json;
}

}  // namespace

TEST_CASE("experiment hemicube: the same rows in text, JSON, CSV and page, the same bits every time", "[program][contract]") {
    const std::string out = fresh_folder("experiment_hemicube") + "/out";
    const Result r = run(hemicube({"-o", out, "--only", "complexity,sizes,solvers", "--threads", "1", "--isa", "scalar"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json j = Json::parse(read(out + "/hemicube.json"));
    const std::string csv = read(out + "/hemicube.csv"), page = read(out + "/hemicube.html");
    CHECK(j["version"] == 1);
    const auto sheets = sheets_of(j);
    const Json &first = sheets.at("test 1")["rows"], &second = sheets.at("test 2")["rows"];
    REQUIRE(first.size() == 2);
    CHECK(first[0]["vertices"] == 774);
    CHECK(first[0]["triangles"] == 1200);
    CHECK(first[1]["vertices"] == 2734);
    CHECK(first[1]["triangles"] == 4800);
    REQUIRE(second.size() == 3);
    CHECK(second[2]["texels"] == 3 * 64 * 64);
    CHECK(second[2]["against the largest: mean %"] == 0);
    CHECK(second[0]["against the largest: mean %"].get<double>() > second[1]["against the largest: mean %"].get<double>());
    for (const Json& rows : {first, second})
        for (const Json& row : rows) {
            CAPTURE(row["name"]);
            CHECK(row["visibility s"] > 0);
            CHECK(row["passes s"] > 0);
            CHECK((row["sum's share %"] > 0 && row["sum's share %"] < 100));
            CHECK((row["truth: mean %"] > 0 && row["truth: mean %"] < 100));
            CHECK((row["truth: truth +- %"] > 0 && row["truth: truth +- %"] < 20));
            CHECK_THAT(csv, Contains("," + row["name"].get<std::string>() + ","));
            CHECK_THAT(r.out, Contains(row["name"].get<std::string>()));
        }
    // A larger hemicube errs less; five passes leave more than ten.
    CHECK(second[2]["truth: mean %"] < second[0]["truth: mean %"]);
    CHECK(second[1]["passes against converged: mean %"] > first[0]["passes against converged: mean %"]);
    const Json& passes = sheets.at("HEM 4.5.4")["rows"];
    for (std::size_t i = 1; i < passes.size(); ++i)
        for (const char* of : {"the box", "rho 0.95", "rho 0.999"})
            if (passes[i - 1][of] > 1e-4) CHECK(passes[i][of] < passes[i - 1][of]);  // below, floats have rounded
    const Json& solvers = sheets.at("solvers, rho 0.999")["rows"];
    REQUIRE(solvers.size() == 6);
    CHECK(solvers[0]["name"] == "passes");
    CHECK(solvers[0]["products to 1 %"].is_null());         // 4,600 of them are due
    CHECK(solvers[3]["products to 0.01 %"].get<double>() < 40);  // bicgstab
    for (const char* word : {"test 1", "figure 5.5", "figure 5.6", "figure 5.7", "Guesses", "plumb experiment hemicube"}) CHECK_THAT(page, Contains(word));

    const Result again = run(hemicube({"--json", "--only", "complexity,sizes,solvers", "--threads", "3"}));
    REQUIRE(again.exit == 0);
    CHECK(without_times(Json::parse(again.out)) == without_times(j));
}

TEST_CASE("experiment hemicube: plates, and what choices cost", "[program]") {
    const std::string out = fresh_folder("experiment_hemicube_plates") + "/out";
    const Result r = run(hemicube({"-o", out, "--only", "plates,projections,buffers"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json j = Json::parse(read(out + "/hemicube.json"));
    const auto sheets = sheets_of(j);
    CHECK(sheets.at("plates C.1 to C.8")["rows"].size() == 8);
    for (const Json& row : sheets.at("plates C.1 to C.8")["rows"]) CHECK(row["ms"] > 0);
    for (const auto& [plate, seconds] : {std::pair("plate C.9", 58), std::pair("plate C.10", 203)}) {
        const Json& row = sheets.at(plate)["rows"][0];
        CHECK(row["thesis: s"] == seconds);
        CHECK(row["s"] > 0);
        CHECK((row["pixels: rms %"] > 0 && row["pixels: rms %"] < 60));
    }
    // A wider plane loses less of the hemisphere: 100 (1 - 0.554126) at 90 degrees.
    std::map<std::string, Json> ways;
    for (const Json& row : sheets.at("HEM 4.5.3")["rows"]) ways[row["name"].get<std::string>()] = row;
    const char* lost = "lost: % of the hemisphere";
    CHECK(ways.at("plane, 90 degrees")[lost].get<double>() == Approx(44.5874).margin(1e-3));
    CHECK(ways.at("plane, 170 degrees")[lost] < ways.at("plane, 120 degrees")[lost]);
    CHECK(ways.at("hemicube")[lost] == 0);
    const char* corner = "squares at a right angle (C-14) %";
    CHECK(ways.at("plane, 90 degrees")[corner] < -30);
    CHECK(std::abs(ways.at("hemicube")[corner].get<double>()) < 5);
    std::map<std::string, Json> choices;
    for (const Json& row : sheets.at("HEM 5.5 to 5.7")["rows"]) choices[row["name"].get<std::string>()] = row;
    const char* off = "against floats: mean %";
    CHECK(choices.at("floats")[off] == 0);
    CHECK((choices.at("RGBE texels")[off] > 0 && choices.at("RGBE texels")[off] < 1));
    CHECK(choices.at("multiplier maps")[off] > 1);
    CHECK(choices.at("vertices saturated")[off] > 50);
    CHECK(choices.at("decoder as printed")[off] > 25000);
    CHECK_THAT(read(out + "/hemicube.html"), Contains("C.10") && Contains("data:image/png"));
}

TEST_CASE("experiment hemicube: a row by hemicubes and by rays", "[program]") {
    const Result r = run(hemicube({"--json", "--only", "rows"}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json sheet = sheets_of(Json::parse(r.out)).at("rows");
    std::map<std::string, Json> rows;
    for (const Json& row : sheet["rows"]) rows[row["name"].get<std::string>()] = row;
    CHECK(rows.at("hemicube 64")["texels, rays"] == 3 * 64 * 64);
    for (const char* error : {"elements: error %", "patches: error %", "light: error %"}) {
        CAPTURE(error);
        const auto of = [&](const char* name) { return rows.at(name)[error].get<double>(); };
        CHECK((of("hemicube 64") > 0 && of("hemicube 64") < 4));
        CHECK(of("hemicube 64") < of("hemicube 16"));
        // A row's light is one sum, whose errors cancel as they happen to: of few eyes either of two neighbours may have less.
        if (error != std::string("light: error %")) {
            CHECK(of("hemicube 64") < of("hemicube 32"));
            CHECK(of("hemicube 32") < of("hemicube 16"));
        }
        CHECK(of("65536 rays") < of("hemicube 64"));
        CHECK(of("65536 rays") < of("1024 rays"));
    }
    // Elements are parts of patches.
    for (const auto& [name, row] : rows) CHECK(row["patches: error %"] < row["elements: error %"]);
    const Json& own = rows.at("hemicube 64");
    CHECK((own["rays as good, elements"] > 4096 && own["rays as good, elements"] < 16384));
    CHECK(own["their time / ours, elements"] > 0);
    CHECK(rows.at("256 rays")["their time / ours, elements"].is_null());

    const Result again = run(hemicube({"--json", "--only", "rows", "--threads", "1", "--isa", "scalar"}));
    REQUIRE(again.exit == 0);
    CHECK(without_times(Json::parse(again.out)) == without_times(Json::parse(r.out)));
}

TEST_CASE("experiment hemicube: what is refused", "[program]") {
    const std::string out = fresh_folder("experiment_hemicube_refused") + "/out";
    const auto refused = [&](const Words& more) {
        const Result r = run(hemicube(more));
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        return r.err;
    };
    CHECK_THAT(refused({"-o", out, "--only", "size"}), Contains("--only size") && Contains("complexity"));
    CHECK_THAT(refused({"-o", out, "--samples", "0"}), Contains("--samples"));
    CHECK_THAT(refused({"-o", out, "--size", "8x8"}), Contains("--size"));
    CHECK_THAT(refused({"-o", out, "--repeats", "0"}), Contains("--repeats"));
    CHECK_THAT(refused({"-o", "/dev/null/x"}), Contains("/dev/null"));
    CHECK(!std::filesystem::exists(out));
}
