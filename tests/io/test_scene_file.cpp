#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "core/content_hash.h"
#include "files.h"
#include "io/image_file.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const std::vector<std::string> method_tables = {"rsm", "shadow", "tonemap"};
const std::string obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl white\nf 1 2 3\nusemtl red\nf 1 2 3\n";
const std::string mtl = "newmtl white\nKd 0.75 0.75 0.75\nnewmtl red\nKd 0.5 0 0\n";

struct Files {
    Folder folder;
    Files() {
        folder.put("m.obj", obj);
        folder.put("m.mtl", mtl);
        folder.put("shiny.obj", "mtllib shiny.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl s\nf 1 2 3\n");
        folder.put("shiny.mtl", "newmtl s\nKd 0.5\nKs 0.5\nNs 20\nillum 2\nnewmtl bright\nKd 1\nKs 1\nillum 2\n");
        folder.put("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n");
        const std::uint8_t pixels[] = {1, 2, 3};
        write_png(folder / "t.png", 1, 1, pixels);
    }
    Scene load(const std::string& text) const { return load_scene(folder.put("s.toml", text), method_tables); }
    std::string error(const std::string& text) const {
        return error_of([&] { load(text); });
    }
};

// Where the first mesh puts a point of its own.
glm::dvec3 moved(const Scene& scene, const glm::dvec3& p) {
    return glm::dvec3(scene.meshes.at(0).transform * glm::dvec4(p, 1));
}

}  // namespace

TEST_CASE("scene: every key of the contract arrives", "[io]") {
    const Files files;
    const Scene s = files.load(R"(
convention = "opengl"
reversed_z = true
photometric = "as_is"
seed = 4294967295
[frame]
size = [320, 200]
[camera]
position = [0, 1, 3.4]
look_at = [0, 1, 0]
up = [0, 2, 0]
fov_y_deg = 39.3
near = 0.25
far = inf
[[mesh]]
file = "m.obj"
translate = [1, 2, 3]
dynamic = true
share = 0.5
[[material]]
name = "white"
reflectance = [0.1, 0.2, 0.3]
emission = [1, 2, 3]
specular = [0.25, 0.5, 0.125]
exponent = 1000000
mirror = 0.125
[[light]]
name = "key"
type = "spot"
position = [0, 1.9, 0]
direction = [0, -2, 0]
cone_deg = [40, 45]
intensity = [10, 20, 30]
on = false
rsm_size = 256
[[light]]
type = "directional"
[[light]]
type = "point"
radius = 2.5
[environment]
radiance = [0.1, 0, 0]
[render]
method = "direct"
layout = "rgba16f"
[tonemap]
exposure = 2
[rsm]
gather = "all"
samples = 400
flag = true
axis = [1, 2, 3]
)");
    CHECK(s.convention == Convention::opengl);
    CHECK(s.seed == 4294967295u);
    CHECK(s.frame_size == glm::ivec2(320, 200));
    CHECK(s.camera.position == glm::dvec3(0, 1, 3.4));
    CHECK(s.camera.look_at == glm::dvec3(0, 1, 0));
    CHECK(s.camera.up == glm::dvec3(0, 2, 0));
    CHECK(s.camera.fov_y_deg == 39.3);
    CHECK(s.camera.near == 0.25);
    CHECK(std::isinf(s.camera.far));
    CHECK(s.camera.reversed_z);
    REQUIRE(s.meshes.size() == 1);
    CHECK(s.meshes[0].dynamic);
    CHECK(s.meshes[0].share == 0.5);
    CHECK(moved(s, {0, 0, 0}) == glm::dvec3(1, 2, 3));
    REQUIRE(s.materials.size() == 2);
    CHECK(s.materials[0].reflectance == glm::vec3(0.1f, 0.2f, 0.3f));
    CHECK(s.materials[0].emission == glm::vec3(1, 2, 3));
    CHECK(s.materials[0].specular == glm::vec3(0.25f, 0.5f, 0.125f));
    CHECK(s.materials[0].exponent == 1e6f);
    CHECK(s.materials[0].mirror == glm::vec3(0.125f));
    CHECK((s.materials[1].specular == glm::vec3(0) && s.materials[1].mirror == glm::vec3(0)));
    CHECK(s.materials[1].reflectance == glm::vec3(0.5f, 0, 0));  // the file's own
    REQUIRE(s.lights.size() == 3);
    CHECK(s.lights[0].name == "key");
    CHECK(s.lights[0].type == LightType::spot);
    CHECK(s.lights[0].direction == glm::vec3(0, -1, 0));
    CHECK(s.lights[0].cone_outer_deg == 45);
    CHECK(s.lights[0].intensity == glm::vec3(10, 20, 30));
    CHECK(!s.lights[0].on);
    CHECK(s.lights[0].rsm_size == 256);
    CHECK(s.lights[1].type == LightType::directional);
    CHECK(s.lights[1].name == "light1");
    CHECK(s.lights[2].type == LightType::point);
    CHECK((s.lights[0].radius == 0 && s.lights[2].radius == 2.5f));
    CHECK(s.environment.radiance == glm::vec3(0.1f, 0, 0));
    CHECK(s.method == "direct");
    CHECK(s.layout == "rgba16f");
    // By table, and within a table as the file has them.
    REQUIRE(s.settings.size() == 5);
    CHECK(s.settings[0].table == "rsm");
    CHECK(std::get<std::string>(s.settings[0].value) == "all");
    CHECK(std::get<double>(s.settings[1].value) == 400);
    CHECK(s.settings[1].place == files.folder / "s.toml" + ": line 50");
    CHECK(std::get<bool>(s.settings[2].value));
    CHECK(std::get<glm::vec3>(s.settings[3].value) == glm::vec3(1, 2, 3));
    CHECK(s.settings[4].table == "tonemap");
    CHECK(s.notes.empty());
}

