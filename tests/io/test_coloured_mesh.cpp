// Meshes with colours of vertices, as our own readers, tinygltf and tinyobjloader find them.
#include <tiny_gltf.h>
#include <tiny_obj_loader.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "io/coloured_mesh.h"
#include "io/file.h"
#include "io/gltf.h"
#include "io/obj.h"
#include "tests/io/files.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// Two meshes of numbers that no short decimal holds; one radiosity is above what a colour may be.
std::vector<ColouredMesh> meshes() {
    std::vector<ColouredMesh> all(3);
    all[0].name = "floor, left", all[1].name = "empty", all[2].name = "lamp";
    for (const std::size_t m : {0u, 2u}) {
        ColouredMesh& mesh = all[m];
        for (int i = 0; i < 5; ++i) {
            const float x = float(i) + float(m);
            mesh.position.emplace_back(x / 3, x * x / 7, -x * 1e-4f);
            mesh.normal.push_back(i % 2 ? glm::vec3(0.6f, 0, 0.8f) : glm::vec3(0, -1, 0));
            mesh.radiosity.emplace_back(x / 11, m == 2 ? 100.0f / 3 : 0, 1e-9f * x);
            mesh.irradiance.emplace_back(x / 13, 0.1f, 1e9f / 7);
        }
        mesh.triangles = {{0, 1, 2}, {2, 3, 4}, {4, 0, 2}};
    }
    return all;
}
constexpr float scale = 1 / 3.0f;

bool same(const void* a, const glm::vec3& b) { return std::memcmp(a, &b, sizeof b) == 0; }

const unsigned char* values(const tinygltf::Model& m, const tinygltf::Primitive& p, const char* name, std::size_t count) {
    const tinygltf::Accessor& a = m.accessors[std::size_t(p.attributes.at(name))];
    CHECK(a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT);
    CHECK(a.type == TINYGLTF_TYPE_VEC3);
    REQUIRE(a.count == count);
    const tinygltf::BufferView& view = m.bufferViews[std::size_t(a.bufferView)];
    return m.buffers[std::size_t(view.buffer)].data.data() + view.byteOffset + a.byteOffset;
}

