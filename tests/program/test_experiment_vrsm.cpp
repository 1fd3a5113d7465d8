// plumb experiment vrsm, small: files, keys, that CSV, JSON and page hold the same numbers, bits, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "io/npy.h"
#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

namespace {

const Words small = {"--size", "64", "--seeds", "2", "--times", "--repeats", "2", "--truth-rays", "1e6", "--slots", "3,5"};

Result experiment(const std::string& scene, const std::string& out, Words more = {}) {
    Words words = {"experiment", "vrsm", "--scene", scene, "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}
Json json_of(const std::string& out) { return Json::parse(read(out + "/vrsm.json")); }

// Of the CSV's lines the cells; ours have no line ends and no doubled quotes.
std::vector<Words> csv_of(const std::string& out) {
    std::vector<Words> rows;
    std::istringstream lines(read(out + "/vrsm.csv"));
    for (std::string line; std::getline(lines, line);) {
        Words cells = {""};
        bool quoted = false;
        for (const char c : line) {
            if (c == '"')
                quoted = !quoted;
            else if (c == ',' && !quoted)
                cells.push_back("");
            else
                cells.back() += c;
        }
        rows.push_back(cells);
    }
    return rows;
}

double value_of(const Json& json, const std::string& table, const std::string& row, const std::string& quantity) {
    for (const Json& n : json["numbers"])
        if (n["table"] == table && n["row"] == row && n["quantity"] == quantity) return n["value"].get<double>();
    FAIL("no " << table << ", " << row << ": " << quantity);
    return 0;
}

std::string refused(const std::string& scene, const std::string& out, const Words& more) {
    const Result r = experiment(scene, out, more);
    INFO(r.out << r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK_FALSE(std::filesystem::exists(out));
    REQUIRE(r.err.rfind("plumb: ", 0) == 0);
    return r.err.substr(7, r.err.size() - 8);
}

}  // namespace

TEST_CASE("experiment vrsm: every file or none, and the same numbers in all of them", "[program][contract]") {
    const std::string folder = fresh_folder("experiment_vrsm"), scene = small_scene(folder), out = folder + "/out";
    const Result r = experiment(scene, out, small);
    INFO(r.err);
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    CHECK(files_in(out) == Words{"vrsm.csv", "vrsm.html", "vrsm.json"});
    CHECK_THAT(r.out, Contains("table 5.1") && Contains("table 5.2") && Contains("table 5.3") && Contains("least rms"));

    const Json json = json_of(out);
    CHECK(keys(json) ==
          Words{"isa", "processor", "threads", "seeds", "repeats", "load_before", "load_after", "scenes", "numbers"});
    CHECK(json["seeds"] == 2);
    CHECK(json["repeats"] == 2);
    REQUIRE(json["scenes"].size() == 1);
    const Json& s = json["scenes"][0];
    CHECK(keys(s) == Words{"name", "test_case", "triangles", "size", "settings", "times", "beyond", "by_seed", "truth",
                           "truth_seconds", "pictures"});
    CHECK(s["test_case"].is_null());
    CHECK(s["size"] == Json{64, 64});
    // The thesis' setting, whatever the scene file says.
    CHECK(s["settings"]["layout"] == "vrsm");
    CHECK(s["settings"]["rsm"]["gather"] == "paths");
    CHECK(s["settings"]["indirect"]["resolution"] == "half");
    CHECK(s["settings"]["indirect"]["kernel"] == 17);
    REQUIRE(s["times"].size() == 4);
    for (const Json& t : s["times"]) {
        REQUIRE(t["frame_ms"].size() == 2);
        for (std::size_t i = 0; i < 2; ++i) {
            double sum = 0;
            for (const Json& pass : t["pass_ms"]) sum += pass[i].get<double>();
            CHECK(sum == Approx(t["frame_ms"][i].get<double>()).epsilon(1e-12));
            CHECK(sum > 0);
        }
    }

    // CSV and JSON: the same rows, digit by digit.
    const std::vector<Words> csv = csv_of(out);
    REQUIRE(csv.size() == json["numbers"].size() + 1);
    CHECK(csv[0] == Words{"table", "scene", "row", "quantity", "unit", "value", "thesis"});
    std::map<std::string, int> rows;
    for (std::size_t i = 0; i < json["numbers"].size(); ++i) {
        const Json& n = json["numbers"][i];
        CAPTURE(n.dump());
        REQUIRE(keys(n) == csv[0]);
        REQUIRE(csv[i + 1].size() == 7);
        for (std::size_t k = 0; k < 5; ++k) CHECK(csv[i + 1][k] == n[csv[0][k]].get<std::string>());
        CHECK(csv[i + 1][5].empty() == n["value"].is_null());
        if (!n["value"].is_null()) CHECK(std::stod(csv[i + 1][5]) == n["value"].get<double>());
        CHECK(n["thesis"].is_null());
        ++rows[n["table"]];
    }
    // Without and 2 algorithms with 2 numbers of slots, of gather and frame; by 3 spacings with one; 18 numbers each.
    const int beyond = int(s["beyond"].size());
    CHECK(beyond > 10);
    CHECK(rows == std::map<std::string, int>{{"5.1", 12},
                                             {"5.2", 28},
                                             {"5.3", 10},
                                             {"errors", 180},
                                             {"spacing", 324},
                                             {"beyond", 15 * beyond},
                                             {"beyond all", 4 * beyond}});

    // Every mean and standard error is that of its seeds.
    int checked = 0;
    for (const Json& by_seed : s["by_seed"])
        for (const char* quantity : {"rms", "mean error", "removed", "leaked"}) {
            const Json& values = by_seed[quantity];
            REQUIRE(values.size() == 2);
            const std::string table = by_seed["table"], row = by_seed["row"];
            const double a = values[0], b = values[1];
            CHECK(value_of(json, table, row, quantity) == Approx((a + b) / 2).epsilon(1e-9).margin(1e-12));
            CHECK(value_of(json, table, row, std::string(quantity) + ", standard error") ==
                  Approx(std::abs(a - b) / 2).epsilon(1e-9).margin(1e-12));
            checked += a != b;
        }
    CHECK(checked > 100);

    // The page: all numbers of the errors and times, to the last digit, and nothing from elsewhere.
    const std::string html = read(out + "/vrsm.html");
    for (std::size_t i = 0; i < json["numbers"].size(); ++i) {
        const Json& n = json["numbers"][i];
        if (n["value"].is_null() || std::set<std::string>{"best", "not told apart", "winner", "least rms"}.contains(n["quantity"]))
            continue;
        CAPTURE(n.dump());
        CHECK_THAT(html, Contains("title=\"" + n["row"].get<std::string>() + ": " + n["quantity"].get<std::string>() +
                                  "\" data-order=\"" + csv[i + 1][5] + "\""));
    }
    CHECK(html.find("http://") == html.find("http://www.w3.org"));
    CHECK(html.find("src=\"http") == std::string::npos);
    for (const char* id : {"pattern", "table51", "table52", "table53", "beyond", "scene0", "differences", "how"})
        CHECK_THAT(html, Contains("id=\"" + std::string(id) + "\""));
}

TEST_CASE("experiment vrsm: the best is the least, visibility takes light, and shares are shares", "[program]") {
    const std::string folder = fresh_folder("experiment_vrsm_errors"), scene = small_scene(folder),
                      out = folder + "/out";
    REQUIRE(experiment(scene, out, small).exit == 0);
    const Json json = json_of(out);
    struct Row {
        double rms, error, noise;
        bool best, tied;
    };
    std::map<std::string, std::vector<Row>> rms;
    std::set<std::string> names;
    for (const Json& n : json["numbers"])
        if (n["table"] == "errors") names.insert(n["row"]);
    for (const std::string& row : names) {
        auto value = [&](const char* quantity) { return value_of(json, "errors", row, quantity); };
        rms[row.substr(0, row.find(','))].push_back({value("rms"), value("rms, standard error"), value("noise"), value("best") == 1,
                                                     value("not told apart") == 1});
        CHECK(value("no number") == 0);
        CHECK(value("rms") > 0);
        CHECK(value("noise") > 0);  // the truth is a subset here
        CHECK(value("too dark") + value("too bright") <= 100);
        // What is removed and what leaks makes up the mean, but for what noise hides of both.
        CHECK(value("leaked") - value("removed") == Approx(value("mean error")).margin(2 * value("noise")));
    }
    REQUIRE(rms.size() == 2);
    for (const auto& [kind, all] : rms) {
        // The least is best where two standard errors tell it from each of the others; else it and those are not told apart.
        const auto least = std::min_element(all.begin(), all.end(), [](const Row& a, const Row& b) { return a.rms < b.rms; });
        std::ptrdiff_t tied = 0;
        for (const Row& row : all) {
            const bool near = row.rms - least->rms <= 2 * std::hypot(row.error, least->error) || least->rms < 2 * least->noise ||
                              row.rms < 2 * row.noise;
            if (&row == &*least) continue;
            CHECK(row.tied == near);
            CHECK_FALSE(row.best);
            tied += near;
        }
        CHECK(least->best == (tied == 0));
        CHECK(least->tied == (tied > 0));
    }
    // Visibility can only take light away; fewer slots take more.
    for (const std::string kind : {"gather", "frame"}) {
        const double none = value_of(json, "errors", kind + ", none", "mean error"),
                     five = value_of(json, "errors", kind + ", algorithm_6, S = 5", "mean error"),
                     two = value_of(json, "errors", kind + ", algorithm_2, S = 5", "mean error");
        CHECK(none > five);
        CHECK(five > two);
    }
}

TEST_CASE("experiment vrsm: a winner beyond the thesis has at most its error, and less time", "[program]") {
    const std::string folder = fresh_folder("experiment_vrsm_beyond"), scene = small_scene(folder),
                      out = folder + "/out";
    const Result r = experiment(scene, out, small);
    REQUIRE(r.exit == 0);
    CHECK_THAT(r.out, Contains("VRSM's error on every scene by the least time: "));
    const Json json = json_of(out), &beyond = json["scenes"][0]["beyond"];
    REQUIRE(beyond[0]["row"] == "VRSM");
    CHECK(beyond[0]["sets"].empty());
    auto value = [&](const std::string& row, const char* quantity) { return value_of(json, "beyond", row, quantity); };
    // The thesis' own setting is the chain that the errors' table judges.
    CHECK(value("VRSM", "rms") == value_of(json, "errors", "frame, algorithm_6, S = 5", "rms"));
    CHECK(value("VRSM", "mean error") == value_of(json, "errors", "frame, algorithm_6, S = 5", "mean error"));
    CHECK(value("VRSM", "samples") == 150);
    for (const char* same : {"relative time", "relative rms"}) CHECK(value("VRSM", same) == 100);
    auto at_most = [&](const std::string& row) {
        return row == "VRSM" || value(row, "relative rms") + 2 * value(row, "relative rms, standard error") <= 100;
    };
    int winners = 0, least = 0, over_all = 0;
    double winners_time = 0, least_rms = 0;
    for (const Json& b : beyond) {
        const std::string row = b["row"];
        CAPTURE(row);
        std::vector<double> ratios;
        REQUIRE(b["ms"].size() == 2);
        for (std::size_t i = 0; i < 2; ++i)
            ratios.push_back(b["ms"][i].get<double>() / beyond[0]["ms"][i].get<double>());
        CHECK(value(row, "relative time") == Approx(50 * (ratios[0] + ratios[1])));
        if (value(row, "winner") == 1) {
            ++winners, winners_time = value(row, "relative time");
            CHECK(at_most(row));
        }
        if (value(row, "least rms") == 1) {
            ++least, least_rms = value(row, "rms");
            CHECK(value(row, "relative time") <= 100);
        }
        // Of one scene, the winner on it is the winner on all.
        CHECK(value_of(json, "beyond all", row, "winner") == value(row, "winner"));
        over_all += value_of(json, "beyond all", row, "winner") == 1;
    }
    CHECK((winners == 1 && least <= 1 && over_all == 1));
    for (const Json& b : beyond) {
        const std::string row = b["row"];
        CAPTURE(row);
        if (at_most(row)) CHECK(value(row, "relative time") >= winners_time);
        if (least == 1 && value(row, "relative time") <= 100) CHECK(value(row, "rms") >= least_rms);
    }

    REQUIRE(experiment(scene, folder + "/none",
                       {"--size", "64", "--seeds", "1", "--truth-rays", "1e5", "--slots", "5", "--no-beyond", "--set",
                        "rsm.turn=tile"})
                .exit == 0);
    const Json without = json_of(folder + "/none");
    CHECK(without["scenes"][0]["beyond"].empty());
    for (const Json& n : without["numbers"])
        CHECK(n["table"].get<std::string>().rfind("beyond", 0) == std::string::npos);
    CHECK(read(folder + "/none/vrsm.html").find("\"beyond\"") == std::string::npos);
    // Of one seed nothing is told apart.
    for (const Json& n : without["numbers"]) {
        if (n["quantity"] == "best") CHECK(n["value"] == 0);
        if (n["quantity"] == "rms, standard error") CHECK(n["value"].is_null());
    }
}

TEST_CASE("experiment vrsm: without --times nothing is timed, and samples are what a setting costs", "[program]") {
    const std::string folder = fresh_folder("experiment_vrsm_untimed"), scene = small_scene(folder), out = folder + "/out";
    const Result r = experiment(scene, out, {"--size", "48", "--seeds", "2", "--truth-rays", "1e5", "--slots", "5"});
    REQUIRE(r.exit == 0);
    CHECK_THAT(r.out, Contains("VRSM's error on every scene by the least samples: ") && !Contains("table 5.1"));
    const Json json = json_of(out);
    CHECK(json["repeats"] == 0);
    CHECK(json["scenes"][0]["times"].empty());
    for (const Json& n : json["numbers"]) {
        CHECK(n["table"].get<std::string>().rfind("5.", 0) == std::string::npos);
        CHECK(n["unit"] != "ms");
        CHECK(n["quantity"].get<std::string>().find("time") == std::string::npos);
    }
    CHECK(read(out + "/vrsm.html").find("id=\"table51\"") == std::string::npos);
}

TEST_CASE("experiment vrsm: where nothing hides the floor Algorithm 6 changes no bit, and no winner is named", "[program]") {
    // A lit floor, and a wall beside it that the light does not see: from the wall every texel of the floor is seen. Along a path
    // the floor's elevations fall or rise, so that no slot is met twice.
    const std::string folder = fresh_folder("experiment_vrsm_open"), scene = folder + "/open.toml", out = folder + "/out";
    write(folder + "/open.obj",
          "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 0 -1\nv 1 0 -1\nv 1 1.5 -1\nv -1 1.5 -1\n"
          "f 1 4 3 2\nf 5 6 7 8\n");
    write(scene,
          "[frame]\nsize = [64, 64]\n[camera]\nposition = [0, 0.75, 3]\nlook_at = [0, 0.75, -1]\nfov_y_deg = 40\n"
          "[[mesh]]\nfile = \"open.obj\"\n[[light]]\nname = \"sun\"\ntype = \"directional\"\ndirection = [0, -1, 0]\n"
          "intensity = [3, 3, 3]\n[rsm]\nradius = 0.7\n");
    const Result r = experiment(scene, out, {"--size", "64", "--seeds", "3", "--slots", "5,9", "--no-beyond", "--rays", "exact"});
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const Json json = json_of(out);
    for (const std::string kind : {"gather", "frame"}) {
        const std::string none = kind + ", none";
        for (const std::string row : {kind + ", algorithm_6, S = 5", kind + ", algorithm_6, S = 9"}) {
            CAPTURE(row);
            for (const char* quantity : {"rms", "rms, standard error", "mean error", "removed", "leaked"})
                CHECK(value_of(json, "errors", row, quantity) == value_of(json, "errors", none, quantity));
            CHECK(value_of(json, "errors", row, "leak stopped") == 0);
            CHECK(value_of(json, "errors", row, "not told apart") == value_of(json, "errors", none, "not told apart"));
        }
        CHECK(value_of(json, "errors", none, "best") == 0);
        CHECK(value_of(json, "errors", none, "noise") == 0);  // every texel was asked
        // Algorithm 2 hides neighbours on the floor.
        CHECK(value_of(json, "errors", kind + ", algorithm_2, S = 5", "mean error") < value_of(json, "errors", none, "mean error") - 10);
    }
    CHECK_THAT(r.out, Contains("least rms: not told apart: gather, none"));
}

TEST_CASE("experiment vrsm: errors are the same by every number of threads, and --json prints the file", "[program]") {
    const std::string folder = fresh_folder("experiment_vrsm_bits"), scene = small_scene(folder);
    Words words = small;
    words.insert(words.end(), {"--rays", "exact", "--json"});
    std::vector<Json> errors;
    for (const char* threads : {"1", "3"}) {
        words.insert(words.end(), {"--threads", threads});
        const Result r = experiment(scene, folder + "/out", words);
        words.resize(words.size() - 2);
        REQUIRE(r.exit == 0);
        CHECK(r.out == read(folder + "/out/vrsm.json"));
        errors.push_back(Json::array());
        const Json report = Json::parse(r.out);
        for (const Json& n : report["numbers"])
            if (n["table"] == "errors" || (n["table"] == "beyond" && n["quantity"] == "rms"))
                errors.back().push_back(n);
    }
    CHECK(errors[0].size() > 3);
    CHECK(errors[0] == errors[1]);
}

TEST_CASE("experiment vrsm: the thesis' numbers stand beside the atrium alone", "[program]") {
    const std::string folder = fresh_folder("experiment_vrsm_atrium"), scene = folder + "/atrium.toml";
    write(scene, "[[mesh]]\ngenerate = \"atrium\"\ntriangles = 7000\nseed = 2\n");
    const std::string out = folder + "/out";
    REQUIRE(experiment(scene, out, {"--size", "32", "--seeds", "1", "--times", "--repeats", "1", "--truth-rays", "1e5", "--slots", "5"}).exit ==
            0);
    const Json json = json_of(out);
    CHECK(json["scenes"][0]["test_case"] == "A");
    std::vector<double> printed;
    for (const Json& n : json["numbers"])
        if (!n["thesis"].is_null()) printed.push_back(n["thesis"]);
    // Tables 5.1 (A), 5.2 with what full resolution takes over half, and 5.3.
    CHECK(printed == std::vector<double>{31.6, 35.9, 14, 31.6, 35.9, 13, 1, 1, 79.8, 93.4, 17, 79.8 / 31.6, 93.4 / 35.9, 2.03, 5.7,
                                         2.47, 6.9, 21.8, 60.7, 9.60, 26.7, 35.9, 100});
}

TEST_CASE("experiment vrsm: what it cannot do is refused before anything is measured or written", "[program]") {
    const std::string folder = fresh_folder("experiment_vrsm_refused"), scene = small_scene(folder),
                      out = folder + "/out";
    auto message = [&](const Words& more) { return refused(scene, out, more); };
    CHECK_THAT(message({"--size", "15"}), Contains("--size"));
    CHECK_THAT(message({"--size", "many"}), Contains("--size"));
    CHECK_THAT(message({"--repeats", "0"}), Contains("--repeats"));
    CHECK_THAT(message({"--seeds", "0"}), Contains("--seeds"));
    for (const char* rays : {"nan", "-1", "few"}) CHECK_THAT(message({"--truth-rays", rays}), Contains("--truth-rays"));
    CHECK_THAT(message({"--slots", "1"}), Contains("--slots"));
    CHECK_THAT(message({"--slots", "5,33"}), Contains("--slots"));
    CHECK_THAT(message({"--slots", "5,5"}), Equals("--slots: expected each larger than the one before"));
    CHECK_THAT(message({"--rays", "some"}), Contains("--rays"));
    for (const char* key : {"rsm.slots=4", "rsm.gather=disc", "rsm.visibility=none", "indirect.resolution=full"})
        CHECK_THAT(message({"--set", key}), Contains("the experiment chooses it"));
    const std::vector<float> pattern(std::size_t(3) * 150, 1.0f);
    plumb::io::write_npy(folder + "/own.npy", plumb::DType::f32, {150, 3}, pattern.data());
    CHECK_THAT(message({"--set", "rsm.pattern=" + folder + "/own.npy"}), Contains("expected --no-beyond"));
    CHECK_THAT(message({"--set", "rsm.radiu=1"}), Contains("radius"));
    CHECK_THAT(message({"--set", "rsm.directions=0"}), Contains("directions"));
    CHECK_THAT(message({"--scene", scene}), Contains("given twice"));
    CHECK_THAT(refused(folder + "/missing.toml", out, {}), Contains("missing.toml"));
    write(scene, read(scene).substr(0, read(scene).find("[[light]]")));
    CHECK_THAT(message({}), Contains("no light of it is gathered"));
    const Result none = run({"experiment", "vrsm"});
    CHECK(none.exit == 2);
    CHECK_THAT(none.err, Contains("-o") || Contains("--output"));
}