TEST_CASE("scene: rotations are right-handed, yaw about y, pitch about x, roll about z", "[io]") {
    const Files files;
    const auto rotated = [&](const std::string& degrees, const glm::dvec3& p) {
        return moved(files.load("[[mesh]]\nfile = \"m.obj\"\nrotate_deg = " + degrees + "\n"), p);
    };
    // Right angles are exact.
    CHECK(rotated("[90, 0, 0]", {0, 0, 1}) == glm::dvec3(1, 0, 0));
    CHECK(rotated("[0, 90, 0]", {0, 1, 0}) == glm::dvec3(0, 0, 1));
    CHECK(rotated("[0, 0, -270]", {1, 0, 0}) == glm::dvec3(0, 1, 0));
    CHECK(rotated("[180, 0, 0]", {1, 0, 0}) == glm::dvec3(-1, 0, 0));
    // The object rolls first, turns last.
    CHECK(rotated("[90, 0, 90]", {0, -1, 0}) == glm::dvec3(0, 0, -1));
    CHECK(rotated("[30, 0, 0]", {0, 0, 1}).x == Approx(0.5).epsilon(1e-15));
}

TEST_CASE("scene: scale comes before rotation before translation; a matrix is row-major", "[io]") {
    const Files files;
    const auto load = [&](const std::string& keys) { return files.load("[[mesh]]\nfile = \"m.obj\"\n" + keys); };
    CHECK(moved(load("scale = 2\ntranslate = [1, 0, 0]\nrotate_deg = [90, 0, 0]\n"), {0, 0, 1}) == glm::dvec3(3, 0, 0));
    CHECK(moved(load("scale = [1, 2, -3]\n"), {1, 1, 1}) == glm::dvec3(1, 2, -3));
    CHECK(moved(load("matrix = [1,0,0,5, 0,2,0,6, 0,0,3,7, 0,0,0,1]\n"), {1, 1, 1}) == glm::dvec3(6, 8, 10));
}

