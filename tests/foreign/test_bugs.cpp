// Bugs that people write, planted in the three renderers: the judge finds each, and its cause stands among the first three
// that it names. Of every third the cause is asked for; PLUMB_FULL=1 asks for all.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
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

bool names(const Judged& judged, const std::string& text) {
    const JudgedStage* s = judged.first_wrong();
    return s && !text.empty() && std::any_of(s->causes.begin(), s->causes.end(), [&](const std::string& cause) {
        return cause.find(text) != std::string::npos;
    });
}

// A row of the table in README.md.
std::string row(const Variant& bug, const Judged& judged) {
    const JudgedStage* s = judged.first_wrong();
    return fmt::format("| {} | {} | {} | {} | {} | {} |\n", bug.name, bug.cause,
                       s ? fmt::format("{}: {} of {}", s->name, s->wrong, s->pixels) : "none", s ? "yes" : "no",
                       s ? joined(s->causes) : "", bug.named.empty() ? "no" : "yes");
}

// The bugs of a list, each judged with mutants of twins at hand. How many causes are named has to be as the list says.
void check_bugs(const std::string& list, std::size_t count, std::size_t named) {
    const std::vector<Variant> bugs = read_variants(list + ".toml", "bug");
    REQUIRE(bugs.size() == count);
    CHECK(std::size_t(std::count_if(bugs.begin(), bugs.end(), [](const Variant& b) { return !b.named.empty(); })) == named);
    if (!no_vulkan().empty()) {
        std::cout << "SKIPPED: " << no_vulkan() << "\n";
        return;
    }
    const std::string folder = program::fresh_folder("foreign_" + list);
    const Exported exported(folder + "/exported");
    const vulkan::Device device({.name = chosen_device(), .validate = false});
    const bool opengl = no_opengl().empty();
    if (!opengl) std::cout << "renderer C is left out: " << no_opengl() << "\n";

    std::string table =
        "| bug | cause | wrong pixels of the first stage that fails | found | first three causes named | right |\n"
        "|---|---|---|---|---|---|\n";
    for (std::size_t i = 0; i < bugs.size(); ++i) {
        const Variant& bug = bugs[i];
        if (bug.renderer == "C" && !opengl) continue;
        const bool asks = std::getenv("PLUMB_FULL") || i % 3 == 0;
        const std::string manifest = render(device, exported, bug, program::fresh_folder("foreign_" + list + "/" + bug.name));
        const Judged judged = judge(manifest, asks ? std::vector<std::string>{"--mutants", chosen_device()}
                                                   : std::vector<std::string>{"--no-diagnosis"});
        if (asks) table += row(bug, judged);
        INFO(bug.name << ": " << bug.cause << "\n" << summary(judged));
        CHECK(judged.first_wrong());
        CHECK(judged.wrong_stages() == bug.wrong);
        CHECK_FALSE(judged.passed);
        if (const JudgedStage* s = judged.first_wrong(); s && asks) {
            INFO("expected \"" << bug.named << "\" among: " << joined(s->causes));
            CHECK((bug.named.empty() || names(judged, bug.named)));
        }
    }
    std::ofstream(folder + "/table.md") << table;
    std::cout << table;
}

TEST_CASE("foreign: 30 bugs planted in three renderers are found, each in the stages that have it, and its cause named",
          "[foreign]") {
    check_bugs("bugs", 30, 30);
}

TEST_CASE("foreign: 10 bugs that were planted after the guesses", "[foreign]") { check_bugs("unforeseen", 10, 8); }

TEST_CASE("foreign: what only a mutant of the twin explains is named on a software device", "[foreign]") {
    if (!no_vulkan().empty()) {
        std::cout << "SKIPPED: " << no_vulkan() << "\n";
        return;
    }
    const std::string folder = program::fresh_folder("foreign_mutants");
    const Exported exported(folder + "/exported");
    const vulkan::Device device({.name = chosen_device(), .validate = false});
    for (const Variant& bug : read_variants("bugs.toml", "bug")) {
        if (bug.name != "A2") continue;
        const std::string manifest = render(device, exported, bug, program::fresh_folder("foreign_mutants/A2"));
        CHECK_FALSE(names(judge(manifest), bug.named));
        CHECK(names(judge(manifest, {"--mutants", chosen_device()}), bug.named));
        return;
    }
    FAIL("no bug A2");
}

}  // namespace
