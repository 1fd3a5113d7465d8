// plumb stability: the table of stages by cases as text, JSON and a page.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

const Words cell_keys = {"stage", "case",   "rel_error", "condition", "digits_lost", "nonfinite", "flips",
                         "budget", "refused", "ok",       "used",      "pixels",      "reason"};

Json report(Words words) {
    words.insert(words.begin(), {"stability", "--json", "--pixels", "8"});
    const Result r = run(words);
    INFO(r.out << r.err);
    CHECK(r.err.empty());
    const Json json = Json::parse(r.out);
    // The verdict is the exit code.
    CHECK(json["ok"] == (r.exit == 0));
    CHECK((r.exit == 0 || r.exit == 1));
    CHECK(keys(json) == Words{"cells", "ok"});
    for (const Json& cell : json["cells"]) CHECK(keys(cell) == cell_keys);
    return json;
}

}  // namespace

TEST_CASE("stability: every stage that runs has a cell, and the plain room is within the budget", "[program]") {
    const Json cells = report({"--case", "room"})["cells"];
    std::set<std::string> stages;
    for (const Json& cell : cells) {
        INFO(cell.dump());
        stages.insert(cell["stage"]);
        CHECK(cell["case"] == "room");
        CHECK((cell["ok"] == true && cell["refused"] == false && cell["nonfinite"] == 0));
        CHECK(double(cell["used"]) <= double(cell["budget"]));
        CHECK(double(cell["condition"]) >= 1);
        CHECK(int(cell["pixels"]) >= 1);
        // A level of detail is a whole number, and right or not.
        CHECK(std::string(cell["reason"]).empty() == (cell["stage"] == "probes.level"));
    }
    for (const char* stage : {"gbuffer", "rsm", "shadow", "rsm.disc", "rsm.all", "direct", "compose", "tonemap"})
        CHECK(stages.count(stage) == 1);
    CHECK(stages.size() == cells.size());
}

TEST_CASE("stability: no stage leaves its budget in any case, whatever the number of threads", "[program]") {
    auto cells_of = [](Words words) {
        words.insert(words.begin(), {"stability", "--json", "--pixels", "1"});
        const Result r = run(words);
        INFO(r.out << r.err);
        CHECK(r.exit == 0);
        return Json::parse(r.out)["cells"];
    };
    const Json table = cells_of({"--threads", "3"});
    std::set<std::string> cases, refused;
    for (const Json& cell : table) {
        INFO(cell.dump());
        cases.insert(cell["case"]);
        CHECK(cell["ok"] == true);
        if (cell["refused"]) refused.insert(cell["stage"].get<std::string>() + ": " + cell["case"].get<std::string>());
    }
    // A refusal excuses a cell: no other may hide behind one.
    CHECK(refused == std::set<std::string>{"gbuffer: isr, far infinite", "gbuffer: rgba16f at 65520",
                                           "gbuffer: rgba16f, emission", "rsm: rgba16f, flux",
                                           "rsm.all_rays: rgba16f, flux", "reference: offset 1e5",
                                           "reference: offset 1e6", "reference: offset 1e7",
                                           "reference: furnace, offset 1e5", "reference: furnace, offset 1e6",
                                           "hemicube: hemicube without a normal",
                                           "texture_space: chart that is no number",
                                           "screen.lobe: 16384 x 1",  // 1 + rays pictures side by side
                                           "probes.density: offset 1e7", "probes.supports: offset 1e7",
                                           "probes.share: offset 1e7", "probes.coefficients: offset 1e7", "probes.level: offset 1e7",
                                           "probes.radiance: offset 1e7", "probes.lambda: offset 1e7",
                                           "probes.basis: offset 1e7", "probes.irradiance: offset 1e7",
                                           "probes.lightmap: offset 1e7", "probes.volume: offset 1e7",
                                           "probes.lightmap_uv: offset 1e7", "probes.lookup: offset 1e7",
                                           "probes.radiance: rays at a level that there is not",
                                           "probes.radiance: rays that half reflect",
                                           "probes.lambda: a probe of a level that there is not",
                                           "probes.basis: a probe that is not there", "probes.irradiance: a probe that is not there",
                                           "probes.relief: offset 1e7", "probes.indirect_shadow: offset 1e7",
                                           "probes.density: radius of 1e-20", "probes.share: denormal weights",
                                           "probes.share: weights that are no numbers", "probes.share: hits infinitely far",
                                           "probes.coefficients: hits 2^61 m from a probe",
                                           "probes.coefficients: a hit that is no number"});
    CHECK(cases.size() == Json::parse(run({"stability", "--list", "--json"}).out)["cases"].size());
    // One pixel does not meet what a power makes of the darkest ones.
    CHECK(run({"stability", "--stage", "tonemap"}).exit == 0);
    for (const char* one : {"offset 1e3", "fan of 4096"}) {
        Json alone = cells_of({"--threads", "1", "--case", one}), of_table = Json::array();
        for (const Json& cell : table)
            if (cell["case"] == one) of_table.push_back(cell);
        CHECK(alone == of_table);
    }
}