TEST_CASE("scene: an OBJ without MTL takes a material and a texture from the scene", "[io]") {
    const Files files;
    const Scene s = files.load(
        "[[mesh]]\nfile = \"plain.obj\"\nmaterial = \"cow\"\n"
        "[[material]]\nname = \"cow\"\ntexture = \"t.png\"\nfilter = \"nearest\"\n");
    REQUIRE(s.textures.size() == 1);
    CHECK(s.textures[0].filter == Filter::nearest);
    const Material& m = s.materials.at(std::size_t(s.meshes[0].material[0]));
    CHECK(m.name == "cow");
    CHECK(m.texture == 0);
    CHECK(m.reflectance == glm::vec3(1));
    // Of a material that the file has, the reflectance stays and the texture multiplies it.
    const Scene t = files.load("[[mesh]]\nfile = \"m.obj\"\n[[material]]\nname = \"red\"\ntexture = \"t.png\"\n");
    CHECK(t.materials[1].reflectance == glm::vec3(0.5f, 0, 0));
    CHECK(t.materials[1].texture == 0);
    REQUIRE(t.notes.size() == 3);
    CHECK_THAT(t.notes[0], Catch::Contains("\"m\" has no texture coordinates"));
}

TEST_CASE("scene: one number is grey; an MTL's Ks stays until a key changes it", "[io]") {
    const Files files;
    const Scene s = files.load(
        "[[mesh]]\nfile = \"shiny.obj\"\n[[material]]\nname = \"s\"\nreflectance = 0.25\nemission = 3\n"
        "mirror = 0.25\n[environment]\nradiance = 0.5\n");
    CHECK(s.materials[0].reflectance == glm::vec3(0.25f));
    CHECK(s.materials[0].emission == glm::vec3(3));
    CHECK(s.materials[0].specular == glm::vec3(0.5f));
    CHECK(s.materials[0].exponent == 20);
    CHECK(s.materials[0].mirror == glm::vec3(0.25f));
    CHECK(s.environment.radiance == glm::vec3(0.5f));
    CHECK(s.environment.map.empty());
    // What the MTL's reader changed is said, with the file that asked for it.
    REQUIRE(s.notes.size() == 3);
    CHECK_THAT(s.notes[0], Catch::StartsWith("\"shiny.obj\": "));
    CHECK_THAT(s.notes[0], Catch::Contains("shiny.mtl: Kd + Ks is above 1 in 1 of 2"));
    // A sum of 1 that floats round up is no excess.
    CHECK(files.error("[[mesh]]\nfile = \"m.obj\"\n[[material]]\nname = \"red\"\nreflectance = 0.8\n"
                      "specular = 0.2\n") == "");
}

TEST_CASE("scene: metalness and roughness make microfacets, a lobe or a mirror takes them away", "[io][microfacet]") {
    const Files files;
    auto red = [&](const std::string& keys) { return files.load("[[mesh]]\nfile = \"m.obj\"\n[[material]]\nname = \"red\"\n" + keys).materials; };
    auto one = [&](const std::string& keys) {
        for (const Material& m : red(keys))
            if (m.name == "red") return m;
        throw std::runtime_error("no red");
    };
    CHECK(!one("reflectance = 0.5\n").microfacet);
    const Material rough = one("roughness = 0.25\n");
    CHECK((rough.microfacet && rough.roughness == 0.25f && rough.metalness == 0));
    const Material metal = one("metalness = 1\n");
    CHECK((metal.microfacet && metal.roughness == 1 && metal.metalness == 1));
    CHECK(one("microfacet = true\n").microfacet);
    CHECK(!one("roughness = 0.5\nmicrofacet = false\n").microfacet);
    CHECK(!one("mirror = 0.5\nreflectance = 0.5\n").microfacet);
    for (const std::string wrong : {"roughness = 0.5\nmirror = 0.1\nreflectance = 0.1\n", "metalness = 2\n", "roughness = -1\n"})
        CHECK(files.error("[[mesh]]\nfile = \"m.obj\"\n[[material]]\nname = \"red\"\n" + wrong) != "");
}

TEST_CASE("scene: two meshes keep their materials apart", "[io]") {
    const Files files;
    const Scene s = files.load(
        "[[mesh]]\nfile = \"m.obj\"\n[[mesh]]\ngenerate = \"cornell\"\n[[mesh]]\nfile = \"m.obj\"\n"
        "[[material]]\nname = \"white\"\nreflectance = [0.1, 0.1, 0.1]\n");
    REQUIRE(s.meshes.size() == 3);
    CHECK(s.materials[std::size_t(s.meshes[2].material[1])].name == "red");
    CHECK(s.materials[std::size_t(s.meshes[2].material[1])].reflectance == glm::vec3(0.5f, 0, 0));
    int white = 0;
    for (const Material& m : s.materials) white += m.name == "white" && m.reflectance == glm::vec3(0.1f);
    CHECK(white == 3);
}

