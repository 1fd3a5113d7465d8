// [[motion]] of scene files, and the other keys that stand for commands of IPR's figure A.1.
#include <fmt/format.h>

#include "core/animation.h"
#include "files.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const std::string base = R"(
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
[[mesh]]
name = "block"
file = "m.obj"
translate = [1, 0, 0]
[[light]]
name = "key"
position = [0, 2, 0]
)";

struct Files {
    Folder folder;
    Files() {
        folder.put("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl white\nf 1 2 3\nusemtl red\nf 1 2 3\n");
        folder.put("m.mtl", "newmtl white\nKd 0.75 0.75 0.75\nnewmtl red\nKd 0.5 0 0\n");
    }
    Scene load(const std::string& text) const { return load_scene(folder.put("s.toml", text), {"tonemap"}); }
    std::string error(const std::string& text) const {
        return error_of([&] { load(text); });
    }
};

}  // namespace

TEST_CASE("motion: curves, rates and turns arrive", "[io][motion][IPR A.1]") {
    const Files files;
    const Scene s = files.load(base + R"(
[[motion]]
mesh = "block"
bezier = [[0, 0, 0], [2, 0, 0], [4, 0, -8]]
speed = 0.125
end = "swing"
translate = [0, 1, 0]
turn_deg = [22.5, 0, 2, 0]
pivot = [1, 0, 0]
[[motion]]
light = "key"
translate = [1, 0, 2]
start = 2
[[motion]]
camera = true
bezier = [[0, 1, 4], [0, 1, 8]]
speed = 1
)");
    CHECK(is_animated(s));
    CHECK(s.meshes[0].dynamic);
    REQUIRE(s.animation.meshes.size() == 1);
    CHECK(s.animation.meshes[0].motion.end == PathEnd::swing);
    CHECK(s.animation.meshes[0].motion.axis == glm::dvec3(0, 1, 0));
    // As loaded: frame 0.
    CHECK(glm::dvec3(s.meshes[0].transform[3]) == glm::dvec3(1, 0, 0));
    const Scene four = scene_at(s, 4);
    // At t = 1/2: a quarter, a half and a quarter of the points; four metres up; a yaw of 90 degrees.
    CHECK(glm::dvec3(four.meshes[0].transform[3]) == glm::dvec3(3, 4, -2));
    CHECK(glm::dvec3(four.meshes[0].transform[0]) == glm::dvec3(0, 0, -1));
    CHECK(four.lights[0].position == glm::vec3(2, 2, 4));
    CHECK(scene_at(s, 2).lights[0].position == glm::vec3(0, 2, 0));
    CHECK(four.camera.position == glm::dvec3(0, 1, 8));
    CHECK(four.camera.look_at == glm::dvec3(0, 1, 0));
}

TEST_CASE("motion: goes together with keyframes of what it does not place", "[io][motion][IPR A.1]") {
    const Files files;
    const Scene s = files.load(base + R"(
[[keyframe]]
frame = 0
mesh.block.rotate_deg = [0, 0, 0]
light.key.direction = [1, 0, 0]
[[keyframe]]
frame = 8
mesh.block.rotate_deg = [180, 0, 0]
[[motion]]
mesh = "block"
bezier = [[0, 0, 0], [8, 0, 0]]
speed = 0.125
[[motion]]
light = "key"
turn_deg = [45, 0, 0, 1]
)");
    const Scene four = scene_at(s, 4);
    CHECK(glm::dvec3(four.meshes[0].transform[3]) == glm::dvec3(5, 0, 0));
    CHECK(glm::dvec3(four.meshes[0].transform[0]) == glm::dvec3(0, 0, -1));
    CHECK(four.lights[0].direction == glm::vec3(-1, 0, 0));
}

