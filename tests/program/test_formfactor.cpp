// plumb formfactor.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string low = "0,0,0;0,0,1;1,0,1;1,0,0", high = "0,1,0;1,1,0;1,1,1;0,1,1", wall = "0,0,0;0,1,0;0,1,1;0,0,1";

// Two unit squares, 1 apart, and a screen that hides half of one from the other; a material each.
std::string three_squares(const std::string& folder) {
    write(folder + "/three.mtl",
          "newmtl low\nKd 0.5 0.5 0.5\nnewmtl high\nKd 0.5 0.5 0.5\nnewmtl screen\nKd 0.5 0.5 0.5\n");
    write(folder + "/three.obj",
          "mtllib three.mtl\n"
          "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nusemtl low\nf 1 2 3 4\n"
          "v 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\nusemtl high\nf 5 6 7 8\n"
          "v 0 0.5 0\nv 0.5 0.5 0\nv 0.5 0.5 1\nv 0 0.5 1\nusemtl screen\nf 9 10 11 12\n");
    return folder + "/three.obj";
}

Json found(Words words) {
    words.insert(words.begin(), "formfactor");
    words.push_back("--json");
    const Result r = run(words);
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    return Json::parse(r.out);
}

std::string refused(Words words) {
    words.insert(words.begin(), "formfactor");
    const Result r = run(words);
    INFO(r.out << r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}

}  // namespace

TEST_CASE("formfactor: unit squares by three methods", "[program][radiosity][analytic]") {
    // verification.md 3: Howell's C-11 and C-14.
    const std::pair<std::string, double> known[] = {{high, 0.199824895698387}, {wall, 0.200043776075403}};
    for (const auto& [b, truth] : known) {
        const Json json = found({low, b, "--size", "64,256", "--rays", "65536"});
        CHECK(keys(json) ==
              Words{"a", "b", "contour", "points", "hemicubes", "rays", "reciprocity", "between", "agrees", "verdict"});
        CHECK(json["contour"]["value"].get<double>() == Approx(truth).margin(1e-14).epsilon(0));
        CHECK(json["contour"]["error"].get<double>() < 1e-12);
        CHECK(json["contour"]["valid"] == true);
        const double rays = json["rays"]["value"], error = json["rays"]["standard_error"];
        CHECK(std::abs(rays - truth) < 5 * error);
        CHECK((error > 5e-4 && error < 2e-3));  // of independent rays 1.6e-3
        CHECK(json["hemicubes"].size() == 2);
        for (const Json& cube : json["hemicubes"]) {
            CHECK(cube["value"].get<double>() == Approx(json["points"]["value"].get<double>()).epsilon(0.01));
            CHECK(cube["value"].get<double>() == Approx(truth).epsilon(0.03));  // 64 points of A
        }
        for (const Json& product : json["reciprocity"]["contour_m2"])
            CHECK(product.get<double>() == Approx(truth).margin(1e-13));
        CHECK(std::abs(json["reciprocity"]["sigmas"].get<double>()) < 5);
        CHECK(json["between"]["hidden"] == 0);
        CHECK(json["agrees"] == true);
        CHECK_THAT(json["verdict"].get<std::string>(), StartsWith("nothing hides A from B"));
    }
    // From a point: Howell's B-3, 0.239456470460774, in brackets and without.
    for (const char* point : {"(0.5,0,0.5/0,2,0)", "0.5,0,0.5/0,1,0"}) {
        const Json json = found({point, high, "--size", "256"});
        CHECK(json["contour"]["value"].get<double>() == Approx(0.239456470460774).margin(1e-15).epsilon(0));
        CHECK(json["hemicubes"][0]["value"].get<double>() == Approx(0.239456470460774).epsilon(1e-3));
        CHECK(json["reciprocity"].is_null());
    }
}