std::string error_text(const std::string& path, std::vector<ColouredMesh> all) {
    try {
        write_coloured(path, all, scale);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("coloured mesh: tinygltf reads positions, colours and W/m2 of a GLB to the bit", "[io][gltf][radiosity]") {
    const Folder folder;
    write_coloured(folder / "a.glb", meshes(), scale);
    tinygltf::TinyGLTF loader;
    tinygltf::Model model;
    std::string error, warning;
    REQUIRE(loader.LoadBinaryFromFile(&model, &error, &warning, folder / "a.glb"));
    CHECK((error + warning).empty());
    REQUIRE(model.meshes.size() == 2);
    REQUIRE(model.materials.size() == 1);
    CHECK(model.materials[0].extensions.count("KHR_materials_unlit") == 1);
    CHECK(model.extensionsUsed == std::vector<std::string>{"KHR_materials_unlit"});
    CHECK(float(model.asset.extras.Get("plumb").Get("colour_scale").Get<double>()) == scale);
    for (std::size_t i = 0; i < 2; ++i) {
        const ColouredMesh mesh = meshes()[2 * i];
        CHECK(model.meshes[i].name == mesh.name);
        const tinygltf::Primitive& p = model.meshes[i].primitives.at(0);
        CHECK(model.accessors[std::size_t(p.indices)].count == 9);
        const auto *position = values(model, p, "POSITION", 5), *colour = values(model, p, "COLOR_0", 5),
                   *radiosity = values(model, p, "_RADIOSITY", 5), *irradiance = values(model, p, "_IRRADIANCE", 5);
        for (std::size_t v = 0; v < 5; ++v) {
            const glm::vec3 b = mesh.radiosity[v];
            CHECK(same(position + 12 * v, mesh.position[v]));
            CHECK(same(radiosity + 12 * v, b));
            CHECK(same(irradiance + 12 * v, mesh.irradiance[v]));
            CHECK(same(colour + 12 * v, {std::fmin(1.0f, scale * b.x), std::fmin(1.0f, scale * b.y), std::fmin(1.0f, scale * b.z)}));
        }
    }
}

TEST_CASE("coloured mesh: our own readers find the same positions and triangles", "[io][gltf][radiosity]") {
    const Folder folder;
    for (const char* name : {"a.glb", "a.obj"}) {
        write_coloured(folder / name, meshes(), scale);
        std::vector<Mesh> read;
        if (std::string(name) == "a.glb")
            read = read_gltf(folder / name).meshes;
        else
            read.push_back(read_obj(folder / name).mesh);
        std::vector<glm::vec3> corners, expected;
        for (const Mesh& m : read)
            for (const glm::uvec3& t : m.triangles)
                for (int k = 0; k < 3; ++k) corners.push_back(m.vertices[t[k]].position);
        for (const ColouredMesh& m : meshes())
            for (const glm::uvec3& t : m.triangles)
                for (int k = 0; k < 3; ++k) expected.push_back(m.position[t[k]]);
        CAPTURE(name);
        CHECK(corners == expected);
        CHECK(corners.size() == 18);
    }
}

TEST_CASE("coloured mesh: tinyobjloader reads the colours of an OBJ, and its numbers are the floats in full", "[io][obj][radiosity]") {
    const Folder folder;
    write_coloured(folder / "a.obj", meshes(), scale);
    tinyobj::ObjReader reader;
    REQUIRE(reader.ParseFromFile(folder / "a.obj"));
    const tinyobj::attrib_t& all = reader.GetAttrib();
    REQUIRE(all.vertices.size() == 30);
    REQUIRE(all.colors.size() == 30);
    REQUIRE(reader.GetShapes().size() == 2);
    for (const tinyobj::shape_t& shape : reader.GetShapes()) CHECK(shape.mesh.num_face_vertices.size() == 3);
    std::istringstream text(read_text(folder / "a.obj"));
    std::string line;
    std::size_t v = 0;
    while (std::getline(text, line)) {
        if (line.rfind("v ", 0) != 0) continue;
        const ColouredMesh mesh = meshes()[v < 5 ? 0 : 2];
        const glm::vec3 p = mesh.position[v % 5], c = scale * mesh.radiosity[v % 5];
        const float expected[6] = {p.x, p.y, p.z, c.x, c.y, c.z};
        const char* at = line.c_str() + 2;
        for (int k = 0; k < 6; ++k) {
            char* end = nullptr;
            CHECK(std::strtof(at, &end) == expected[k]);
            at = end;
            // It reads digit by digit in double: within a unit in the last place.
            const float theirs = k < 3 ? all.vertices[3 * v + std::size_t(k)] : all.colors[3 * v + std::size_t(k) - 3];
            CHECK(std::fabs(theirs - expected[k]) <= 1.2e-7f * std::fabs(expected[k]));
        }
        ++v;
    }
    CHECK(v == 10);
}

TEST_CASE("coloured mesh: bad names, places and numbers are refused, and nothing is written", "[io][radiosity][bad input]") {
    const Folder folder;
    CHECK(error_text(folder / "a.ply", meshes()).find("a.ply: expected a name that ends in .glb or .obj") != std::string::npos);
    CHECK(error_text(folder / "none/a.obj", meshes()).find("none/a.obj: cannot be written") != std::string::npos);
    for (const char* name : {"a.glb", "a.obj"}) {
        std::vector<ColouredMesh> bad = meshes();
        bad[2].radiosity[3].y = std::numeric_limits<float>::quiet_NaN();
        CHECK(error_text(folder / name, bad).find("vertex 3 of mesh \"lamp\" is not finite") != std::string::npos);
    }
    CHECK(folder.files() == 0);
}