TEST_CASE("motion: malformed ones are named with line and cause", "[io][motion][robustness]") {
    const Files files;
    const int lines = int(std::count(base.begin(), base.end(), '\n'));
    const std::string m = "[[motion]]\nmesh = \"block\"\n", b = "bezier = [[0, 0, 0], [1, 0, 0]]\n", v = "translate = [1, 0, 0]\n";
    std::string many = "bezier = [[0, 0, 0]";
    for (int i = 0; i < 64; ++i) many += ", [0, 0, 0]";
    const std::vector<std::tuple<std::string, int, std::string>> cases = {
        {"[[motion]]\n" + v, 1, "[[motion]] mesh: expected one of mesh, light and camera"},
        {m + "camera = true\n" + v, 2, "[[motion]] mesh = \"block\": expected one of mesh, light and camera"},
        {"[motion]\nmesh = \"block\"\n", 1, "motion = a table: expected a list of tables, [[motion]]"},
        {m, 1, "[[motion]] bezier: expected bezier, translate or turn_deg that moves something"},
        {m + "translate = [0, 0, 0]\n", 1, "[[motion]] bezier: expected bezier, translate or turn_deg that moves"},
        {m + "bezeir = 1\n" + v, 3, "[[motion]] unknown key 'bezeir'; the nearest known one is 'bezier'"},
        {m + b, 1, "[[motion]] speed: is missing: the part of the curve that a frame takes"},
        {m + b + "speed = -0.1\n", 4, "[[motion]] speed = -0.1: expected 0 to 1"},
        {m + b + "speed = nan\n", 4, "[[motion]] speed = nan: expected 0 to 1"},
        {m + b + "speed = 1\nend = \"loop\"\n", 5, "[[motion]] end = \"loop\": expected"},
        {m + v + "speed = 1\n", 4, "[[motion]] speed = 1: stands without a bezier"},
        {m + "bezier = [[0, 0, 0]]\nspeed = 1\n", 3, "[[motion]] bezier = an array of 1: expected a list of 2 to 64 vectors"},
        {m + many + "]\nspeed = 1\n", 3, "[[motion]] bezier = an array of 65: expected a list of 2 to 64 vectors"},
        {m + "bezier = [[0, 0, 0], [0, 1]]\nspeed = 1\n", 3, "[[motion]] bezier = an array of 2: expected a list of 2"},
        {m + "bezier = [[0, 0, 0], [0, 1, nan]]\nspeed = 1\n", 3, "[[motion]] bezier = an array of 2: expected a finite"},
        {m + "bezier = [[0, 0, 0], [0, 1, 1e31]]\nspeed = 1\n", 3, "[[motion]] bezier = an array of 2: expected coordinates"},
        {m + "turn_deg = [1, 0, 0]\n", 3, "[[motion]] turn_deg = an array of 3: expected 4 numbers"},
        {m + "turn_deg = [1, 0, 0, 0]\n", 3, "[[motion]] turn_deg = an array of 4: the axis, its last three numbers"},
        {m + v + "start = -1\n", 4, "[[motion]] start = -1: expected 0 to 1000000"},
        {m + v + m + v, 4, "[[motion]] bezier: another [[motion]] moves the same"},
        {"[[keyframe]]\nframe = 0\nmesh.block.translate = [0, 0, 0]\n" + m + b + "speed = 1\n", 6,
         "[[motion]] bezier = an array of 2: keyframes give \"translate\"; expected one or the other"},
        {"[[motion]]\nmesh = \"blcok\"\n" + v, 2, "[[motion]] unknown mesh 'blcok'; the nearest known one is 'block'"},
        {"[[motion]]\nlight = \"kye\"\n" + v, 2, "[[motion]] unknown light 'kye'; the nearest known one is 'key'"},
        {"[[motion]]\ncamera = false\n" + v, 2, "[[motion]] camera = false: expected true, or no camera here"},
        {"[[motion]]\ncamera = true\nturn_deg = [1, 0, 1, 0]\n", 3, "[[motion]] turn_deg = an array of 4: a camera turns"},
        {"[[motion]]\ncamera = true\nbezier = [[0, 1, 4], [0, 1, 0]]\nspeed = 1\n", 1,
         "[[motion]] frame 1: camera: look_at = [0, 1, 0]: must be finite and away from position"},
    };
    for (const auto& [text, line, cause] : cases) {
        const std::string error = files.error(base + text);
        CAPTURE(text);
        CHECK_THAT(error, Catch::Matchers::Contains(fmt::format("s.toml: line {}: {}", lines + line, cause)));
        CHECK(error.find('\n') == std::string::npos);
    }
}

