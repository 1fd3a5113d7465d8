// What the reader and the writer of glTF think, tinygltf thinks too.
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "io/glb_write.h"
#include "io/gltf.h"
#include "io/scenes/generate.h"
#include "tests/io/files.h"

namespace plumb::io {
namespace {

tinygltf::Model load(const std::string& path) {
    tinygltf::TinyGLTF loader;
    tinygltf::Model model;
    std::string error, warning;
    loader.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int,
                             void*) { return true; }, nullptr);
    const bool binary = path.size() > 4 && path.substr(path.size() - 4) == ".glb";
    const bool good = binary ? loader.LoadBinaryFromFile(&model, &error, &warning, path)
                             : loader.LoadASCIIFromFile(&model, &error, &warning, path);
    INFO(path << ": " << error << warning);
    REQUIRE(good);
    return model;
}

const unsigned char* data_of(const tinygltf::Model& m, const tinygltf::Accessor& a, int& stride) {
    const tinygltf::BufferView& view = m.bufferViews[std::size_t(a.bufferView)];
    stride = a.ByteStride(view);
    return m.buffers[std::size_t(view.buffer)].data.data() + view.byteOffset + a.byteOffset;
}

std::vector<glm::vec3> vectors(const tinygltf::Model& m, int accessor) {
    const tinygltf::Accessor& a = m.accessors[std::size_t(accessor)];
    REQUIRE(a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT);
    REQUIRE(a.type == TINYGLTF_TYPE_VEC3);
    int stride = 0;
    const unsigned char* p = data_of(m, a, stride);
    std::vector<glm::vec3> v(a.count);
    for (std::size_t i = 0; i < a.count; ++i) std::memcpy(&v[i], p + i * std::size_t(stride), sizeof v[i]);
    return v;
}

std::vector<std::uint32_t> indices(const tinygltf::Model& m, int accessor) {
    const tinygltf::Accessor& a = m.accessors[std::size_t(accessor)];
    int stride = 0;
    const unsigned char* p = data_of(m, a, stride);
    std::vector<std::uint32_t> v(a.count);
    for (std::size_t i = 0; i < a.count; ++i) {
        const unsigned char* at = p + i * std::size_t(stride);
        if (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
            std::memcpy(&v[i], at, 4);
        else if (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
            v[i] = std::uint32_t(at[0] | at[1] << 8);
        else
            v[i] = at[0];
    }
    return v;
}

// The corners of all triangles in mesh space, sorted: a file has a primitive for each material.
using Corners = std::vector<std::array<float, 9>>;

void add(Corners& all, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    all.push_back({a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z});
}

Corners corners(const tinygltf::Model& m) {
    Corners all;
    for (const tinygltf::Mesh& mesh : m.meshes)
        for (const tinygltf::Primitive& p : mesh.primitives) {
            const std::vector<glm::vec3> v = vectors(m, p.attributes.at("POSITION"));
            const std::vector<std::uint32_t> i = indices(m, p.indices);
            for (std::size_t k = 0; k + 2 < i.size(); k += 3) add(all, v[i[k]], v[i[k + 1]], v[i[k + 2]]);
        }
    std::sort(all.begin(), all.end());
    return all;
}

Corners corners(const std::vector<Mesh>& meshes) {
    Corners all;
    for (const Mesh& mesh : meshes)
        for (const glm::uvec3& t : mesh.triangles)
            add(all, mesh.vertices[t.x].position, mesh.vertices[t.y].position, mesh.vertices[t.z].position);
    std::sort(all.begin(), all.end());
    return all;
}

}  // namespace

TEST_CASE("glb: tinygltf reads what is written, to the bit", "[io][gltf]") {
    const Folder folder;
    const std::string path = folder / "shapes.glb";
    const Scene scene = generate_scene("shapes", {300, 1}, "test");
    write_glb(path, scene);
    const tinygltf::Model model = load(path);
    CHECK(model.meshes.size() == scene.meshes.size());
    CHECK(model.materials.size() == scene.materials.size());
    CHECK(model.cameras.size() == 1);
    CHECK((corners(model) == corners(scene.meshes)));
    CHECK(corners(model).size() == flatten(scene).triangles.size());
}

TEST_CASE("gltf: tinygltf finds the triangles that the reader finds", "[io][gltf][assets]") {
    const char* named = std::getenv("PLUMB_ASSETS");
    const std::string folder = (named ? std::string(named) : PLUMB_SOURCE_DIR "/../shared/assets") + "/gltf/";
    for (const char* name : {"box01.glb", "Cube.gltf"}) {
        if (!std::filesystem::exists(folder + name)) {
            WARN("skipped: no " << name << " (PLUMB_ASSETS names the folder of assets)");
            continue;
        }
        CHECK((corners(load(folder + name)) == corners(read_gltf(folder + name).meshes)));
    }
}

}  // namespace plumb::io
