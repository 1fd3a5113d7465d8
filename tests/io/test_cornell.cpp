#include <cmath>
#include <cstring>

#include "core/host_math.h"
#include "files.h"
#include "io/make_scene.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const std::string data = std::string(PLUMB_SOURCE_DIR) + "/data/scenes/";

glm::dvec3 corner(const Scene& s, std::size_t triangle, int k) {
    const Mesh& mesh = s.meshes[0];
    return glm::dvec3(mesh.vertices[mesh.triangles[triangle][k]].position);
}

// Where the ray from `from` along `d` first meets the scene, as a multiple of d; and that triangle (Cramer's rule).
struct Hit {
    double t = 1e30;
    std::size_t triangle = 0;
};
Hit trace(const Scene& s, const glm::dvec3& from, const glm::dvec3& d) {
    Hit hit;
    for (std::size_t i = 0; i < s.meshes[0].triangles.size(); ++i) {
        const glm::dvec3 a = corner(s, i, 0), u = corner(s, i, 1) - a, v = corner(s, i, 2) - a;
        const glm::dmat3 m(u, v, -d);
        const double determinant = glm::determinant(m);
        if (determinant == 0) continue;
        const glm::dvec3 x = glm::inverse(m) * (from - a);
        if (x.x >= 0 && x.y >= 0 && x.x + x.y <= 1 && x.z > 1e-9 && x.z < hit.t) hit = {x.z, i};
    }
    return hit;
}

}  // namespace

TEST_CASE("make_scene: writes the files of data/scenes/cornell, byte for byte", "[io][determinism]") {
    const Folder folder;
    const std::string scene = make_scene("cornell", folder / "new/cornell").file;
    CHECK(scene == folder / "new/cornell/cornell.toml");
    for (const char* name : {"cornell.obj", "cornell.mtl", "cornell.toml"})
        CHECK(read_text(folder / "new/cornell/" + name) == read_text(data + "cornell/" + name));
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "new/cornell"))
        files += entry.is_regular_file();
    CHECK(files == 3);
}

TEST_CASE("make_scene: an unknown name and a folder that cannot be made are one line", "[io][robustness]") {
    const Folder folder;
    require_message(error_of([&] { make_scene("cornel", folder / "a"); }), {"unknown scene \"cornel\"", "\"cornell\""});
    CHECK(folder.files() == 0);
    const std::string file = folder.put("file", "x");
    require_message(error_of([&] { make_scene("cornell", file); }), {file});
}

TEST_CASE("cornell: the room is closed but for its front, and its front sides look inwards", "[io]") {
    const Scene s = load_scene(data + "cornell/cornell.toml", {"rsm", "shadow"});
    CHECK(s.notes.empty());
    REQUIRE(s.meshes.size() == 1);
    // 5 faces of the room, 3 more for the hole in the ceiling, the lamp; 5 faces for each block.
    CHECK(s.meshes[0].triangles.size() == 2 * (5 + 3 + 1 + 10));

    // Rays from under the lamp meet a front side, unless they leave through the front.
    const glm::dvec3 from(0, 1.97, 0);
    int out = 0;
    for (int i = 0; i < 64; ++i)
        for (int j = 1; j < 32; ++j) {
            const double phi = 2 * host::pi * (i + 0.37) / 64, theta = host::pi * j / 32;
            const glm::dvec3 d(host::sin(theta) * host::sin(phi), host::cos(theta), host::sin(theta) * host::cos(phi));
            const Hit hit = trace(s, from, d);
            if (hit.t == 1e30) {
                ++out;
                CHECK(d.z > 0);
                continue;
            }
            const glm::dvec3 a = corner(s, hit.triangle, 0);
            const glm::dvec3 n = glm::cross(corner(s, hit.triangle, 1) - a, corner(s, hit.triangle, 2) - a);
            CHECK(n.x * d.x + n.y * d.y + n.z * d.z < 0);
        }
    CHECK(out > 100);
}

