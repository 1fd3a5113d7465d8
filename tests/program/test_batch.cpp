// plumb cameras and plumb batch: views are honest and the same every time, steps go on where they were cut, and the
// numbers are those of core/compare on the files that lie there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/compare_pictures.h"
#include "io/camera_list.h"
#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

// A list of two views of the small Cornell box.
std::string small_list(const std::string& folder) {
    small_scene(folder);
    write(folder + "/two.toml",
          "[[camera]]\nscene = \"small.toml\"\nname = \"front\"\nposition = [0, 0.995, 3.934]\n"
          "look_at = [0, 0.995, 0]\nfov_y_deg = 39.3077\n"
          "[[camera]]\nscene = \"small.toml\"\nname = \"inside\"\nposition = [0.5, 1.2, 0.8]\n"
          "look_at = [-0.5, 0.5, -0.5]\nfov_y_deg = 60\nexposure = 0.5\n");
    return folder + "/two.toml";
}
Result batch(const std::string& list, const std::string& out, Words more = {}) {
    Words words = {"batch", list, "-o", out, "--size", "32x24", "--samples", "16", "--model", "path"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}
Json json_of(const Result& r) { return Json::parse(r.out); }

plumb::compare::Picture picture(const std::string& path) { return plumb::io::read_picture(path); }

}  // namespace

TEST_CASE("cameras: random views are the same for a seed, and others for another", "[program]") {
    const std::string folder = fresh_folder("cameras"), scene = small_scene(folder);
    auto draw = [&](const std::string& name, const std::string& seed) {
        const Result r = run({"cameras", scene, "--random", "4", "--seed", seed, "-o", folder + "/" + name});
        INFO(r.err);
        REQUIRE(r.exit == 0);
        std::string text = read(folder + "/" + name);
        return text.substr(text.find("[[camera]]"));
    };
    const std::string first = draw("a.toml", "1");
    CHECK(draw("b.toml", "1") == first);
    CHECK(draw("c.toml", "2") != first);

    // Found beside the list, inside the box, and not in its walls or blocks.
    const plumb::io::CameraList list = plumb::io::read_camera_list(folder + "/a.toml");
    REQUIRE(list.cameras.size() == 4);
    for (const plumb::io::ListedCamera& c : list.cameras) {
        CHECK(c.scene == "small.toml");
        CHECK(std::fabs(c.position.x) < 1.02);
        CHECK((c.position.y > 0 && c.position.y < 1.99));
        CHECK(std::fabs(c.position.z) < 1.04);
        CHECK(std::fabs(glm::length(c.look_at - c.position) - 1) < 1e-5);
    }
    CHECK(run({"cameras", scene, "-o", folder + "/d.toml"}).exit == 2);
    CHECK(run({"cameras", scene, "--random", "2", "--frames", "0:3", "-o", folder + "/d.toml"}).exit == 2);
    CHECK_FALSE(std::filesystem::exists(folder + "/d.toml"));
    // The list's folder is made; a scene that is none is said without a place, and leaves no folder.
    const Result none = run({"cameras", "nope", "--random", "2", "-o", folder + "/not/d.toml"});
    CHECK(none.exit == 2);
    CHECK(none.err.find("plumb: unknown scene \"nope\"") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder + "/not"));
    CHECK(run({"cameras", scene, "--random", "2", "-o", folder + "/made/below/d.toml"}).exit == 0);
    CHECK(std::filesystem::exists(folder + "/made/below/d.toml"));
}

TEST_CASE("cameras: what they see is lit surface, by the renderer's own buffers", "[program]") {
    const std::string folder = fresh_folder("cameras_see"), scene = small_scene(folder);
    REQUIRE(run({"cameras", scene, "--random", "3", "-o", folder + "/list.toml"}).exit == 0);
    REQUIRE(batch(folder + "/list.toml", folder + "/out", {"--steps", "gather"}).exit == 0);
    for (const char* name : {"list_small_01", "list_small_02", "list_small_03"}) {
        const plumb::compare::Picture p = picture(folder + "/out/" + name + ".dl.exr");
        int lit = 0;
        for (std::size_t i = 0; i < p.data.size(); i += 3) lit += p.data[i] + p.data[i + 1] + p.data[i + 2] > 0;
        // 5 % by rays through 24 x 18 pixels; of 768 pixels somewhat less may be.
        CHECK(lit > 0.03 * 768);
    }
}

TEST_CASE("cameras: an animated scene's camera is recorded with its frame", "[program]") {
    const std::string folder = fresh_folder("cameras_recorded"), scene = small_scene(folder);
    write(scene, read(scene) +
                     "\n[[keyframe]]\nframe = 0\ncamera = { position = [0, 1, 3.9] }\n"
                     "[[keyframe]]\nframe = 10\ncamera = { position = [0, 1, 2.9] }\n");
    const Result r = run({"cameras", scene, "--frames", "0:10:5", "-o", folder + "/list.toml"});
    INFO(r.err);
    REQUIRE(r.exit == 0);
    const plumb::io::CameraList list = plumb::io::read_camera_list(folder + "/list.toml");
    REQUIRE(list.cameras.size() == 3);
    CHECK(list.cameras[1].name == "small_0005");
    CHECK(list.cameras[1].frame == 5);
    CHECK(list.cameras[1].position.z == Approx(3.4).epsilon(1e-12));
}

