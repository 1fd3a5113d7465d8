// Camera lists: what is written is read again, and what is refused says where and why.
#include <catch2/catch.hpp>

#include "core/error.h"
#include "io/camera_list.h"
#include "io/file.h"
#include "tests/io/files.h"

using namespace plumb;
using Catch::Matchers::Contains;

namespace {

std::string view(const std::string& name, const std::string& more = "", const std::string& place = "[0, 1, 2.5]") {
    return "[[camera]]\nscene = \"box:1200\"\nname = \"" + name + "\"\nposition = " + place +
           "\nlook_at = [0, 1, 0]\n" + more;
}

std::string refusal(const std::string& text) {
    const io::Folder folder;
    const std::string path = folder.put("camera_list.toml", text);
    try {
        io::read_camera_list(path);
    } catch (const InputError& e) {
        CHECK(std::string(e.what()).find('\n') == std::string::npos);
        CHECK_THAT(e.what(), Contains("camera_list.toml"));
        return e.what();
    }
    FAIL("it was read: " << text);
    return "";
}

}  // namespace

TEST_CASE("camera list: what is written is read to the last bit", "[io]") {
    io::CameraList list;
    list.comment = "made by hand\nin two lines";
    io::ListedCamera a, b;
    a.scene = "../scenes/cornell/cornell.toml", a.name = "a-1";
    a.position = {1.0 / 3, -2e-7, 12345.678}, a.look_at = {0.1, 0.2, 0.3}, a.up = {0, 0.6, 0.8}, a.fov_y_deg = 44.1;
    b = a, b.name = "b", b.exposure = 1.0 / 7, b.frame = 12;
    list.cameras = {a, b};
    const io::Folder folder;
    const io::CameraList read = io::read_camera_list(folder.put("camera_list.toml", io::camera_list_text(list)));
    REQUIRE(read.cameras.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
        const io::ListedCamera &was = list.cameras[i], &is = read.cameras[i];
        CHECK(is.scene == was.scene);
        CHECK(is.name == was.name);
        CHECK(is.position == was.position);
        CHECK(is.look_at == was.look_at);
        CHECK(is.up == was.up);
        CHECK(is.fov_y_deg == was.fov_y_deg);
        CHECK(is.exposure == was.exposure);
        CHECK(is.frame == was.frame);
    }
}

TEST_CASE("camera list: what is wrong is refused by its line", "[io]") {
    CHECK_THAT(refusal(""), Contains("no [[camera]]"));
    CHECK_THAT(refusal("[camera]\nname = \"a\"\n"), Contains("[[camera]]"));
    CHECK_THAT(refusal(view("a") + view("a")), Contains("line 8") && Contains("another view has that name"));
    CHECK_THAT(refusal(view("a b")), Contains("line 3") && Contains("letters, digits"));
    CHECK_THAT(refusal(view("../a")), Contains("letters, digits"));
    CHECK_THAT(refusal(view("a", "fov = 3\n")), Contains("line 6") && Contains("fov"));
    CHECK_THAT(refusal(view("a", "fov_y_deg = 180\n")), Contains("fov_y_deg"));
    CHECK_THAT(refusal(view("a", "exposure = 0\n")), Contains("exposure"));
    CHECK_THAT(refusal(view("a", "exposure = nan\n")), Contains("exposure"));
    CHECK_THAT(refusal(view("a", "frame = -1\n")), Contains("frame"));
    CHECK_THAT(refusal(view("a", "up = [0, 0, 1]\n", "[0, 1, 2]")), Contains("up"));
    CHECK_THAT(refusal(view("a", "", "[0, 1]")), Contains("position"));
    CHECK_THAT(refusal(view("a", "", "[0, 1, inf]")), Contains("position"));
    CHECK_THAT(refusal(view("a", "", "[0, 1, 0]")), Contains("look_at"));  // where it looks at
    CHECK_THAT(refusal("[[camera]]\nscene = \"box\"\nname = \"a\"\nlook_at = [0, 0, 0]\n"),
               Contains("position") && Contains("missing"));
    CHECK_THAT(refusal("[[camera]]\nname = \"a\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n"),
               Contains("scene") && Contains("missing"));
}

TEST_CASE("camera list: a word for a scene is a file or a generated scene", "[io]") {
    CHECK(io::is_scene_file("../scenes/box/box.toml"));
    CHECK_FALSE(io::is_scene_file("rooms:20000:1"));
    const Scene box = io::load_listed_scene("list.toml", "box:1200", {});
    CHECK(flatten(box).triangles.size() == 1200);
    auto load = [](const std::string& word) { return io::load_listed_scene("list.toml", word, {}); };
    CHECK_THROWS_WITH(load("bax"), Contains("box"));
    CHECK_THROWS_WITH(load("box:many"), Contains("triangles") && Contains("many"));
    CHECK_THROWS_WITH(load("box:1200:1:1"), Contains("NAME:TRIANGLES:SEED"));
    CHECK_THROWS_WITH(load("box:1200:-1"), Contains("seed"));

    io::ListedCamera listed;
    listed.position = {0, 1, 0.5}, listed.look_at = {0, 1, -1}, listed.fov_y_deg = 33;
    const Scene posed = io::scene_of({}, listed, box);
    CHECK(posed.camera.position == listed.position);
    CHECK(posed.camera.fov_y_deg == 33);
    CHECK(posed.camera.near == box.camera.near);
    CHECK(posed.camera.far == box.camera.far);
}
