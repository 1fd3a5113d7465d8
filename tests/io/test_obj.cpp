#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "files.h"
#include "io/image_file.h"
#include "io/obj.h"
#include "io/triangulate.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

ObjModel parse(const std::string& text, const std::string& library = "", bool strict = false) {
    const auto read = [&](const std::string& name, auto&&...) {
        return library.empty() ? std::nullopt : std::optional(Library{name, library});
    };
    return parse_obj("m.obj", text, read, strict);
}

// Of an MTL alone.
ObjModel parse_library(const std::string& library, bool strict = false) {
    return parse("mtllib m.mtl\n" + triangle + "f 1 2 3\n", library, strict);
}

// Twice the area of a mesh's triangles in the plane z = 0, signed.
double area_z(const Mesh& mesh) {
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.vertices[t.x].position), b(mesh.vertices[t.y].position), c(mesh.vertices[t.z].position);
        sum += (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    }
    return sum;
}

std::string polygon(const std::vector<glm::dvec2>& points) {
    std::string text, face = "f";
    for (std::size_t i = 0; i < points.size(); ++i) {
        text += fmt::format("v {} {} 0\n", points[i].x, points[i].y);
        face += fmt::format(" {}", i + 1);
    }
    return text + face + "\n";
}

}  // namespace

TEST_CASE("obj: indices count from one, or back from the last", "[io]") {
    for (const char* face : {"f 1 2 3\n", "f -3 -2 -1\n", "f 1 -2 3 # comment\n", "f\t1  2\t3 \r\n"}) {
        const ObjModel model = parse(triangle + face);
        REQUIRE(model.mesh.triangles.size() == 1);
        const glm::uvec3 t = model.mesh.triangles[0];
        CHECK(model.mesh.vertices[t.y].position == glm::vec3(1, 0, 0));
        CHECK(model.mesh.vertices[t.z].position == glm::vec3(0, 1, 0));
        CHECK(model.mesh.vertices[t.x].normal == glm::vec3(0, 0, 1));
        CHECK(model.materials.at(0).name == "default");
    }
    // A face may stand before its vertices.
    CHECK(parse("f 1 2 3\n" + triangle).mesh.triangles.size() == 1);
    // A backslash goes on in the next line.
    CHECK(parse(triangle + "f 1 \\\n2 \\\n3\n").mesh.triangles.size() == 1);
}

TEST_CASE("obj: numbers are the nearest floats", "[io]") {
    const ObjModel model = parse("v 0.1 +1e-3 -2.5E2\nv 1e-60 -1e-400 16777217\nv 0 1 0\nf 1 2 3\n");
    CHECK(model.mesh.vertices[0].position == glm::vec3(0.1f, 1e-3f, -250.0f));
    CHECK(model.mesh.vertices[1].position == glm::vec3(0, 0, 16777216));
}

