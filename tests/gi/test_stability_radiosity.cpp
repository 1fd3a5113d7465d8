// Hemicube radiosity's stages against double: conditions that are known, extreme systems by hand, and scenes.
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "core/error.h"
#include "gi/lend.h"
#include "gi/radiosity/gather.h"
#include "gi/stability/radiosity.h"

using namespace plumb;
using namespace plumb::stability;

namespace {

const std::set<std::string> all_stages = {"radiosity.items", "radiosity.gather", "radiosity.lookup"};

}  // namespace

TEST_CASE("stability: the condition of a gathered sum that is known", "[stability][radiosity][analytic]") {
    // H = H0 + s (h_0 B_0 + h_1 B_1) with H0 = 1, s = 1, h B = 1 each: an ULP of H0 moves a third of H, one of the scale, of the weights
    // and of the radiosities two thirds. All are powers of two, whose ULP is eps of them.
    radiosity::RowBlock block;
    radiosity::pack({{0.5f, 0.5f}, 0, 0}, block);
    block.weights.resize(block.weights.size() + radiosity::row_lanes);
    const Buffer<glm::vec4> own = {glm::vec4(1), glm::vec4(1)}, b = {glm::vec4(2), glm::vec4(2)};
    radiosity::GatherInputs in{&block, &own, &b};
    in.decoded = true;
    const std::vector<Cell> cells = bake_cells({data_of(in)}, "", {});
    REQUIRE(cells.size() == 1);
    CHECK(cells[0].condition == Approx(1.0 / 3 + 3 * 2.0 / 3).epsilon(1e-4));
    CHECK(cells[0].used == 0);  // 3, exactly
}

TEST_CASE("stability: hemicubes, rows and corners by hand are within their budgets", "[stability][radiosity]") {
    std::map<std::string, std::set<std::string>> stages;
    for (const BakeCase& c : bake_cases()) {
        if (c.group != "radiosity") continue;
        for (const Cell& cell : bake_cells(c.data(), "", {})) {
            CAPTURE(c.name, cell.stage, cell.used, cell.condition, cell.digits_lost, cell.nonfinite, cell.flips, cell.reason, cell.most_lost);
            CHECK(cell.ok);
            CHECK_FALSE(cell.refused);
            CHECK(cell.used <= 16);
            CHECK(cell.pixels > 0);
            CHECK((cell.used > 0) == (c.name != "items without a normal"));
            stages[cell.stage].insert(c.name);
        }
    }
    CHECK(stages["radiosity.items"].size() == 10);
    CHECK(stages["radiosity.gather"].size() == 5);
    CHECK(stages["radiosity.lookup"].size() == 5);
    CHECK(stages["radiosity.reduce"].size() == 2);
}

TEST_CASE("stability: light of a last frame is within its budget, from aside, from behind, far away", "[stability][reuse]") {
    int met = 0;
    for (const BakeCase& c : bake_cases()) {
        if (c.group != "reuse") continue;
        for (const Cell& cell : bake_cells(c.data(), "", {})) {
            CAPTURE(c.name, cell.stage, cell.used, cell.condition, cell.digits_lost, cell.nonfinite, cell.flips, cell.reason, cell.most_lost);
            CHECK(cell.ok);
            CHECK_FALSE(cell.refused);
            CHECK(cell.used <= 16);
            ++met;
        }
    }
    CHECK(met == 9);
}

TEST_CASE("stability: radiosity has cells in a room of 0.2 mm and of 2000 km, far away, and of slivers; what it cannot serve it refuses",
          "[stability][radiosity]") {
    std::set<std::string> baked;
    for (const Case& c : cases()) {
        if (!is_baked(c)) continue;
        std::set<std::string> stages;
        std::vector<StageData> data;
        try {
            data = radiosity_data(c.scene(), {});
        } catch (const InputError& e) {
            INFO(c.name << ": " << e.what());
            CHECK(std::string(e.what()).starts_with("radiosity: "));
            continue;
        }
        for (const Cell& cell : bake_cells(data, "", {})) {
            CAPTURE(c.name, cell.stage, cell.used, cell.condition, cell.digits_lost, cell.nonfinite, cell.flips, cell.reason, cell.most_lost);
            CHECK(cell.ok);
            CHECK_FALSE(cell.refused);
            CHECK(cell.pixels > 0);
            CHECK((cell.used > 0 || c.name == "offset 1e7"));  // where 2 m are two steps of a float, nothing is seen
            CHECK((cell.used <= 16 || (c.name == "guard band" && cell.stage == "radiosity.items")));
            stages.insert(cell.stage);
        }
        CAPTURE(c.name);
        CHECK(stages == all_stages);
        baked.insert(c.name);
    }
    for (const char* name : {"room", "scale 1e-4", "scale 1e6", "offset 1e3", "offset 1e6", "slivers"}) CHECK(baked.count(name) == 1);
    CHECK(is_of_bake("radiosity.items"));
    CHECK_FALSE(is_of_bake("radiosity.rows"));
}