TEST_CASE("scene: a bare OBJ gets a camera that sees all of it, and a light, and says so", "[io]") {
    const Files files;
    const Scene s = load_scene(files.folder / "m.obj", method_tables);
    REQUIRE(s.notes.size() == 2);
    CHECK_THAT(s.notes[0], Catch::Contains("no camera"));
    CHECK_THAT(s.notes[1], Catch::Contains("no light"));
    REQUIRE(s.lights.size() == 1);
    const View view = make_view(s.camera, 1);
    for (const Vertex& v : s.meshes[0].vertices) {
        const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(glm::dvec3(v.position), 1);
        CHECK(std::fabs(clip.x) < clip.w);
        CHECK(std::fabs(clip.y) < clip.w);
        CHECK(clip.z > 0);
        CHECK(clip.z < clip.w);
    }
}

TEST_CASE("scene: malformed files are named with line and cause", "[io][robustness]") {
    const Files files;
    const std::string mesh = "[[mesh]]\nfile = \"m.obj\"\n", light = "[[light]]\nname = \"a\"\n";
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"sed = 1\n", "line 1: unknown key 'sed'; the nearest known one is 'seed'"},
        {"\n[rms]\nsamples = 1\n", "line 2: unknown key 'rms'; the nearest known one is 'rsm'"},
        {"[camera]\nfov_deg = 40\n", "line 2: [camera] unknown key 'fov_deg'; the nearest known one is 'fov_y_deg'"},
        {"[[light]]\nintensty = [1,1,1]\n",
         "line 2: [[light]] unknown key 'intensty'; the nearest known one is 'intensity'"},
        {mesh + "rotate = [1,1,1]\n", "line 3: [[mesh]] unknown key 'rotate'; the nearest known one is 'rotate_deg'"},
        {"[frame\n", "line 1: "},
        {"a = = 1\n", "line 1: "},
        {"seed = 1\nseed = 2\n", "line 2: "},
        {"\xff\xfe\n", "line 1: "},
        {"convention = \"metal\"\n", "line 1: convention \"metal\" is unknown; expected one of vulkan"},
        {"convention = 3\n", "line 1: convention = 3: expected a string"},
        {"reversed_z = \"yes\"\n", "line 1: reversed_z = \"yes\": expected true or false"},
        {"photometric = \"lumen\"\n", "line 1: photometric = \"lumen\": expected one of watt, as_is"},
        {"seed = -1\n", "line 1: seed = -1: expected 0 to 4294967295"},
        {"seed = 1.5\n", "line 1: seed = 1.5: expected an integer"},
        {"frame = 3\n", "line 1: frame = 3: expected a table, [frame]"},
        {"[mesh]\nfile = \"m.obj\"\n", "line 1: mesh = a table: expected a list of tables, [[mesh]]"},
        {"mesh = [1]\n", "line 1: mesh = an array of 1: expected a list of tables"},
        {"[frame]\nsize = [0, 10]\n", "line 2: [frame] size holds 0: expected 1 to 32767"},
        {"[frame]\nsize = [10]\n", "line 2: [frame] size = an array of 1: expected 2 numbers"},
        {"[frame]\nsize = [1.5, 2]\n", "line 2: [frame] size = an array of 2: expected two integers"},
        {"[frame]\nsize = [32767, 32767]\n", "line 2: [frame] size = an array of 2: more than 2^28 pixels"},
        {"[camera]\nposition = [0, 0, 0]\n", "line 1: [camera] look_at: is missing"},
        {"[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 0]\n", "line 1: camera: look_at = [0, 0, 0]: must be"},
        {"[camera]\nposition = [0, nan, 0]\nlook_at = [0, 0, 1]\n",
         "line 2: [camera] position holds nan: expected a finite number"},
        {"[camera]\nnear = 0\n", "line 1: camera: near = 0: must be above 0 m and finite"},
        {"[camera]\nnear = inf\n", "line 1: camera: near = inf: must be"},
        {"[camera]\nfov_y_deg = 180\n", "line 1: camera: fov_y_deg = 180: must be"},
        {"[camera]\nnear = \"far\"\n", "line 2: [camera] near = \"far\": expected a number"},
        {"[[mesh]]\n", "line 1: [[mesh]] file: expected either file or generate"},
        {mesh + "generate = \"cornell\"\n", "line 2: [[mesh]] file = \"m.obj\": expected either file or generate"},
        {"[[mesh]]\ngenerate = \"cornel\"\n", "line 2: [[mesh]] generate = \"cornel\": expected one of cornell"},
        {"[[mesh]]\nfile = \"none.obj\"\n", "none.obj: cannot be read: No such file or directory ("},
        {"[[mesh]]\nfile = \"t.png\"\n", "t.png: not a mesh by its name; expected .obj"},
        {"[[mesh]]\nfile = \"a.glb\"\n", "a.glb: cannot be read: No such file or directory ("},
        {mesh + "scale = 0\n", "line 3: [[mesh]] scale = 0: expected a size"},
        {mesh + "scale = [1, 2]\n", "line 3: [[mesh]] scale = an array of 2: expected 3 numbers"},
        {mesh + "share = 1.5\n", "line 3: [[mesh]] share = 1.5: expected 0 to 1"},
        {mesh + "matrix = [1]\n", "line 3: [[mesh]] matrix = an array of 1: expected 16 numbers"},
        {mesh + "matrix = [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1]\n",
         "line 3: [[mesh]] matrix = an array of 16: cannot be inverted"},
        {mesh + "matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1]\n", "expected 0, 0, 0, 1 in the last row"},
        {mesh + "matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nscale = 2\n",
         "line 4: [[mesh]] scale = 2: stands beside matrix"},
        {mesh + "material = \"wite\"\n",
         "line 3: [[mesh]] material = \"wite\": no [[material]] and no file has that name; the nearest known one is "
         "\"white\""},
        {mesh + "[[material]]\nname = \"wite\"\n",
         "line 4: [[material]] name = \"wite\": no file and no [[mesh]] has a material of that name; the nearest known "
         "one is \"white\""},
        {mesh + "[[material]]\nreflectance = [1,1,1]\n", "line 3: [[material]] name: expected the name of a material"},
        {mesh + "[[material]]\nname = \"red\"\nreflectance = [1, 1.5, 1]\n",
         "line 5: [[material]] reflectance holds 1.5: expected 0 to 1"},
        {mesh + "[[material]]\nname = \"red\"\nemission = [1, -1, 1]\n",
         "line 5: [[material]] emission holds -1: expected 0 to"},
        {mesh + "[[material]]\nname = \"red\"\ntexture = \"none.png\"\n",
         "line 5: [[material]] texture = \"none.png\": "},
        {mesh + "[[material]]\nname = \"red\"\nfilter = \"nearest\"\n",
         "line 5: [[material]] filter = \"nearest\": stands without a texture"},
        {light + "type = \"area\"\n", "line 3: [[light]] type = \"area\": expected one of spot, point, directional"},
        {light + "direction = [0, 0, 0]\n", "line 3: [[light]] direction = an array of 3: has no length"},
        {light + "cone_deg = [50, 45]\n",
         "line 3: [[light]] cone_deg = an array of 2: expected 0 <= inner <= outer <= 89"},
        {light + "cone_deg = [50, 95]\n", "line 3: [[light]] cone_deg holds 95: expected 0 to 89"},
        {light + "intensity = [1, -1, 1]\n", "line 3: [[light]] intensity holds -1"},
        {light + "intensity = [1, inf, 1]\n", "line 3: [[light]] intensity holds inf"},
        {light + "rsm_size = 0\n", "line 3: [[light]] rsm_size = 0: expected 1 to 16384"},
        {light + "radius = -1\n", "line 3: [[light]] radius = -1: expected 0 to"},
        {light + "radius = nan\n", "line 3: [[light]] radius = nan: expected"},
        {light + "radius = 1e-9\n", "line 3: [[light]] radius = 1e-09: expected 0, or 1e-06 m or more"},
        {light + "type = \"directional\"\nradius = 2\n", "line 4: [[light]] radius = 2: a directional light has no distance"},
        {light + "rsm_size = 1.0\n", "line 3: [[light]] rsm_size = 1: expected an integer"},
        {light + light, "line 4: [[light]] name = \"a\": another light has that name"},
        {"[[light]]\nname = \"a.b\"\n", "line 2: [[light]] name = \"a.b\": expected 1 to 64 letters"},
        {mesh + "[[material]]\nname = \"red\"\nreflectance = \"red\"\n",
         "line 5: [[material]] reflectance = \"red\": expected a number or three"},
        {mesh + "[[material]]\nname = \"red\"\nspeculr = 0.5\n",
         "line 5: [[material]] unknown key 'speculr'; the nearest known one is 'specular'"},
        {mesh + "[[material]]\nname = \"red\"\nspecular = 1.5\n",
         "line 5: [[material]] specular = 1.5: expected 0 to 1"},
        {mesh + "[[material]]\nname = \"red\"\nmirror = [0, -0.5, 0]\n",
         "line 5: [[material]] mirror holds -0.5: expected 0 to 1"},
        {mesh + "[[material]]\nname = \"red\"\nmirror = nan\n", "line 5: [[material]] mirror = nan: expected 0 to 1"},
        {mesh + "[[material]]\nname = \"red\"\nexponent = -1\n",
         "line 5: [[material]] exponent = -1: expected 0 to 1000000"},
        {mesh + "[[material]]\nname = \"red\"\nexponent = 1e7\n",
         "line 5: [[material]] exponent = 10000000: expected 0 to 1000000"},
        {mesh + "[[material]]\nname = \"red\"\nexponent = [1, 1, 1]\n",
         "line 5: [[material]] exponent = an array of 3: expected a number"},
        // Each part alone is fine; together they are not, in the channel that is named.
        {mesh + "[[material]]\nname = \"red\"\nspecular = [0.5, 1, 0]\nmirror = [0.125, 0, 0]\n",
         "line 6: [[material]] mirror = an array of 3: material \"red\" reflects more than it receives: reflectance "
         "0.5 + specular 0.5 + mirror 0.125 in red; expected a sum of at most 1"},
        {mesh + "[[material]]\nname = \"red\"\nspecular = [0, 0, 0.75]\nreflectance = [0.5, 0.5, 0.5]\n",
         "line 5: [[material]] specular = an array of 3: material \"red\" reflects more than it receives: reflectance "
         "0.5 + specular 0.75 + mirror 0 in blue"},
        {"[[mesh]]\nfile = \"shiny.obj\"\n[[material]]\nname = \"s\"\nreflectance = 0.75\n",
         "line 5: [[material]] reflectance = 0.75: material \"s\" reflects more than it receives: reflectance 0.75 + "
         "specular 0.5 + mirror 0 in red"},
        {"[environment]\nfile = \"none.exr\"\n", "line 2: [environment] file = \"none.exr\": "},
        {"[environment]\nfile = \"t.png\"\n", "t.png: holds no radiance by its name; expected .exr, .hdr or .pfm"},
        {"[environment]\nfile = 1\n", "line 2: [environment] file = 1: expected a string"},
        {"[environment]\nradiance = -1\n", "line 2: [environment] radiance = -1: expected 0 to"},
        {"[environment]\nradience = 1\n",
         "line 2: [environment] unknown key 'radience'; the nearest known one is 'radiance'"},
        {"[rsm]\nsamples = [1, 2]\n", "line 2: [rsm] samples = an array of 2: expected 3 numbers"},
        {"[rsm]\nsamples = 1979-05-27\n", "line 2: [rsm] samples = a date or time: expected a number, a string"},
        {"[rsm.samples]\na = 1\n", "line 1: [rsm] samples = a table: expected a number, a string"},
    };
    for (const auto& [text, message] : cases) {
        CAPTURE(text);
        require_message(files.error(text), {"s.toml", message});
    }
    require_message(error_of([&] { load_scene(files.folder / "none.toml", {}); }),
                    {"none.toml: cannot be read: No such file"});
    require_message(error_of([&] { load_scene(files.folder / "a.gltf", {}); }),
                    {"a.gltf: cannot be read: No such file"});
    require_message(error_of([&] { load_scene(files.folder / "t.png", {}); }), {"t.png: not a scene by its name"});
    require_message(files.error("[[mesh]]\nfile = \"bad.obj\"\n"), {"bad.obj: cannot be read"});
    files.folder.put("bad.obj", "v 0 0\n");
    require_message(files.error("[[mesh]]\nfile = \"bad.obj\"\n"),
                    {"bad.obj: line 1: v has 2 numbers; expected 3 (", "s.toml: line 2 names it)"});
}

