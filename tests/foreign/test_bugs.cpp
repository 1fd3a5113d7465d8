// Bugs that people write, planted in the three renderers: the judge finds each.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iostream>

#include "tests/foreign/judged.h"
#include "tests/foreign/renderers.h"
#include "tests/program/program.h"

namespace {

using namespace plumb;
using namespace plumb::foreign;

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& w : words) text += (text.empty() ? "" : "; ") + w;
    return text;
}

// A row of the table in README.md.
std::string row(const Variant& bug, const Judged& judged) {
    const JudgedStage* s = judged.first_wrong();
    return fmt::format("| {} | {} | {} | {} | {} |\n", bug.name, bug.cause,
                       s ? fmt::format("{}: {} of {}", s->name, s->wrong, s->pixels) : "none", s ? "yes" : "no",
                       s ? joined(s->causes) : "");
}

TEST_CASE("foreign: 30 bugs planted in three renderers are found, each in the stages that have it", "[foreign]") {
    const std::vector<Variant> bugs = read_variants("bugs.toml", "bug");
    REQUIRE(bugs.size() == 30);
    if (!no_vulkan().empty()) {
        std::cout << "SKIPPED: " << no_vulkan() << "\n";
        return;
    }
    const std::string folder = program::fresh_folder("foreign_bugs");
    const Exported exported(folder + "/exported");
    const vulkan::Device device({.name = "llvmpipe", .validate = false});
    const bool opengl = no_opengl().empty();
    if (!opengl) std::cout << "renderer C is left out: " << no_opengl() << "\n";

    std::string table =
        "| bug | cause | wrong pixels of the first stage that fails | found | first three causes named |\n"
        "|---|---|---|---|---|\n";
    for (const Variant& bug : bugs) {
        if (bug.renderer == "C" && !opengl) continue;
        const Judged judged = judge(render(device, exported, bug, program::fresh_folder("foreign_bugs/" + bug.name)));
        table += row(bug, judged);
        INFO(bug.name << ": " << bug.cause << "\n" << summary(judged));
        CHECK(judged.first_wrong());
        CHECK(judged.wrong_stages() == bug.wrong);
        CHECK_FALSE(judged.passed);
    }
    std::ofstream(folder + "/table.md") << table;
    std::cout << table;
}

}  // namespace