TEST_CASE("obj: v is turned to count from the top of the picture", "[io]") {
    const ObjModel model = parse(triangle + "vt 0.25 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    CHECK(model.has_texture_coordinates);
    CHECK(model.mesh.vertices[0].u == 0.25f);
    CHECK(model.mesh.vertices[0].v == 0.75f);
    CHECK(model.mesh.vertices[2].v == 0.0f);
}

TEST_CASE("obj: normals are made unit; a missing or zero one is the triangle's", "[io]") {
    const ObjModel model = parse(triangle + "vn 0 3 4\nvn 0 0 0\nf 1//1 2//2 3\n");
    CHECK(model.mesh.vertices[0].normal == glm::vec3(0, 0.6f, 0.8f));
    CHECK(model.mesh.vertices[1].normal == glm::vec3(0, 0, 1));
    CHECK(model.mesh.vertices[2].normal == glm::vec3(0, 0, 1));
    // The extremes of float do not overflow on the way.
    CHECK(parse(triangle + "vn 0 3e38 4e37\nf 1//1 2//1 3//1\n").mesh.vertices[0].normal.y == Approx(0.991228));
    CHECK(parse(triangle + "vn 1e-45 0 0\nf 1//1 2//1 3//1\n").mesh.vertices[0].normal == glm::vec3(1, 0, 0));
    // A triangle without area has some unit normal.
    CHECK(parse("v 1 1 1\nf 1 1 1\n").mesh.vertices[0].normal == glm::vec3(0, 1, 0));
}

TEST_CASE("obj: corners with the same indices share a vertex where they have a normal", "[io]") {
    const std::string quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n";
    CHECK(parse(quad + "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n").mesh.vertices.size() == 4);
    CHECK(parse(quad + "f 1 2 3\nf 1 3 4\n").mesh.vertices.size() == 6);
}

TEST_CASE("obj: polygons keep their area and their direction", "[io]") {
    // Areas by the shoelace formula, by hand: an arrow head, an L, a comb, and the same clockwise.
    const std::vector<glm::dvec2> arrow = {{0, 0}, {2, 1}, {0, 2}, {1, 1}};
    const std::vector<glm::dvec2> ell = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    const std::vector<glm::dvec2> comb = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1},
                                          {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    const std::vector<std::pair<std::vector<glm::dvec2>, double>> cases = {{arrow, 1}, {ell, 3}, {comb, 11}};
    for (auto [points, area] : cases)
        for (double sign : {1.0, -1.0}) {
            const Mesh mesh = parse(polygon(points)).mesh;
            CHECK(mesh.triangles.size() == points.size() - 2);
            CHECK(area_z(mesh) == 2 * sign * area);
            // No triangle is turned over: the areas add up without cancelling.
            for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
                Mesh one = mesh;
                one.triangles = {mesh.triangles[t]};
                CHECK(sign * area_z(one) >= 0);
            }
            std::reverse(points.begin(), points.end());
        }
}

TEST_CASE("obj: a convex face of 100,000 corners is read, a concave one of 1025 is refused", "[io][robustness]") {
    // A square whose sides carry the corners is convex in any precision.
    std::vector<glm::dvec2> points;
    for (int side = 0; side < 4; ++side)
        for (int i = 0; i < 25000; ++i) {
            const double a = i, b = 25000 - i;
            points.push_back(side == 0   ? glm::dvec2(a, 0)
                             : side == 1 ? glm::dvec2(25000, a)
                             : side == 2 ? glm::dvec2(b, 25000)
                                         : glm::dvec2(0, b));
        }
    const Mesh mesh = parse(polygon(points)).mesh;
    CHECK(mesh.triangles.size() == 99998);
    CHECK(area_z(mesh) == 2.0 * 25000 * 25000);

    std::vector<glm::dvec2> star;
    for (int i = 0; i < 1024; ++i) star.emplace_back(i, i % 2);
    star.emplace_back(256, 1000);
    require_message(error_of([&] { parse(polygon(star)); }), {"m.obj: line 1026", "concave face of 1025 corners", "1024"});
}

TEST_CASE("obj: materials, by name", "[io]") {
    const std::string library = "newmtl a b#1\nKd 0.25 0.5 1 # comment\nKe 2\nNs 10\n\nnewmtl c\n";
    const ObjModel model = parse("mtllib m.mtl\n" + triangle + "usemtl a b#1\nf 1 2 3\nusemtl c\nf 1 2 3\n", library);
    REQUIRE(model.materials.size() == 2);
    CHECK(model.materials[0].reflectance == glm::vec3(0.25f, 0.5f, 1.0f));
    CHECK(model.materials[0].emission == glm::vec3(2));
    CHECK(model.materials[1].reflectance == glm::vec3(0.5f));
    CHECK(model.mesh.material == std::vector<std::int32_t>{0, 1});
}

