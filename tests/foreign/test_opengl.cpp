// The renderer of OpenGL as it stands: nothing that it draws is wrong.
#include <catch2/catch.hpp>
#include <iostream>

#include "tests/foreign/judged.h"
#include "tests/foreign/renderers.h"
#include "tests/program/program.h"

namespace {

using namespace plumb;
using namespace plumb::foreign;

TEST_CASE("foreign: a renderer of OpenGL that is right is judged so", "[foreign]") {
    if (!no_opengl().empty()) {
        std::cout << "SKIPPED: " << no_opengl() << "\n";
        return;
    }
    const std::string folder = program::fresh_folder("foreign_opengl");
    const Judged judged =
        judge(render_in_opengl(Exported(folder + "/exported"), {}, program::fresh_folder("foreign_opengl/C")));
    INFO(summary(judged));
    CHECK(judged.passed);
    CHECK(judged.wrong() == 0);
    CHECK(judged.stages.size() == 3);
    for (const JudgedStage& s : judged.stages) CHECK(s.verdict != "nothing_to_judge");
    std::cout << summary(judged);
}

}  // namespace
