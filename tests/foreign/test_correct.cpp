// The renderers as they stand: nothing that they draw is wrong.
#include <catch2/catch.hpp>
#include <iostream>

#include "tests/foreign/judged.h"
#include "tests/foreign/renderers.h"
#include "tests/program/program.h"

namespace {

using namespace plumb;
using namespace plumb::foreign;

TEST_CASE("foreign: three renderers that are right are judged so", "[foreign]") {
    const std::string folder = program::fresh_folder("foreign_correct");
    const Exported exported(folder + "/exported");
    const vulkan::Device device({.name = "llvmpipe", .validate = true});
    auto fresh = [](const char* name) { return program::fresh_folder(std::string("foreign_correct/") + name); };
    auto check = [](const std::string& manifest, std::size_t stages) {
        const Judged judged = judge(manifest);
        INFO(summary(judged));
        CHECK(judged.passed);
        CHECK(judged.wrong() == 0);
        REQUIRE(judged.stages.size() == stages);
        for (const JudgedStage& s : judged.stages) CHECK(s.verdict != "nothing_to_judge");
        std::cout << summary(judged);
    };
    check(render_in_view_space(device, exported, {}, fresh("A")), 2);
    check(render_deferred(device, exported, {}, fresh("B")), 6);
    if (no_opengl().empty())
        check(render_in_opengl(exported, {}, fresh("C")), 3);
    else
        std::cout << "renderer C is left out: " << no_opengl() << "\n";
    for (const std::string& complaint : device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(device.complaints().empty());
}

}  // namespace
