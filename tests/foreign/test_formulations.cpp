// Shaders that are right, written otherwise: none is called wrong.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <iostream>

#include "tests/foreign/judged.h"
#include "tests/foreign/renderers.h"
#include "tests/program/program.h"

namespace {

using namespace plumb;
using namespace plumb::foreign;

TEST_CASE("foreign: other ways to write the same are not wrong", "[foreign]") {
    const std::vector<Variant> formulations = read_variants("formulations.toml", "formulation");
    REQUIRE(formulations.size() >= 20);
    if (!no_vulkan().empty()) {
        std::cout << "SKIPPED: " << no_vulkan() << "\n";
        return;
    }
    const std::string folder = program::fresh_folder("foreign_formulations");
    const Exported exported(folder + "/exported");
    const vulkan::Device device({.name = chosen_device(), .validate = false});
    const bool opengl = no_opengl().empty();
    if (!opengl) std::cout << "renderer C is left out: " << no_opengl() << "\n";

    int number = 0;
    for (const Variant& one : formulations) {
        const std::string out = program::fresh_folder(fmt::format("foreign_formulations/{}", ++number));
        if (one.renderer == "C" && !opengl) continue;
        const Judged judged = judge(render(device, exported, one, out));
        INFO(one.name << "\n" << summary(judged));
        CHECK(judged.passed);
        CHECK(judged.wrong() == 0);
        std::cout << one.name << "\n" << summary(judged);
    }
}

}  // namespace