TEST_CASE("scene: yaw and pitch look from -z to the left and up", "[io][IPR A.1]") {
    const Files files;
    const auto camera = [&](const std::string& angles) {
        const Scene s = files.load("[[mesh]]\nfile = \"m.obj\"\n[camera]\nposition = [1, 2, 3]\n" + angles);
        return s.camera.look_at - s.camera.position;
    };
    CHECK(camera("yaw_deg = 0\n") == glm::dvec3(0, 0, -1));
    CHECK(camera("yaw_deg = 90\n") == glm::dvec3(-1, 0, 0));
    CHECK(camera("yaw_deg = 180\n") == glm::dvec3(0, 0, 1));
    const glm::dvec3 up = camera("yaw_deg = 90\npitch_deg = 30\n");
    CHECK(up.y == Approx(0.5).epsilon(1e-14));
    CHECK(up.x == Approx(-std::sqrt(0.75)).epsilon(1e-14));
    const Scene s = files.load("[[mesh]]\nfile = \"m.obj\"\n[[light]]\nyaw_deg = -90\n[[light]]\npitch_deg = -90\n");
    CHECK(s.lights[0].direction == glm::vec3(1, 0, 0));
    CHECK(s.lights[1].direction == glm::vec3(0, -1, 0));
    CHECK_THAT(files.error(base + "yaw_deg = 1\ndirection = [0, -1, 0]\n"),
               Catch::Matchers::Contains("[[light]] direction = an array of 3: stands beside yaw_deg or pitch_deg"));
    CHECK_THAT(files.error("[camera]\nyaw_deg = 1\n[[mesh]]\nfile = \"m.obj\"\n"),
               Catch::Matchers::Contains("line 1: [camera] position: is missing"));
    CHECK_THAT(files.error("[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 1]\nyaw_deg = 1\n[[mesh]]\nfile = \"m.obj\"\n"),
               Catch::Matchers::Contains("line 3: [camera] look_at = an array of 3: stands beside yaw_deg or pitch_deg"));
    CHECK_THAT(files.error("[camera]\nposition = [0, 0, 0]\npitch_deg = 91\n[[mesh]]\nfile = \"m.obj\"\n"),
               Catch::Matchers::Contains("line 3: [camera] pitch_deg = 91: expected -90 to 90"));
}

TEST_CASE("scene: a mesh turns about an axis of its own", "[io][IPR A.1]") {
    const Files files;
    const auto transform = [&](const std::string& keys) {
        return files.load("[[mesh]]\nfile = \"m.obj\"\n" + keys).meshes[0].transform;
    };
    CHECK(transform("turn_deg = [90, 0, 3, 0]\n") == transform("rotate_deg = [90, 0, 0]\n"));
    CHECK(transform("turn_deg = [90, 2, 0, 0]\n") == transform("rotate_deg = [0, 90, 0]\n"));
    CHECK(transform("turn_deg = [-90, 0, 0, 1]\n") == transform("rotate_deg = [0, 0, -90]\n"));
    // A third of a turn about the diagonal takes x to y.
    const glm::dvec3 x(transform("turn_deg = [120, 1, 1, 1]\n")[0]);
    CHECK(x.x == Approx(0).margin(1e-15));
    CHECK(x.y == Approx(1).epsilon(1e-15));
    CHECK(x.z == Approx(0).margin(1e-15));
    CHECK_THAT(files.error("[[mesh]]\nfile = \"m.obj\"\nturn_deg = [1, 0, 1, 0]\nrotate_deg = [1, 0, 0]\n"),
               Catch::Matchers::Contains("line 3: [[mesh]] turn_deg = an array of 4: stands beside rotate_deg"));
}

TEST_CASE("scene: a material is named by its place among those of the meshes", "[io][IPR A.1]") {
    const Files files;
    const Scene s = files.load(base + "[[mesh]]\nfile = \"m.obj\"\nmaterial = \"own\"\n[[material]]\nname = \"own\"\n"
                                      "[[material]]\nindex = 1\nemission = 0.2\n");
    REQUIRE(s.materials.size() == 5);
    for (std::size_t i = 0; i < s.materials.size(); ++i)
        CHECK(s.materials[i].emission == glm::vec3(i == 1 ? 0.2f : 0));
    CHECK(s.materials[1].name == "red");
    const std::string own = "[[material]]\nname = \"own\"\n", used = "[[mesh]]\nfile = \"m.obj\"\nmaterial = \"own\"\n";
    CHECK_THAT(files.error(base + used + own + "[[material]]\nindex = 4\n"),
               Catch::Matchers::Contains("[[material]] index = 4: expected 0 to 3"));
    CHECK_THAT(files.error(base + "[[material]]\nindex = -1\n"), Catch::Matchers::Contains("[[material]] index = -1: expected 0 to 1"));
    CHECK_THAT(files.error(base + "[[material]]\nindex = 0\nname = \"red\"\n"),
               Catch::Matchers::Contains("[[material]] index = 0: stands beside a name"));
    CHECK_THAT(files.error("[[light]]\n[[material]]\nindex = 0\n"),
               Catch::Matchers::Contains("[[material]] index = 0: no mesh brings a material"));
}