TEST_CASE("mtl: illum decides whether Ks is a lobe, a mirror or nothing", "[io]") {
    struct Case {
        std::string lines;
        glm::vec3 specular, mirror;
        float exponent;
    };
    const glm::vec3 none(0), ks(0.25f, 0.125f, 0.5f);
    const float unset = Material{}.exponent;
    const std::string given = "Kd 0.5\nKs 0.25 0.125 0.5\nNs 96.5\n";
    const std::vector<Case> cases = {
        {given, none, none, unset},  // without illum
        {given + "illum 0\n", none, none, unset},
        {given + "illum 1\n", none, none, unset},
        {given + "illum 2\n", ks, none, 96.5f},
        {given + "illum 3\n", none, ks, unset},
        {given + "illum 4\n", ks, none, 96.5f},
        {given + "illum 10 # shadows\n", ks, none, 96.5f},
        {"illum 2\nKs 0.25 0.125 0.5 # comment\nKd 0.5\n", ks, none, unset},  // in any order, without Ns
        {"illum 2\nKs 0.1\nKd 0.5\nKs 0.25 0.125 0.5\n", ks, none, unset},   // the last one holds
        {"illum 2\nNs 7\n", none, none, unset},
        {"illum 2\nKs 0 0 0\nNs 7\n", none, none, 7},
        // What illum leaves aside may be anything.
        {"illum 1\nKs spectral f.rfl\nNs x\n", none, none, unset},
        {"Ks -1 2\nNs nan\n", none, none, unset},
    };
    for (const Case& c : cases) {
        CAPTURE(c.lines);
        // Nothing of a material reaches the next one.
        const ObjModel model = parse_library("newmtl a\n" + c.lines + "newmtl b\nKd 1\n");
        const std::vector<Material>& m = model.materials;
        REQUIRE(m.size() == 3);
        CHECK(m[0].specular == c.specular);
        CHECK(m[0].mirror == c.mirror);
        CHECK(m[0].exponent == c.exponent);
        CHECK((m[1].specular == none && m[1].mirror == none && m[1].exponent == unset));
        CHECK(model.notes.empty());
    }
}

TEST_CASE("mtl: Ks gives way to Kd where they reflect more than they receive, and it is said once a file", "[io]") {
    const std::string library =
        "newmtl fits\nKd 0.8\nKs 0.2\nillum 2\n"
        "newmtl scaled\nKd 0.75 0.5 0\nKs 0.5 0.25 0.125\nillum 2\nNs 1e9\n"
        "newmtl mirror\nKd 0\nKs 4 2 1\nillum 3\n"
        "newmtl full\nKd 1 0 0\nKs 0.5\nillum 2\nNs -1.96\n"
        "newmtl unused\nKd 1\nKs 1\nNs -1\n";
    const ObjModel model = parse("mtllib m.mtl\n" + triangle + "usemtl fits\nf 1 2 3\n", library);
    const std::vector<Material>& m = model.materials;
    REQUIRE(m.size() == 5);
    // In floats 0.8 + 0.2 is 1 and a rounding: that is no excess.
    CHECK(m[0].specular[0] == Approx(0.2).epsilon(1e-6));
    // One factor, 0.25 / 0.5, for all channels.
    CHECK(m[1].reflectance == glm::vec3(0.75f, 0.5f, 0));
    CHECK(m[1].specular == glm::vec3(0.25f, 0.125f, 0.0625f));
    CHECK(m[1].exponent == 1e6f);
    CHECK(m[2].mirror == glm::vec3(1, 0.5f, 0.25f));
    CHECK(m[3].specular == glm::vec3(0));
    CHECK(m[3].exponent == 0);
    for (const Material& material : m)
        for (int c = 0; c < 3; ++c)
            CHECK(material.reflectance[c] + material.specular[c] + material.mirror[c] <= 1.0f);
    REQUIRE(model.notes.size() == 2);
    CHECK(model.notes[0] == "m.mtl: Kd + Ks is above 1 in 3 of 5 materials: their Ks is scaled down");
    CHECK(model.notes[1] == "m.mtl: Ns is not in 0 to 1e6 in 2 of 5 materials: the nearest is taken");
}

TEST_CASE("obj: map_Kd is read from beside the MTL, once a file", "[io]") {
    const Folder folder;
    const std::uint8_t pixels[] = {255, 0, 128, 1, 2, 3};
    write_png(folder / "t.png", 2, 1, pixels);
    folder.put("m.mtl", "newmtl a\nmap_Kd t.png\nnewmtl b\nKd 0.5 0.5 0.5\nmap_Kd t.png\n");
    const ObjModel model = read_obj(folder.put("m.obj", "mtllib m.mtl\n" + triangle + "usemtl b\nf 1 2 3\n"));
    REQUIRE(model.textures.size() == 1);
    CHECK(model.textures[0].srgb);
    CHECK(model.textures[0].texels(0, 0) == 0xff8000ffu);
    CHECK(model.textures[0].texels(1, 0) == 0xff030201u);
    CHECK(model.materials[0].reflectance == glm::vec3(1));  // the picture alone
    CHECK(model.materials[1].reflectance == glm::vec3(0.5f));
    CHECK(model.materials[1].texture == 0);
}

