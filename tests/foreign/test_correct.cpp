// The renderers of Vulkan as they stand: nothing that they draw is wrong.
#include <catch2/catch.hpp>
#include <iostream>

#include "tests/foreign/judged.h"
#include "tests/foreign/renderers.h"
#include "tests/program/program.h"

namespace {

using namespace plumb;
using namespace plumb::foreign;

TEST_CASE("foreign: two renderers of Vulkan that are right are judged so", "[foreign]") {
    if (!no_vulkan().empty()) {
        std::cout << "SKIPPED: " << no_vulkan() << "\n";
        return;
    }
    const Exported exported(program::fresh_folder("foreign_correct") + "/exported");
    const vulkan::Device device({.name = chosen_device(), .validate = true});
    for (const auto& [name, stages] : {std::pair("A", 2), std::pair("B", 6)}) {
        Variant as_it_stands;
        as_it_stands.renderer = name;
        const std::string folder = program::fresh_folder(std::string("foreign_correct/") + name);
        const Judged judged = judge(render(device, exported, as_it_stands, folder));
        INFO(summary(judged));
        CHECK(judged.passed);
        CHECK(judged.wrong() == 0);
        CHECK(int(judged.stages.size()) == stages);
        for (const JudgedStage& s : judged.stages) CHECK(s.verdict != "nothing_to_judge");
        std::cout << summary(judged);
    }
    for (const std::string& complaint : device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(device.complaints().empty());
}

}  // namespace