TEST_CASE("cornell: red is on the left, green on the right, the lamp above, the room 2 m high", "[io]") {
    const Scene s = load_scene(data + "cornell/cornell.toml", {"rsm", "shadow"});
    const auto seen = [&](const glm::dvec3& d) {
        return s.materials[std::size_t(s.meshes[0].material[trace(s, {0, 1.5, 0.3}, d).triangle])].name;
    };
    CHECK(seen({-1, 0, 0}) == "red");
    CHECK(seen({1, 0, 0}) == "green");
    CHECK(seen({0, 0, -1}) == "white");
    CHECK(seen({0, 0.5, -0.3}) == "lamp");
    CHECK(trace(s, {0, 1.97, 0}, {0, -1, 0}).t == Approx(1.97).epsilon(1e-6));
    // The light hangs below the lamp, inside the room.
    REQUIRE(s.lights.size() == 1);
    const Hit up = trace(s, glm::dvec3(s.lights[0].position), {0, 1, 0});
    CHECK(up.t == Approx(0.03).epsilon(1e-4));
    CHECK(s.materials[std::size_t(s.meshes[0].material[up.triangle])].name == "lamp");
}

TEST_CASE("cornell: the reflectances are the measured spectra at 650, 510 and 476 nm", "[io]") {
    // Cornell University Program of Computer Graphics, measured reflectances at 648 and 652, 508 and 512, 476 nm.
    const auto rgb = [](double r1, double r2, double g1, double g2, double b) {
        return glm::vec3(float((r1 + r2) / 2), float((g1 + g2) / 2), float(b));
    };
    const std::vector<std::pair<std::string, glm::vec3>> measured = {{"white", rgb(0.729, 0.730, 0.739, 0.732, 0.729)},
                                                                     {"red", rgb(0.612, 0.610, 0.055, 0.056, 0.062)},
                                                                     {"green", rgb(0.117, 0.117, 0.390, 0.435, 0.115)}};
    const Scene s = load_scene(data + "cornell/cornell.toml", {"rsm", "shadow"});
    for (const auto& [name, reflectance] : measured)
        for (const Material& m : s.materials)
            if (m.name == name)
                for (int c = 0; c < 3; ++c) CHECK(m.reflectance[c] == Approx(reflectance[c]).epsilon(1e-6));
    CHECK(s.materials.size() == 4);
}

TEST_CASE("cornell: the small scene is the same room", "[io]") {
    const Scene big = load_scene(data + "cornell/cornell.toml", {"rsm", "shadow"}),
                small = load_scene(data + "cornell_small.toml", {"rsm", "shadow"});
    CHECK(small.frame_size == glm::ivec2(256, 256));
    CHECK(small.camera.position == big.camera.position);
    CHECK(small.meshes[0].triangles == big.meshes[0].triangles);
    // generate = "cornell" is that room too, without a file.
    const Folder folder;
    const Scene generated = load_scene(folder.put("g.toml", "[[mesh]]\ngenerate = \"cornell\"\n"), {"rsm", "shadow"});
    CHECK(generated.meshes[0].triangles == big.meshes[0].triangles);
    CHECK(generated.materials.size() == 4);
}