TEST_CASE("obj: malformed files are named with line and cause", "[io][robustness]") {
    struct Case {
        std::string text;
        std::vector<std::string> message;
    };
    const std::vector<Case> cases = {
        {"", {"m.obj: is empty"}},
        {"# nothing\n", {"m.obj: holds no face"}},
        {triangle, {"holds no face", "3 vertices"}},
        {"f 1 2 3\n", {"line 1: f: vertex 1 is out of range; the file has 0"}},
        {triangle + "f 1 2 4\n", {"line 4: f: vertex 4 is out of range; the file has 3"}},
        {triangle + "f 1 2 -4\n", {"line 4: f: vertex -4 is out of range; there are 3 so far"}},
        {triangle + "f 0 1 2\n", {"line 4: f: vertex 0; indices count from 1"}},
        {triangle + "f 1 2 99999999999999999999\n", {"line 4: f: vertex", "out of range"}},
        {triangle + "f 1 2 4294967297\n", {"line 4: f: vertex 4294967297 is out of range"}},
        {triangle + "f 1/ 2/ 3/x\n", {"line 4: f: \"x\" is not an index"}},
        {triangle + "f 1/1/1/1 2 3\n", {"line 4: f: \"1/1\" is not an index"}},
        {triangle + "f 1.5 2 3\n", {"line 4: f: \"1.5\" is not an index"}},
        {"v 0 0\n", {"line 1: v has 2 numbers; expected 3"}},
        {"v nan 0 0\n", {"line 1: v: nan is not a finite number"}},
        {"v 0 -inf 0\n", {"line 1: v: -inf is not a finite number"}},
        {"v 0 0 1e39\n", {"line 1: v: 1e39 is not a finite number of 32 bits"}},
        {"v 0 0 1e999\n", {"line 1: v: 1e999 is not a finite number of 32 bits"}},
        {"v 1,5 0 0\n", {"line 1: v: \"1,5\" is not a number"}},
        {"v 0x10 0 0\n", {"line 1: v: \"0x10\" is not a number"}},
        {"vt\n", {"line 1: vt has 0 numbers; expected 1"}},
        {"vn 0 0 NaN\n", {"line 1: vn: NaN is not a finite number"}},
        {"p 1\nl 1 2\nl 2 1\nsurf 0 1\nv 0 0 0\n",
         {"holds no face (f): 1 vertices, 1 statements of points, 2 of lines, 1 of free-form curves and surfaces"}},
        {std::string("\xff\xfe" "f\0\n", 5), {"byte 4: is not UTF-16"}},
        {std::string("\xff\xfe\x00\xd8" "f\0", 6), {"byte 2: is not UTF-16"}},
    };
    for (const Case& c : cases) {
        CAPTURE(c.text);
        std::vector<std::string> parts = c.message;
        parts.push_back("m.obj: ");
        require_message(error_of([&] { parse(c.text); }), parts);
    }
}

