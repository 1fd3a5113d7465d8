// [[keyframe]] of scene files.
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
[[mesh]]
file = "m.obj"
[[mesh]]
name = "hall"
generate = "shapes"
triangles = 200
[[light]]
name = "key"
position = [0, 2, 0]
[[light]]
name = "sun"
type = "directional"
)";

struct Files {
    Folder folder;
    Files() { folder.put("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"); }
    Scene load(const std::string& text) const { return load_scene(folder.put("s.toml", base + text), {"rsm"}); }
    std::string error(const std::string& text) const {
        return error_of([&] { load(text); });
    }
};

}  // namespace

TEST_CASE("keyframes: every key arrives, in tables or inline", "[io][keyframes]") {
    const Files files;
    const Scene tables = files.load(R"(
[[keyframe]]
frame = 0
[keyframe.camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
up = [0, 1, 0]
fov_y_deg = 40
[keyframe.light.key]
position = [0, 2, 0]
direction = [0, -2, 0]
cone_deg = [10, 20]
intensity = [1, 2, 3]
on = true
[keyframe.mesh.block]
translate = [0, 0, 0]
rotate_deg = [0, 0, 0]
scale = 1
pivot = [0.5, 0, 0]
[[keyframe]]
frame = 10
[keyframe.camera]
position = [1, 1, 4]
[keyframe.light.key]
intensity = [3, 2, 1]
on = false
[keyframe.mesh.block]
translate = [0, 1, 0]
rotate_deg = [90, 0, 0]
scale = [1, 2, 3]
)");
    const Scene inlined = files.load(R"(
[[keyframe]]
frame = 0
camera = { position = [0, 1, 4], look_at = [0, 1, 0], up = [0, 1, 0], fov_y_deg = 40 }
light.key = { position = [0, 2, 0], direction = [0, -1, 0], cone_deg = [10, 20], intensity = [1, 2, 3], on = true }
mesh.block = { translate = [0, 0, 0], rotate_deg = [0, 0, 0], scale = 1, pivot = [0.5, 0, 0] }
[[keyframe]]
frame = 10
camera.position = [1, 1, 4]
light.key = { intensity = [3, 2, 1], on = false }
mesh.block = { translate = [0, 1, 0], rotate_deg = [90, 0, 0], scale = [1, 2, 3] }
)");
    for (const Scene* scene : {&tables, &inlined}) {
        const Scene half = scene_at(*scene, 5), last = scene_at(*scene, 10);
        CHECK(half.camera.position == glm::dvec3(0.5, 1, 4));
        CHECK(half.camera.fov_y_deg == 40);
        CHECK(half.lights[0].direction == glm::vec3(0, -1, 0));
        CHECK(half.lights[0].cone_outer_deg == 20);
        CHECK(half.lights[0].intensity == glm::vec3(2));
        CHECK(half.lights[0].on);
        CHECK_FALSE(last.lights[0].on);
        // About (0.5, 0, 0): the origin of the block, at (1, 0, 0), turns from +x to -z and rises.
        CHECK(glm::dvec3(last.meshes[0].transform[3]) == glm::dvec3(0.5, 1, -0.5));
        CHECK(glm::dvec3(last.meshes[0].transform[0]) == glm::dvec3(0, 0, -1));
        CHECK(glm::dvec3(last.meshes[0].transform[1]) == glm::dvec3(0, 2, 0));
        CHECK(last.meshes[1].transform == scene->meshes[1].transform);
        CHECK(scene->meshes[0].dynamic);
        CHECK_FALSE(scene->meshes[1].dynamic);
    }
}

TEST_CASE("keyframes: a scene is loaded in its pose at frame 0", "[io][keyframes]") {
    const Files files;
    const Scene s = files.load("[[keyframe]]\nframe = 4\ncamera.position = [0, 1, 3]\nmesh.block.translate = [0, 1, 0]\n"
                               "[[keyframe]]\nframe = 8\ncamera.position = [0, 1, 2]\n");
    CHECK(s.camera.position == glm::dvec3(0, 1, 3));
    CHECK(glm::dvec3(s.meshes[0].transform[3]) == glm::dvec3(1, 1, 0));
    // Poses are of the mesh's own transform, not of the last pose.
    CHECK(glm::dvec3(scene_at(s, 8).meshes[0].transform[3]) == glm::dvec3(1, 1, 0));
    CHECK(scene_at(s, 6).camera.position == glm::dvec3(0, 1, 2.5));
    CHECK_FALSE(is_animated(files.load("")));
}

TEST_CASE("keyframes: a [[mesh]] with a name moves as one, about where it stands", "[io][keyframes]") {
    const Files files;
    const Scene s = files.load("[[keyframe]]\nframe = 0\nmesh.hall.rotate_deg = [90, 0, 0]\n"
                               "mesh.block.rotate_deg = [180, 0, 0]\n");
    REQUIRE(s.meshes.size() > 3);
    CHECK(s.meshes[0].name == "block");
    // Alone, a mesh turns about its own origin.
    CHECK(glm::dvec3(s.meshes[0].transform[3]) == glm::dvec3(1, 0, 0));
    CHECK(glm::dvec3(s.meshes[0].transform[0]) == glm::dvec3(-1, 0, 0));
    for (std::size_t m = 2; m < s.meshes.size(); ++m) {
        CHECK(s.meshes[m].name.rfind("hall/", 0) == 0);
        CHECK(s.meshes[m].dynamic);
        CHECK(glm::dvec3(s.meshes[m].transform[0]) == glm::dvec3(0, 0, -1));
    }
    // One of them can move alone.
    const std::string one = s.meshes[2].name;
    const Scene alone = files.load(fmt::format("[[keyframe]]\nframe = 0\nmesh.\"{}\".translate = [0, 5, 0]\n", one));
    CHECK(alone.meshes[2].transform[3].y == 5);
    CHECK(alone.meshes[3].transform[3].y == 0);
}

TEST_CASE("keyframes: malformed ones are named with line and cause", "[io][keyframes][robustness]") {
    const Files files;
    const int lines = int(std::count(base.begin(), base.end(), '\n'));
    const std::string k = "[[keyframe]]\nframe = 3\n";
    const std::vector<std::tuple<std::string, int, std::string>> cases = {
        {"[[keyframe]]\n", 1, "[[keyframe]] frame: is missing"},
        {"[keyframe]\nframe = 0\n", 1, "keyframe = a table: expected a list of tables, [[keyframe]]"},
        {"[[keyframe]]\nframe = -1\n", 2, "[[keyframe]] frame = -1: expected 0 to 1000000"},
        {"[[keyframe]]\nframe = nan\n", 2, "[[keyframe]] frame = nan: expected 0 to 1000000"},
        {"[[keyframe]]\nframe = inf\n", 2, "[[keyframe]] frame = inf: expected 0 to 1000000"},
        {"[[keyframe]]\nframe = \"1\"\n", 2, "[[keyframe]] frame = \"1\": expected a number"},
        {k + k, 4, "[[keyframe]] frame = 3: expected above that of the keyframe before, 3"},
        {k + "[[keyframe]]\nframe = 2\n", 4, "[[keyframe]] frame = 2: expected above that of the keyframe before, 3"},
        {k + "camra.position = [0, 0, 0]\n", 3, "[[keyframe]] unknown key 'camra'; the nearest known one is 'camera'"},
        {k + "camera = 1\n", 3, "[[keyframe]] camera = 1: expected a table, [camera]"},
        {k + "camera.posit = 1\n", 3, "[keyframe.camera] unknown key 'posit'; the nearest known one is 'position'"},
        {k + "camera.position = [0, 0]\n", 3, "[keyframe.camera] position = an array of 2: expected 3 numbers"},
        {k + "camera.position = [0, 0, nan]\n", 3, "[keyframe.camera] position holds nan: expected a finite number"},
        {k + "camera.position = [0, 1, 0]\n", 1,
         "[[keyframe]] frame 3: camera: look_at = [0, 1, 0]: must be finite and away from position"},
        {k + "camera.fov_y_deg = 180\n", 1, "[[keyframe]] frame 3: camera: fov_y_deg = 180: must be above 0"},
        {k + "light.kye.on = true\n", 3, "[keyframe.light] unknown light 'kye'; the nearest known one is 'key'"},
        {k + "light.key = 1\n", 3, "[keyframe.light] key = 1: expected a table, [key]"},
        {k + "light.key.rsm_size = 1\n", 3, "[keyframe.light.key] unknown key 'rsm_size'; known: "},
        {k + "light.key.direction = [0, 0, 0]\n", 3, "[keyframe.light.key] direction = an array of 3: has no length"},
        {k + "light.key.intensity = [0, 0, -1]\n", 3, "[keyframe.light.key] intensity holds -1: expected 0 to 3e+38"},
        {k + "light.key.cone_deg = [20, 10]\n", 3, "[keyframe.light.key] cone_deg = an array of 2: expected 0 <= inner"},
        {k + "light.key.on = 1\n", 3, "[keyframe.light.key] on = 1: expected true or false"},
        {k + "mesh.blcok.scale = 1\n", 3, "[keyframe.mesh] unknown mesh 'blcok'; the nearest known one is 'block'"},
        {k + "mesh.block.move = [1, 1, 1]\n", 3, "[keyframe.mesh.\"block\"] unknown key 'move'; known: "},
        {k + "mesh.block.scale = 0\n", 3, "[keyframe.mesh.\"block\"] scale = 0: expected a size of 1e-30 to 1e30"},
        {k + "mesh.block.translate = [0, inf, 0]\n", 3, "[keyframe.mesh.\"block\"] translate holds inf"},
        {k + "mesh.block.translate = [0, 0, 0]\n[[keyframe]]\nframe = 5\nmesh.block.pivot = [0, 1, 0]\n", 6,
         "[keyframe.mesh.\"block\"] pivot = an array of 3: expected in the first keyframe of this mesh"},
        {"[[mesh]]\nname = \"block\"\nfile = \"m.obj\"\n", 2, "[[mesh]] name = \"block\": another mesh has that name"},
        {"[[mesh]]\nname = \"\"\nfile = \"m.obj\"\n", 2, "[[mesh]] name = \"\": expected a name"},
    };
    for (const auto& [text, line, cause] : cases) {
        const std::string error = files.error(text);
        CAPTURE(text);
        CHECK_THAT(error, Catch::Matchers::Contains(fmt::format("s.toml: line {}: {}", lines + line, cause)));
        CHECK(error.find('\n') == std::string::npos);
    }
}

TEST_CASE("keyframes: no mesh is moved by two names", "[io][keyframes][robustness]") {
    const Files files;
    const Scene s = files.load("");
    const std::string one = s.meshes.at(2).name;
    const std::string error = files.error(
        fmt::format("[[keyframe]]\nframe = 0\nmesh.hall.scale = 2\nmesh.\"{}\".scale = 2\n", one));
    CHECK_THAT(error, Catch::Matchers::Contains("[keyframe.mesh] \"" + one + "\" has mesh \"" + one +
                                                "\", which \"hall\" moves already"));
}