TEST_CASE("cornell: the lamp of cornell_lamp sends the spot's light into the room, and none elsewhere", "[io]") {
    const Scene spot = load_scene(data + "cornell/cornell.toml", {"rsm", "shadow"}),
                lamp = load_scene(data + "cornell/cornell_lamp.toml", {});
    CHECK(lamp.lights.empty());
    CHECK(lamp.frame_size == glm::ivec2(1024, 768));
    CHECK(lamp.meshes[0].triangles == spot.meshes[0].triangles);

    // Flux of a spot: intensity over the sphere; the smoothstep between the cosines is 1/2 in the mean.
    REQUIRE(spot.lights.size() == 1);
    const auto cosine = [](float degrees) { return host::cos(double(degrees) * host::pi / 180); };
    const double mean = (cosine(spot.lights[0].cone_inner_deg) + cosine(spot.lights[0].cone_outer_deg)) / 2;
    const double flux = 2 * host::pi * double(spot.lights[0].intensity.x) * (1 - mean);
    double sent = 0, ceiling = 0;
    for (std::size_t i = 0; i < lamp.meshes[0].triangles.size(); ++i) {
        const glm::dvec3 a = corner(lamp, i, 0);
        const glm::dvec3 n = glm::cross(corner(lamp, i, 1) - a, corner(lamp, i, 2) - a);
        const double area = std::sqrt(glm::dot(n, n)) / 2;
        const Material& m = lamp.materials[std::size_t(lamp.meshes[0].material[i])];
        sent += area * double(m.emission.x);
        if (a.y > 1.999 && n.y < 0 && n.y * n.y > 0.999 * glm::dot(n, n)) ceiling += area;
    }
    CHECK(sent == Approx(flux).epsilon(1e-4));
    // The lamp fills its hole: together they are the whole ceiling, without a part that lies twice.
    CHECK(ceiling == Approx(2.02624 * 2.0379).epsilon(1e-5));
    // From its back nothing is in sight.
    for (double x : {-0.9, -0.3, 0.0, 0.3, 0.9}) CHECK(trace(lamp, {x / 4, 2, 0.01}, {x, 0.2, 0.1}).t == 1e30);
}

TEST_CASE("cornell: cornell_glossy is the same room, with a glossy and a mirroring block", "[io]") {
    const Scene box = load_scene(data + "cornell/cornell_lamp.toml", {}),
                glossy = load_scene(data + "cornell/cornell_glossy.toml", {});
    const Mesh &a = box.meshes[0], &b = glossy.meshes[0];
    REQUIRE(a.vertices.size() == b.vertices.size());
    CHECK(std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(Vertex)) == 0);
    REQUIRE(a.triangles == b.triangles);
    int blocks = 0;
    for (std::size_t i = 0; i < a.triangles.size(); ++i) {
        const Material &was = box.materials[std::size_t(a.material[i])],
                       &is = glossy.materials[std::size_t(b.material[i])];
        CAPTURE(i, is.name);
        if (is.name == "short_block" || is.name == "tall_block") {
            ++blocks;
            CHECK(was.name == "white");
            CHECK((is.specular != glm::vec3(0)) == (is.name == "short_block"));
            CHECK((is.mirror != glm::vec3(0)) == (is.name == "tall_block"));
        } else {
            CHECK(is.name == was.name);
            CHECK(is.reflectance == was.reflectance);
            CHECK(is.emission == was.emission);
            CHECK((is.specular == glm::vec3(0) && is.mirror == glm::vec3(0)));
        }
    }
    CHECK(blocks == 20);
}

TEST_CASE("cornell: cornell_mirror is the same room, with a floor that mirrors", "[io]") {
    const Scene box = load_scene(data + "cornell/cornell.toml", {"rsm", "shadow", "reflect"}),
                mirror = load_scene(data + "cornell/cornell_mirror.toml", {"rsm", "shadow", "reflect"});
    const Mesh &a = box.meshes[0], &b = mirror.meshes[0];
    REQUIRE(a.vertices.size() == b.vertices.size());
    CHECK(std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(Vertex)) == 0);
    REQUIRE(a.triangles == b.triangles);
    int floor = 0;
    for (std::size_t i = 0; i < a.triangles.size(); ++i) {
        const Material &was = box.materials[std::size_t(a.material[i])], &is = mirror.materials[std::size_t(b.material[i])];
        CAPTURE(i, is.name);
        CHECK((is.mirror != glm::vec3(0)) == (is.name == "floor"));
        CHECK((is.name == was.name) == (is.name != "floor"));
        if (is.name != "floor") continue;
        ++floor;
        for (int k = 0; k < 3; ++k) CHECK(a.vertices[std::size_t(a.triangles[i][k])].position.y == 0);
    }
    CHECK(floor == 2);
}