TEST_CASE("mtl: malformed files are named with line and cause", "[io][robustness]") {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"newmtl a\nKd 1 1\n", "line 2: Kd has 2 numbers; expected three"},
        {"newmtl a\nKd\n", "line 2: Kd has 0 numbers; expected three"},
        {"newmtl a\nKd nan 0 0\n", "line 2: Kd = nan: expected 0 to 1"},
        {"newmtl a\nKe -1 0 0\n", "line 2: Ke = -1: expected a finite number from 0 on"},
        {"newmtl a\nKe inf 0 0\n", "line 2: Ke = inf: expected a finite number from 0 on"},
        {"newmtl a\nillum 11\n", "line 2: illum = 11: expected 0 to 10"},
        {"newmtl a\nillum\nnewmtl b\n", "line 2: illum = : expected 0 to 10"},
        {"newmtl a\nillum 2.5\n", "line 2: illum = 2.5: expected 0 to 10"},
        {"newmtl a\nillum 2\nKs 1 1\nnewmtl b\n", "line 3: Ks has 2 numbers; expected three"},
        {"newmtl a\nillum 2\nKs 1 -1 1\n", "line 3: Ks = -1: expected a finite number from 0 on"},
        {"newmtl a\nillum 3\nKs 1 inf 1\n", "line 3: Ks = inf: expected a finite number from 0 on"},
        {"newmtl a\nNs x\nillum 2\nKs 1\n", "line 2: Ns: \"x\" is not a number"},
        {"newmtl a\nmap_Kd -s t.png\n", "line 2: map_Kd: -s has 0 numbers; expected 1"},
        {"newmtl a\nmap_Kd -mm 1 t.png\n", "line 2: map_Kd: -mm has 1 numbers; expected 2"},
        {"newmtl a\nbump -o nan t.png\n", "line 2: bump: -o nan: expected a number from -1e6 to 1e6"},
        {"newmtl a\nNs nan\nillum 2\nKs 1\n", "line 2: Ns: \"nan\" is not a number"},
    };
    for (const auto& [text, message] : cases) {
        CAPTURE(text);
        require_message(error_of([&, t = text] { parse_library(t); }), {"m.mtl: ", message});
    }
}

TEST_CASE("obj: cut off or changed at any byte, it loads or is refused", "[io][robustness]") {
    const Folder folder;
    const std::uint8_t grey[] = {128, 128, 128};
    write_png(folder / "t.png", 1, 1, grey);
    folder.put("m.mtl", "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd t.png\nKs 0.7\nNs 10\nillum 2\n");
    const std::string obj =
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 -1e-3\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\n"
        "f 1/1/1 2/1/1 3/1/1 4//1\nf -1 -2 -3\n";
    REQUIRE(read_obj(folder.put("m.obj", obj)).mesh.triangles.size() == 3);
    load_damaged(folder, "m.obj", obj, [](const std::string& path) { read_obj(path); });

    folder.put("m.obj", obj);
    const std::string mtl = read_text(folder / "m.mtl");
    load_damaged(folder, "m.mtl", mtl, [&](const std::string&) { read_obj(folder / "m.obj"); });
}

TEST_CASE("obj: real models have the triangles that tinyobjloader finds", "[io][assets]") {
    const char* assets = std::getenv("PLUMB_ASSETS");
    if (!assets) {
        WARN("PLUMB_ASSETS is not set: skipped");
        return;
    }
    // Numbers of triangles: from the table that comes with the assets.
    const std::vector<std::pair<std::string, std::size_t>> cases = {
        {"spot.obj", 5856}, {"stanford-bunny.obj", 69451}, {"teapot.obj", 6320}};
    for (const auto& [name, triangles] : cases) {
        CAPTURE(name);
        const std::string path = std::string(assets) + "/obj/" + name;
        const ObjModel ours = read_obj(path);
        REQUIRE(ours.mesh.triangles.size() == triangles);

        tinyobj::ObjReader theirs;
        tinyobj::ObjReaderConfig config;
        config.triangulate = true;
        REQUIRE(theirs.ParseFromFile(path, config));
        const tinyobj::attrib_t& attributes = theirs.GetAttrib();
        std::size_t corner = 0, wrong = 0;
        for (const tinyobj::shape_t& shape : theirs.GetShapes())
            for (const tinyobj::index_t& index : shape.mesh.indices) {
                const Vertex& v = ours.mesh.vertices[ours.mesh.triangles[corner / 3][int(corner % 3)]];
                ++corner;
                // It reads numbers digit by digit in double: within a unit in the last place of float.
                for (int k = 0; k < 3; ++k) {
                    const float x = attributes.vertices[std::size_t(3 * index.vertex_index + k)];
                    wrong += !(std::fabs(v.position[k] - x) <= 1.2e-7f * std::fabs(x));
                }
                if (index.texcoord_index >= 0)
                    wrong += !(std::fabs(1 - v.v - attributes.texcoords[std::size_t(2 * index.texcoord_index + 1)]) <=
                               1e-6f);
            }
        CHECK(corner == 3 * triangles);
        CHECK(wrong == 0);
    }
}