TEST_CASE("formfactor: one picture in place of a hemicube", "[program][radiosity][HEM 4.5.3][analytic]") {
    // A plane of 90 degrees sees all of the square at distance 1, and of a wall at 0.5 what is higher than 0.5.
    const std::string patch = "0.5,0,0.5/0,1,0", side = "0,0,0;0,1,0;0,1,1;0,0,1";
    const Json above = found({patch, high, "--size", "128", "--view", "90"});
    REQUIRE(above["projections"].size() == 2);
    CHECK(above["projections"][0]["projection"] == "plane");
    CHECK(above["projections"][0]["size"] == 222);
    for (const Json& p : above["projections"]) CHECK(p["value"].get<double>() == Approx(0.239456470460774).epsilon(0.01));
    const double whole = found({patch, side, "--size", "2"})["contour"]["value"], low_half = found({patch, "0,0,0;0,0.5,0;0,0.5,1;0,0,1", "--size", "2"})["contour"]["value"];
    const Json half = found({patch, side, "--size", "256", "--view", "90"});
    CHECK(half["hemicubes"][0]["value"].get<double>() == Approx(whole).epsilon(0.01));
    CHECK(half["projections"][0]["value"].get<double>() == Approx(whole - low_half).epsilon(0.02));
    CHECK_THAT(run({"formfactor", patch, side, "--view", "170", "--size", "32"}).out, Contains("plane 56, 170 deg") && Contains("fish-eye 56, 170 deg"));
    CHECK_THAT(run({"formfactor", patch, side, "--view", "170", "--size", "32", "--csv"}).out, Contains("\nplane,56,1,0,0.") && Contains("\nfish-eye,56,1,0,0."));
}

TEST_CASE("formfactor: parts of a scene, and what hides them", "[program][radiosity][analytic]") {
    const std::string scene = three_squares(fresh_folder("formfactor"));
    const Json json = found({"low", "high", "--scene", scene, "--size", "128"});
    CHECK(json["contour"]["value"].get<double>() == Approx(0.199824895698387).epsilon(1e-9));
    CHECK(json["contour"]["valid"] == false);
    // The screen's mirror image hides the other half.
    const double half = 0.5 * 0.199824895698387, rays = json["rays"]["value"], error = json["rays"]["standard_error"];
    CHECK(std::abs(rays - half) < 5 * error);
    CHECK(json["hemicubes"][0]["value"].get<double>() == Approx(half).epsilon(0.03));
    CHECK(json["between"]["occluders"] == 2);
    CHECK_THAT(json["verdict"].get<std::string>(),
               StartsWith("the contour integral is not valid: 2 occluding triangles hide"));
    // A square is two triangles; and a given polygon has the scene around it.
    const double two = found({"low", "2", "--scene", scene, "--size", "2"})["contour"]["value"].get<double>() +
                       found({"material:low", "3", "--scene", scene, "--size", "2"})["contour"]["value"].get<double>();
    CHECK(two == Approx(0.199824895698387).epsilon(1e-9));
    CHECK(found({"low", "0,0.75,0;1,0.75,0;1,0.75,1;0,0.75,1", "--scene", scene, "--size",
                 "2"})["between"]["occluders"] == 2);
    CHECK(found({"0", "screen", "--scene", scene, "--size", "2"})["between"]["hidden"] == 0);
}

TEST_CASE("formfactor: what A cannot see is nothing", "[program][radiosity]") {
    for (const char* b : {"0,-1,0;1,-1,0;1,-1,1;0,-1,1", "1,0,0;2,0,0;2,0,1;1,0,1"}) {
        const Json json = found({low, b, "--size", "32", "--rays", "4096"});
        CHECK(json["contour"]["value"] == 0);
        CHECK(json["rays"]["value"] == 0);
        CHECK(json["hemicubes"][0]["value"] == 0);
        CHECK(json["verdict"] == "A sees nothing of B");
    }
}