TEST_CASE("scene: deep nesting is refused before it can exhaust the stack", "[io][robustness]") {
    const Files files;
    const auto repeated = [](const std::string& s, int n) {
        std::string text;
        for (int i = 0; i < n; ++i) text += s;
        return text;
    };
    for (int n : {17, 200000}) {
        const std::vector<std::string> deep = {"a = " + repeated("[", n),
                                               "a = " + repeated("{a=", n),
                                               "a" + repeated(".a", n) + " = 1\n",
                                               "[a" + repeated(".a", n) + "]\n",
                                               "\"#\"" + repeated(".a", n) + " = 1\n",
                                               "b = '''\n\"\n'''\na" + repeated(" . a", n) + " = 1\n",
                                               "b = \"\\\"\"\na" + repeated(".'a'", n) + " = 1\n"};
        for (const std::string& text : deep)
            require_message(files.error(text), {"s.toml: line ", "nested deeper than 16"});
    }
    // Dots in comments, strings and numbers are none of that.
    CHECK(files.error("# " + repeated(".", 100) + "\nseed = 1 # ....................\n[[mesh]]\nfile = \"" +
                      repeated("./", 50) + "m.obj\"\n[frame]\nsize = [\n1,\n2]\n") == "");
}

TEST_CASE("scene: cut off or changed at any byte, it loads or is refused", "[io][robustness]") {
    const Files files;
    const std::string text =
        "seed = 1\n[[mesh]]\nfile = \"m.obj\"\nscale = 2.5\n[[material]]\nname = \"red\"\n"
        "[[light]]\ntype = \"spot\"\ncone_deg = [1, 2]\n[rsm]\nsamples = 4\n[environment]\nfile = \"s.pfm\"\n"
        "radiance = 2\n";
    files.folder.put("s.pfm", "Pf\n2 1\n-1\n" + std::string(8, '\0'));
    REQUIRE(files.error(text) == "");
    load_damaged(files.folder, "s.toml", text, [](const std::string& path) { load_scene(path, method_tables); });
}

TEST_CASE("scene: a real textured model, without MTL", "[io][assets]") {
    const char* assets = std::getenv("PLUMB_ASSETS");
    if (!assets) {
        WARN("PLUMB_ASSETS is not set: skipped");
        return;
    }
    const Files files;
    const std::string folder = std::string(assets) + "/obj/";
    const Scene s =
        files.load("[[mesh]]\nfile = \"" + folder + "spot.obj\"\nmaterial = \"spot\"\n[[material]]\nname = \"spot\"\n" +
                   "texture = \"" + folder + "spot.png\"\n");
    CHECK(s.meshes[0].triangles.size() == 5856);
    REQUIRE(s.textures.size() == 1);
    CHECK(s.textures[0].texels.width > 100);
    for (const Vertex& v : s.meshes[0].vertices) {
        const float length = std::sqrt(v.normal.x * v.normal.x + v.normal.y * v.normal.y + v.normal.z * v.normal.z);
        REQUIRE(length == Approx(1).epsilon(1e-6));
        REQUIRE((v.u >= -0.1f && v.u <= 1.1f && v.v >= -0.1f && v.v <= 1.1f));
    }
}