TEST_CASE("batch: numbers are core/compare's of the files that lie there", "[program][contract]") {
    const std::string folder = fresh_folder("batch_numbers"), list = small_list(folder), out = folder + "/out";
    const Result r = batch(list, out, {"--json"});
    INFO(r.err << r.out);
    REQUIRE(r.exit == 0);
    const Json json = json_of(r);
    CHECK(json["failed"] == 0);
    REQUIRE(json["views"].size() == 2);
    for (const Json& v : json["views"]) {
        const std::string name = v["name"];
        for (const char* ending : {".dl.png", ".dl.exr", ".isr.png", ".isr.exr", ".model.exr", "_01.png", "_02.png",
                                   "_03.png", ".difference.png"})
            CHECK(std::filesystem::exists(out + "/" + name + ending));
        CHECK(v["gain"].get<double>() ==
              Approx(1 - v["mean_error"]["isr"].get<double>() / v["mean_error"]["dl"].get<double>()).epsilon(1e-12));
        CHECK(v["quality"].get<int>() == (v["gain"].get<double>() > 0 ? 1 : v["gain"].get<double>() < 0 ? -1 : 0));
        CHECK(v["improved"].get<double>() + v["worse"].get<double>() <= 1);
    }
    // The second view's exposure is the list's, so that its display can be computed here.
    const Json& v = json["views"][1];
    auto shown = [&](const char* ending) {
        plumb::compare::Picture p = picture(out + "/two_inside" + ending);
        for (float& x : p.data) {
            const double y = 1 - std::exp(-0.5 * double(x));
            x = float(y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055);
        }
        return p;
    };
    const plumb::compare::Picture model = shown(".model.exr"), direct = shown(".dl.exr"), isr = shown(".isr.exr");
    plumb::compare::Options how;
    how.perceptual = false;
    const plumb::compare::Report a = plumb::compare::compare(direct, model, how),
                                 b = plumb::compare::compare(isr, model, how);
    CHECK(v["mean_error"]["dl"].get<double>() == Approx(*a.mean_error).epsilon(1e-5));
    CHECK(v["mean_error"]["isr"].get<double>() == Approx(*b.mean_error).epsilon(1e-5));
    CHECK(v["correlation"]["dl"].get<double>() == Approx(*a.pearson).epsilon(1e-5));
    CHECK(v["correlation"]["isr"].get<double>() == Approx(*b.pearson).epsilon(1e-5));
    // A pixel whose two errors are equal but for rounding may fall on either side.
    CHECK(std::fabs(v["improved"].get<double>() - *plumb::compare::share_improved(model, direct, isr)) < 0.01);

    const std::string csv = read(out + "/res.csv"), text = read(out + "/res.txt");
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 3);
    CHECK_THAT(csv, Contains("\ntwo_front,") && Contains("\ntwo_inside,"));
    CHECK_THAT(text, Contains(" vs. ") && Contains("m:"));
}

TEST_CASE("batch: what is there is not made again, and what was damaged or changed is", "[program][contract]") {
    const std::string folder = fresh_folder("batch_resumes"), list = small_list(folder), out = folder + "/out";
    auto counts = [&](Words more = {}) {
        more.push_back("--json");
        const Result r = batch(list, out, more);
        INFO(r.err << r.out);
        REQUIRE(r.exit == 0);
        const Json json = json_of(r);
        return std::pair<int, int>(json["gathered"], json["modelled"]);
    };
    // One step, then all: the step that is done is not done again.
    CHECK(counts({"--steps", "gather"}) == std::pair(2, 0));
    CHECK(counts() == std::pair(0, 2));
    CHECK(counts() == std::pair(0, 0));
    // A cut file, a missing one, a record that is no JSON.
    write(out + "/two_front.isr.exr", "cut");
    CHECK(counts() == std::pair(1, 0));
    std::filesystem::remove(out + "/two_inside.model.exr");
    CHECK(counts() == std::pair(0, 1));
    write(out + "/made/two_front.gather.json", "{\"key\": ");
    CHECK(counts() == std::pair(1, 0));
    CHECK(counts() == std::pair(0, 0));
    // Another view, another setting, another size: only what depends on it.
    std::string text = read(list);
    text.replace(text.find("fov_y_deg = 60"), 14, "fov_y_deg = 61");
    write(list, text);
    CHECK(counts() == std::pair(1, 1));
    CHECK(counts({"--set", "isr.rings=2"}) == std::pair(2, 0));
}

TEST_CASE("batch: a view that fails has its reason in its row and stops no other", "[program]") {
    const std::string folder = fresh_folder("batch_fails"), list = small_list(folder), out = folder + "/out";
    std::string text = read(list);
    text.replace(text.find("small.toml"), 10, "gone.toml");
    write(list, text);
    const Result r = batch(list, out, {"--json"});
    CHECK(r.exit == 1);
    const Json json = json_of(r);
    CHECK(json["failed"] == 1);
    CHECK_THAT(json["views"][0]["failed"].get<std::string>(), Contains("gather: ") && Contains("gone.toml"));
    CHECK(json["views"][1]["failed"].is_null());
    CHECK_THAT(read(out + "/res.csv"), Contains("gone.toml"));
    // Steps that were not taken before are asked for.
    const Result early = batch(small_list(folder + "/b"), folder + "/early", {"--steps", "compare"});
    CHECK(early.exit == 1);
    CHECK_THAT(early.out, Contains("expected --steps gather before"));

    CHECK(batch(list, folder + "/bad", {"--steps", "gather,render"}).exit == 2);
    CHECK(batch(folder + "/none.toml", folder + "/bad").exit == 2);
    CHECK_FALSE(std::filesystem::exists(folder + "/bad"));
}