TEST_CASE("stability: a refusal is no failure, and is told", "[program]") {
    const Json cell = report({"--stage", "gbuffer", "--case", "rgba16f at 65520"})["cells"].at(0);
    CHECK((cell["refused"] == true && cell["ok"] == true));
    const Result text = run({"stability", "--stage", "gbuffer", "--case", "rgba16f at 65520"});
    CHECK(text.exit == 0);
    CHECK_THAT(text.out, Contains("refused in advance") && Contains("do not fit rgba16f") &&
                             Contains("1 cells: 0 within the budget, 1 refused in advance, 0 not ok"));
    // The worst of each stage: of one that computed nothing there is none.
    CHECK_THAT(text.out, Contains("most used of C") && Contains("gbuffer      1        1       0               -"));
}

TEST_CASE("stability: cases are listed with their meaning", "[program]") {
    const Result text = run({"stability", "--list"});
    CHECK(text.exit == 0);
    CHECK_THAT(text.out,
               StartsWith("group") && Contains("light ratio 1e8") && Contains("the camera is inside the box"));
    const Json cases = Json::parse(run({"stability", "--list", "--json"}).out)["cases"];
    CHECK(cases.size() > 70);
    for (const Json& c : cases) CHECK(keys(c) == Words{"name", "group", "meaning"});
}

TEST_CASE("stability: the heat map is one file that opens without a network", "[program]") {
    const std::string folder = fresh_folder("stability_page");
    const Result r = run({"stability", "--case", "room", "--pixels", "8", "--html", folder + "/map.html"});
    CHECK(r.exit == 0);
    CHECK(files_in(folder) == Words{"map.html"});
    const std::string html = read(folder + "/map.html");
    CHECK_THAT(html, Contains("rsm.disc") && Contains("digits lost") && Contains("href=\"#case-0\"") &&
                         Contains("id=\"case-0\"") && Contains("nothing is extreme"));
    for (const char* network : {"src=\"http", "href=\"http", "src=\"//", "href=\"//", "<link", "url(http", "@import"})
        CHECK_THAT(html, !Contains(network));
    CHECK(run({"stability", "--case", "room", "--pixels", "1", "--html", folder + "/none/map.html"}).exit == 2);
}

TEST_CASE("stability: what does not exist is refused in a line", "[program]") {
    auto refused = [](const Words& words) {
        const Result r = run(words);
        INFO(r.out << r.err);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        return r.err;
    };
    CHECK_THAT(refused({"stability", "--stage", "shdow"}),
               Equals("plumb: unknown stage 'shdow'; the nearest known one is 'shadow'\n"));
    CHECK_THAT(refused({"stability", "--case", "distance 1"}), Contains("the nearest known one is 'distance 0'"));
    CHECK_THAT(refused({"stability", "--pixels", "0"}), Contains("--pixels"));
    CHECK_THAT(refused({"stability", "--cases"}), Contains("--case"));
}
