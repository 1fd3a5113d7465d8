// Stages that bind no data, against double: all cases that have no scene, and a scene.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>

#include "gi/reference/closed_form_scenes.h"
#include "gi/stability/cases.h"
#include "gi/stability/unbound.h"
#include "gi/stability/unbound_look.h"
#include "gi/stability/unbound_stages.h"

using namespace plumb;
using namespace plumb::stability;

namespace {

// 200,000 reflections a path: for `plumb stability`.
const std::string slow = "furnace, rho 0.999999";

const Case& case_named(const std::string& name) {
    for (const Case& c : cases())
        if (c.name == name) return c;
    FAIL("no case is named " << name);
    throw;
}

Cell judged(const std::vector<Checked>& numbers) {
    Cell cell;
    cell.pixels = std::int64_t(numbers.size());
    judge(
        numbers, [](std::size_t) { return "number"; }, cell);
    conclude(cell);
    return cell;
}

}  // namespace

TEST_CASE("stability: every case without a scene is within its budget, or is refused as it says",
          "[stability][unbound]") {
    const std::set<std::string> refused = {"furnace, offset 1e5", "furnace, offset 1e6", "hemicube without a normal",
                                           "chart that is no number"};
    std::set<std::string> names;
    for (const UnboundCase& c : unbound_cases()) {
        CHECK(names.insert(c.name).second);
        if (c.name == slow) continue;
        const std::vector<Cell> cells = c.run({});
        REQUIRE(cells.size() == 1);
        CAPTURE(c.name, cells[0].stage, cells[0].used, cells[0].nonfinite, cells[0].reason);
        CHECK(cells[0].ok);
        CHECK(cells[0].refused == (refused.count(c.name) == 1));
        CHECK(cells[0].budget == 16);
    }
    CHECK(names.count(slow) == 1);
}

TEST_CASE("stability: all stages without a twin have a cell in a room, at any scale and distance",
          "[stability][unbound]") {
    for (const char* name : {"scale 1e-4", "scale 1e6", "offset 1e3", "light grazing 1e-6", "reflectance 1"}) {
        const Case& c = case_named(name);
        const Scene scene = c.scene();
        std::set<std::string> stages;
        for (const Cell& cell : unbound_cells(c.name, scene, case_settings(c, scene), {})) {
            stages.insert(cell.stage);
            CAPTURE(name, cell.stage, cell.used, cell.nonfinite, cell.reason);
            CHECK(cell.ok);
            CHECK_FALSE(cell.refused);
            CHECK(cell.pixels > 0);
            CHECK(cell.case_name == name);
            // Rounding is there, and it is seen; but the surfaces of some rooms are exact.
            if (cell.stage != "texture_space") CHECK(cell.used > 1e-6);
        }
        CHECK(stages == std::set<std::string>{"hemicube", "reference", "rsm.all_rays", "texture_space", "visibility"});
    }
}

TEST_CASE("stability: cells are the same on one thread and on four", "[stability][unbound][bits]") {
    const Case& c = case_named("scale 1e2");
    const Scene scene = c.scene();
    Effort one, four;
    one.run.threads = 1, four.run.threads = 4;
    const std::vector<Cell> a = unbound_cells(c.name, scene, case_settings(c, scene), one);
    const std::vector<Cell> b = unbound_cells(c.name, scene, case_settings(c, scene), four);
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(a[i].stage);
        CHECK((a[i].used == b[i].used && a[i].rel_error == b[i].rel_error && a[i].flips == b[i].flips));
    }
}

TEST_CASE("stability: a verdict about numbers fails closed", "[stability][unbound]") {
    const double eps = 0x1p-23, nan = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();
    CHECK(judged({{1 + 15.9 * eps, 1}}).ok);
    CHECK_FALSE(judged({{1 + 16.1 * eps, 1}}).ok);
    CHECK(judged({{1 + 160 * eps, 1, 10.1}}).ok);
    CHECK_FALSE(judged({{1 + 160 * eps, 1, 9.9}}).ok);
    CHECK_FALSE(judged({{1, 1}, {1 + 17 * eps, 1}, {1, 1}}).ok);
    CHECK_FALSE(judged({}).ok);
    for (const double bad : {nan, infinity, -infinity, 1e39}) {
        CHECK_FALSE(judged({{bad, 1}}).ok);
        CHECK_FALSE(judged({{1, bad}}).ok);
        CHECK_FALSE(judged({{1, 1}, {bad, bad}, {1, 1}}).ok);
    }
    CHECK_FALSE(judged({{2, 1, nan}, {1, 1}}).ok);
    // What a device flushes to 0 is no error; half as much again is.
    CHECK(judged({{0, 0.9 * 0x1p-126}}).ok);
    CHECK_FALSE(judged({{0, 1.5 * 0x1p-126}}).ok);
    // One part in 2^20 of one is 16 half ULPs of a float: 1.2 digits.
    CHECK(judged({{1 + 8 * eps, 1}}).digits_lost == Approx(std::log10(16.0)));
}

TEST_CASE("stability: a kernel that rounds too much is red, one whose inputs explain it is not",
          "[stability][unbound]") {
    // (x + 1e4) - 1e4 loses four digits; the condition of x + y - y, with y an input, explains them.
    float x = 0.7311f, y = 1e4f;
    Subject subject{"planted", {"value"}, {}, {}};
    subject.invocations.push_back(
        {"here", [&](std::vector<Followed>& out) { out.push_back(Followed(x) + Followed(1e4f) - Followed(1e4f)); }});
    add_columns("x", &x, 1, 1, {0}, subject.inputs);
    CHECK_FALSE(look(subject, {}).ok);
    float z = 1e4f;
    subject.invocations[0].run = [&](std::vector<Followed>& out) {
        out.push_back(Followed(x) + Followed(y) - Followed(z));
    };
    add_columns("y", &y, 1, 1, {0}, subject.inputs);
    add_columns("z", &z, 1, 1, {0}, subject.inputs);
    const Cell explained = look(subject, {});
    CHECK(explained.ok);
    CHECK(explained.condition > 1e4);
    CHECK((x == 0.7311f && y == 1e4f && z == 1e4f));
}

TEST_CASE("stability: paths of ten thousand reflections have the closed form's mean",
          "[stability][unbound][reference]") {
    Scene scene;
    reference::add_cube(scene, reference::grey(0.9999, 1), glm::dvec3(-1), glm::dvec3(1));
    const auto prepared = reference::prepare(scene, Rays::native);
    const reference::ReceiverPoints points = reference::spread(scene.meshes[0], glm::dvec3(0), 64);
    reference::PathParams params;
    params.samples = 4, params.rounds = 4;
    Image4 position(16, 1), normal(16, 1);
    for (std::size_t i = 0; i < 16; ++i) {
        position.texels[i] = points.position.texels[i * points.position.size() / 16];
        normal.texels[i] = points.normal.texels[i * points.normal.size() / 16];
    }
    const reference::Estimate e = reference::trace_irradiance(params, *prepared, {&position, &normal}, 1, {});
    double mean = 0, variance = 0;
    for (std::size_t i = 0; i < 16; ++i) {
        mean += double(e.mean.texels[i].x) / 16;
        variance += double(e.error.texels[i].x) * e.error.texels[i].x / 256;
    }
    const double expected = 1 / (1 - double(0.9999f));
    CAPTURE(mean, std::sqrt(variance), expected);
    CHECK(e.nonfinite == 0);
    CHECK(std::sqrt(variance) < 0.15 * expected);
    CHECK(std::abs(mean - expected) < 4 * std::sqrt(variance));
}