TEST_CASE("formfactor: as a table, as lines, and over rotations", "[program][radiosity]") {
    const Words words{"formfactor", low, high, "--size", "32,64", "--rays", "4096", "--threads", "1"};
    const Result text = run(words);
    REQUIRE(text.exit == 0);
    CHECK_THAT(text.out, Contains("contour integral") && Contains("0.199824895698") && Contains("hemicube 64") &&
                             Contains("reciprocity"));
    Words more = words;
    more.back() = "2";
    CHECK(run(more).out == text.out);  // the same bits for any number of threads
    more.push_back("--csv");
    const Result lines = run(more);
    CHECK_THAT(
        lines.out,
        StartsWith("method,size,points,rays,value,standard_error,sigmas_from_rays\ncontour,0,0,0,0.19982489569838"));
    CHECK(std::count(lines.out.begin(), lines.out.end(), '\n') == 6);

    // verification.md 3, %: 0.267 and 0.898 at 64 texels, at their centres.
    const Result rotations = run({"formfactor", "--rotations", "--size", "64", "--json"});
    REQUIRE(rotations.exit == 0);
    const Json row = Json::parse(rotations.out)[0];
    CHECK(row["centre"]["rms_percent"].get<double>() == Approx(0.267).epsilon(2e-3));
    CHECK(row["centre"]["largest_percent"].get<double>() == Approx(0.898).epsilon(2e-3));
    CHECK(row["exact"]["rms_percent"].get<double>() == Approx(0.267).epsilon(5e-3));
    CHECK_THAT(run({"formfactor", "--rotations", "--size", "32,64"}).out, Contains("0.2673") && Contains("0.8982"));
    CHECK_THAT(run({"formfactor", "--rotations", "--size", "32", "--csv"}).out,
               StartsWith("size,exact_rms_percent") && Contains("\n32,0.7"));
}

TEST_CASE("formfactor: what cannot be is refused in a line", "[program]") {
    const std::string scene = three_squares(fresh_folder("formfactor_refused"));
    CHECK_THAT(refused({}), Contains("expected A and B"));
    CHECK_THAT(refused({low}), Contains("expected A and B"));
    CHECK_THAT(refused({"low", high}), Contains("--scene says"));
    CHECK_THAT(refused({"0,0,0;1,0,0", high}), Contains("A: 2 corners"));
    CHECK_THAT(refused({"0,0,0;1,0,0;2,0,0", high}), Contains("A: no area"));
    CHECK_THAT(refused({"0,0,0;1,0,0;1,1,1;0,1,0", high}), Contains("expected a flat polygon"));
    CHECK_THAT(refused({"0,0,0;2,0,0;0.2,0,0.2;0,0,2", high}), Contains("not convex"));
    for (const char* word : {"nan", "inf", "1e19", "x", "", "1 2", "0x1"})
        CHECK_THAT(refused({"0,0,0;0,0,1;1,0," + std::string(word), high}), Contains("expected x,y,z"));
    CHECK_THAT(refused({"0,0;0,1;1,0", high}), Contains("expected x,y,z"));
    CHECK_THAT(refused({"0,0,0/0,0,0", high}), Contains("the normal has no length"));
    CHECK_THAT(refused({low, "0,0,0/0,1,0"}), Contains("B: a point"));
    CHECK_THAT(refused({"lwo", "high", "--scene", scene}), Contains("; the nearest known one is \"low\""));
    CHECK_THAT(refused({"low", "6", "--scene", scene}), Contains("the scene has 6"));
    CHECK_THAT(refused({"low", "99999999999", "--scene", scene}), Contains("the scene has 6"));
    CHECK_THAT(refused({"low", "1", "--scene", scene}), Contains("A and B share triangle 1"));
    CHECK_THAT(refused({"object:low", "1", "--scene", scene}), Contains("no object \"low\""));
    CHECK_THAT(refused({"low", "high", "--scene", scene + ".no"}), Contains(".no"));
    for (const char* size : {"0", "3", "2048", "64,", "", "a", "64,-2", "99999999999"})
        CHECK_THAT(refused({low, high, "--size", size}), Contains("--size"));
    for (const char* rays : {"0", "31", "nan", "1e10", "-5"})
        CHECK_THAT(refused({low, high, "--rays", rays}), Contains("--rays"));
    CHECK_THAT(refused({low, high, "--points", "0"}), Contains("--points"));
    for (const char* view : {"0", "180", "nan", "-90"}) CHECK_THAT(refused({low, high, "--view", view}), Contains("--view"));
    CHECK_THAT(refused({low, high, "--weights", "heavy"}), Contains("expected exact, centre or published"));
    CHECK_THAT(refused({low, high, "--json", "--csv"}), Contains("--csv"));
    CHECK_THAT(refused({low, high, "--rotations"}), Contains("--rotations"));
}
