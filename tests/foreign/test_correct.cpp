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
    const std::string out = program::fresh_folder("foreign_correct/A");
    const Judged judged = judge(render_in_view_space(device, exported, {}, out));
    std::cout << summary(judged);
    CHECK(judged.passed);
}

}  // namespace
