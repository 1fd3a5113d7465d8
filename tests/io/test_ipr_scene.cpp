// The thesis' scene files: every command of IPR's figure A.1 arrives in a scene.
#include "core/animation.h"
#include "files.h"
#include "io/ipr_scene.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// The examples that figure A.1 prints.
const std::string figure = R"(!SSF hall.ssf
!DOBJ m.obj
!DOBJ_GRID_INSERT 1
!DOBJ_SCALE 1
!DOBJ_INIT_TRANSLATE 10.5 0.2 4
!DOBJ_INIT_ROTATE 20.0 10 5 1
!DOBJ_ANIM_TRANSLATE 1 0 2
!DOBJ_ANIM_ROTATE 0.01 1 0.2 1
!DOBJ_BEZIER -1 3 0; -0.9 8.5 -6.1;
!DOBJ_BEZIER_SPEED 0.002
!BACKGROUND_COLOR 0 0 0
!SCREEN_RESOLUTION 1024 720
!MAT_EMIS 3 0.2
!LIGHT_MODE AREA
!LIGHT_INIT_TRANSLATE 12 3 11
!LIGHT_INIT_YAW 12.1
!LIGHT_INIT_PITCH -4
!LIGHT_INIT_COLOR 0 0 0
!CAMERA_INIT_TRANSLATE 5 0 1
!CAMERA_INIT_YAW 180
!CAMERA_INIT_PITCH -0.5
!CAMERA_FOV 60
!TONE_MAPPING E
!TONE_MAPPING_GAMMA 1.58
!TONE_MAPPING_EXPOSURE 11.9
!TONE_MAPPING_CONTRAST 2.10
!TONE_MAPPING_DIMMER 0.03
!SCREENSHOT_FOLDER ./screen_shots
!LOD_DISTANCE 0.0 20.0 50.0 100.0
!LOD_SH_DEGREE 7 4 3 1
#Commented line
)";

double setting(const Scene& s, const std::string& table, const std::string& key) {
    for (const Setting& one : s.settings)
        if (one.table == table && one.key == key) return std::get<double>(one.value);
    FAIL(table + "." + key + " is not set");
    return 0;
}

}  // namespace

TEST_CASE("ipr scene: figure A.1 itself becomes a scene", "[io][IPR A.1]") {
    Folder folder;
    folder.put("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n");
    folder.put("m.mtl", "newmtl a\nKd 0.75 0.75 0.75\nnewmtl b\nKd 0.5 0 0\n");
    const std::string toml = ipr_scene_toml("a.scene", figure, "m.obj");
    CAPTURE(toml);
    const Scene s = load_scene(folder.put("s.toml", toml), {"tonemap", "lod"});
    REQUIRE(s.meshes.size() == 2);
    CHECK_FALSE(s.meshes[0].dynamic);
    CHECK(s.meshes[1].dynamic);
    CHECK(s.frame_size == glm::ivec2(1024, 720));
    CHECK(s.camera.position == glm::dvec3(5, 0, 1));
    CHECK(s.camera.fov_y_deg == 60);
    CHECK(s.camera.look_at.z > 1.99);  // yaw 180: along +z
    CHECK(s.materials[3].emission == glm::vec3(0.2f));
    CHECK(s.materials[2].emission == glm::vec3(0));
    REQUIRE(s.lights.size() == 1);
    CHECK(s.lights[0].type == LightType::directional);
    CHECK(s.lights[0].position == glm::vec3(12, 3, 11));
    CHECK(s.lights[0].intensity == glm::vec3(0));
    CHECK(s.lights[0].direction.y < -0.06f);  // pitch -4: down by sin 4 degrees
    for (const auto& [key, value] : {std::pair("gamma", 1.58), {"exposure", 11.9}, {"contrast", 2.1}, {"dimmer", 0.03}})
        CHECK(setting(s, "tonemap", key) == value);
    CHECK(setting(s, "lod", "distance_2") == 50);
    CHECK(setting(s, "lod", "degree_3") == 1);
    // The curve is a straight line of two points, 0.002 of it a frame; its translation comes in place of 0 0 0.
    REQUIRE(s.animation.meshes.size() == 1);
    const Motion& m = s.animation.meshes[0].motion;
    CHECK(m.bezier == std::vector<glm::dvec3>{{-1, 3, 0}, {-0.9, 8.5, -6.1}});
    CHECK(m.speed == 0.002);
    CHECK(m.turn_deg == 0.01);
    const glm::dvec3 moved(scene_at(s, 250).meshes[1].transform[3]);
    CHECK(moved.x == Approx(10.5 - 0.95 + 250).epsilon(1e-12));
    CHECK(moved.y == Approx(0.2 + 5.75).epsilon(1e-12));
    CHECK(moved.z == Approx(4 - 3.05 + 500).epsilon(1e-12));
}

TEST_CASE("ipr scene: what is wrong is named with its line", "[io][IPR A.1][robustness]") {
    const auto error = [](const std::string& text) {
        return error_of([&] { ipr_scene_toml("a.scene", text, "m.obj"); });
    };
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "a.scene: no !SSF, which is required"},
        {"# nothing\n", "a.scene: no !SSF, which is required"},
        {"SSF a\n", "line 1: expected a command, which begins with '!'"},
        {"!SSF\n", "line 1: !SSF: expected a name"},
        {"!SSF a\n!SSF b\n", "line 2: !SSF: is given twice"},
        {"!SFS a\n", "line 1: !SFS: unknown command; the nearest known one is '!SSF'"},
        {"\n!DOBJ_SCALE 1\n", "line 2: !DOBJ_SCALE: stands before any !DOBJ"},
        {"!CAMERA_FOV\n", "line 1: !CAMERA_FOV: expected 1 number, not 0"},
        {"!CAMERA_FOV 1 2\n", "line 1: !CAMERA_FOV: expected 1 number, not 2"},
        {"!CAMERA_FOV wide\n", "line 1: !CAMERA_FOV: wide: expected a finite number"},
        {"!CAMERA_FOV nan\n", "line 1: !CAMERA_FOV: nan: expected a finite number"},
        {"!CAMERA_FOV 1e99\n", "line 1: !CAMERA_FOV: 1e99: expected a finite number"},
        {"!CAMERA_FOV 60\n!CAMERA_FOV 61\n", "line 2: !CAMERA_FOV: is given twice"},
        {"!DOBJ a\n!DOBJ_BEZIER 1 2; 3 4 5;\n", "line 2: !DOBJ_BEZIER: expected 3 numbers, not 2"},
        {"!LIGHT_MODE SUN\n", "line 1: !LIGHT_MODE: expected AREA, FLASH, POINT"},
        {"!TONE_MAPPING\n", "line 1: !TONE_MAPPING: expected E, F, R"},
        {"!MAT_EMIS 1.5 1\n", "line 1: !MAT_EMIS: expected the number of a material, from 0"},
        {"!LOD_DISTANCE 1 2 3 4\n", "line 1: !LOD_DISTANCE: expected 0 for level 0"},
    };
    for (const auto& [text, part] : cases) {
        CAPTURE(text);
        require_message(error(text), {"a.scene", part});
    }
}
