// A bare OBJ or glTF without a light: what its camera sees is lit, and what was chosen is said.
#include <catch2/catch.hpp>

#include "core/host_math.h"
#include "io/image_file.h"
#include "tests/io/gltf_files.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

struct Lit {
    int seen = 0, lit = 0;  // pixels with a surface; of these, with direct light
    float least = 1e30f, largest = 0;
    std::string out;
};

Lit rendered(const std::string& scene, const std::string& out) {
    const Result r = render(scene, out, {"--size", "24x24", "--method", "direct"});
    Lit all;
    all.out = r.out;
    const std::string stem = std::filesystem::path(scene).stem().string();
    const compare::Picture picture = io::read_picture(out + "/" + stem + ".exr");
    const compare::Picture albedo = io::select_layer(picture, "albedo", scene), direct = io::select_layer(picture, "direct", scene);
    const std::size_t pixels = std::size_t(picture.width) * std::size_t(picture.height);
    for (std::size_t i = 0; i < pixels; ++i) {
        if (!(albedo.data[i * albedo.channels.size()] > 0)) continue;
        const float light = direct.data[i * direct.channels.size()] / float(host::pi);  // irradiance as white's radiance
        ++all.seen, all.lit += light > 0;
        all.least = std::min(all.least, light), all.largest = std::max(all.largest, light);
    }
    return all;
}

// A cube of side 2 around the origin, and a camera at `position` that looks along `forward`.
std::string cube_seen(const std::string& folder, const glm::dvec3& position, const glm::dvec3& forward) {
    io::GltfSample s;
    std::vector<float> corners;
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) corners.push_back(i >> k & 1 ? 1.0f : -1.0f);
    s.add<float>(corners, 5126, "VEC3", 3);
    s.add<std::uint16_t>({0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5}, 5123, "SCALAR", 1);
    const glm::dvec3 up = std::abs(forward.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0), back = -forward;
    const glm::dvec3 right = glm::cross(up, back), p = position;
    s.json["meshes"] = io::Json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}])");
    s.json["cameras"] = io::Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01, "zfar": 50}}])");
    s.json["nodes"] = {{{"mesh", 0}},
                       {{"camera", 0}, {"matrix", {right.x, right.y, right.z, 0, up.x, up.y, up.z, 0, back.x, back.y, back.z, 0,
                                                   p.x, p.y, p.z, 1}}}};
    s.json["scenes"] = {{{"nodes", {0, 1}}}};
    const std::string path = folder + "/cube.gltf";
    write(path, s.gltf());
    return path;
}

const std::vector<glm::dvec3> sides = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

}  // namespace

TEST_CASE("bare files: whatever side the file's own camera looks from, what faces it is lit", "[program]") {
    const std::string folder = fresh_folder("bare_sides");
    for (const glm::dvec3& side : sides) {
        const Lit l = rendered(cube_seen(folder, side * 4.0, -side), folder + "/out");
        CAPTURE(side.x, side.y, side.z);
        CHECK(l.seen > 24 * 24 / 4);
        CHECK(l.lit == l.seen);
        // White, irradiance pi times the cosine 14/15.
        CHECK(l.least == Approx(14.0 / 15).epsilon(1e-4));
        CHECK(l.largest == Approx(14.0 / 15).epsilon(1e-4));
        CHECK_THAT(l.out, Contains("no light in the file: a directional one from behind the camera"));
    }
}

TEST_CASE("bare files: a closed room seen by a camera inside is lit, and it is said", "[program]") {
    const std::string folder = fresh_folder("bare_room");
    for (const glm::dvec3& side : sides) {
        const Lit l = rendered(cube_seen(folder, {0.25, -0.125, 0.25}, side), folder + "/out");
        CAPTURE(side.x, side.y, side.z);
        CHECK(l.seen == 24 * 24);
        CHECK(l.lit == l.seen);
        // One wall fills the frame: white's radiance is 1 at the middle of its distances.
        CHECK(l.least > 0.6f);
        CHECK(l.least < 1);
        CHECK(l.largest > 1);
        CHECK(l.largest < 1.3f);
        CHECK_THAT(l.out, Contains("the camera stands within the scene, so a point light"));
    }
}

TEST_CASE("bare files: the chosen camera's light reaches walls that face right, left and back", "[program]") {
    const std::string folder = fresh_folder("bare_walls");
    const std::vector<std::string> walls = {
        "v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\n",  // seen from +x: a light from the left alone leaves it black
        "v 0 0 0\nv 1 1 -2\nv 1 2 -2\nv 0 1 0\n", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n"};
    for (const std::string& wall : walls) {
        write(folder + "/wall.obj", wall + "f 1 2 3 4\n");
        const Lit l = rendered(folder + "/wall.obj", folder + "/out");
        INFO(wall << l.out);
        CHECK(l.seen > 0);
        CHECK(l.lit > 0.99 * l.seen);
    }
}

TEST_CASE("bare files: a camera that sees nothing is told", "[program]") {
    const std::string folder = fresh_folder("bare_away");
    const Lit l = rendered(cube_seen(folder, {0, 0, 4}, {0, 0, 1}), folder + "/out");
    CHECK(l.seen == 0);
    CHECK_THAT(l.out, Contains("the camera sees no surface"));
    // Beside one that does.
    CHECK_THAT(rendered(cube_seen(folder, {0, 0, 4}, {0, 0, -1}), folder + "/out").out, !Contains("sees no surface"));
}
