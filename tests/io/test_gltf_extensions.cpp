// What a glTF may require or hang its vertices on: extensions of looks, quantized attributes, skins.
#include <catch2/catch.hpp>
#include <tuple>

#include "gltf_files.h"

using namespace plumb;
using namespace plumb::io;

TEST_CASE("gltf: an extension that changes looks alone may be required; strict refuses it", "[io]") {
    const Folder folder;
    for (const char* name : {"KHR_materials_unlit", "KHR_materials_variants", "KHR_materials_transmission"}) {
        GltfSample s = square();
        s.json["extensionsRequired"] = {name}, s.json["extensionsUsed"] = {name};
        const std::string file = folder.put("a.gltf", s.gltf());
        const GltfModel model = read_gltf(file);
        CHECK(model.meshes.size() == 1);
        CHECK(model.notes == std::vector<std::string>{std::string("the file requires extension ") + name +
                                                      ", which is not read: it is drawn without"});
        GltfOptions strict;
        strict.strict = true;
        require_message(error_of([&] { read_gltf(file, strict); }), {"/extensionsRequired/0", "an extension that is not read"});
    }
}

TEST_CASE("gltf: KHR_mesh_quantization: positions, normals and coordinates of integers", "[io]") {
    // 100 units are a metre, by the node.
    GltfSample s = square();
    s.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
        s.add<std::int16_t>({0, 0, 0, 0, -100, 0, 0, 0, 100, 100, 0, 0, 0, 100, 0, 0}, 5122, "VEC4", 4);
    s.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
        s.add<std::int8_t>({0, 0, 127, 0, 0, 0, -128, 0, 0, 127, 0, 0, 0, 0, 127, 0}, 5120, "VEC4", 4);
    s.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
        s.add<std::uint8_t>({0, 1, 0, 0, 2, 1, 0, 0, 255, 0, 0, 0, 3, 4, 0, 0}, 5121, "VEC4", 4);
    // Elements of three with a stride of four.
    for (const auto& [accessor, type, stride] : std::vector<std::tuple<int, const char*, int>>{{4, "VEC3", 8}, {5, "VEC3", 4}, {6, "VEC2", 4}}) {
        Json& a = s.json["accessors"][std::size_t(accessor)];
        a["type"] = type;
        s.json["bufferViews"][a["bufferView"].get<std::size_t>()]["byteStride"] = stride;
    }
    s.json["accessors"][5]["normalized"] = true;
    const Folder folder;
    require_message(error_of([&] { read_gltf(folder.put("a.gltf", s.gltf())); }), {"expected 5126 (float)"});
    s.json["extensionsRequired"] = s.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    const GltfModel model = read_gltf(folder.put("a.gltf", s.gltf()));
    CHECK(model.notes.empty());
    const std::vector<Vertex>& v = model.meshes.at(0).vertices;
    REQUIRE(v.size() == 4);
    CHECK(v[1].position == glm::vec3(-100, 0, 0));
    CHECK(v[2].position == glm::vec3(100, 100, 0));
    CHECK(v[0].normal == glm::vec3(0, 0, 1));
    CHECK(v[1].normal == glm::vec3(0, 0, -1));  // -128 is -1 as well
    CHECK(v[2].normal == glm::vec3(0, 1, 0));
    CHECK((v[2].u == 255 && v[3].v == 4));       // not normalised: as they are
    s.json["accessors"][5]["normalized"] = false;
    require_message(error_of([&] { read_gltf(folder.put("a.gltf", s.gltf())); }), {"/accessors/5: integers that are not normalized"});
}

TEST_CASE("gltf: a skin stands as its joints do", "[io]") {
    // Vertices 0 and 1 hang on joint 0, vertex 2 on joint 1, vertex 3 on both. Joint 1 is turned by 90 degrees about z and moved.
    GltfSample s = square();
    const std::size_t joints = s.add<std::uint8_t>({0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, 5121, "VEC4", 4);
    const std::size_t weights = s.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 3, 0, 0}, 5126, "VEC4", 4);
    const std::size_t bind = s.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,  //
                                           1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1}, 5126, "MAT4", 16);
    Json& attributes = s.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = joints, attributes["WEIGHTS_0"] = weights;
    s.json["skins"] = Json::parse(R"([{"joints": [1, 2]}])");
    s.json["skins"][0]["inverseBindMatrices"] = bind;
    // The node of the mesh is moved, which moves nothing.
    s.json["nodes"] = Json::parse(R"([{"mesh": 0, "skin": 0, "translation": [7, 7, 7]}, {"children": [2], "translation": [0, 0, 1]},
                                      {"translation": [1, 0, 0], "rotation": [0, 0, 0.70710678118654752, 0.70710678118654752]}])");
    s.json["scenes"] = Json::parse(R"([{"nodes": [0, 1]}])");
    const Folder folder;
    const auto load = [&] { return read_gltf(folder.put("a.gltf", s.gltf())); };
    const GltfModel model = load();
    CHECK(model.notes.empty());
    const Mesh& mesh = model.meshes.at(0);
    CHECK(mesh.transform == glm::dmat4(1));
    const std::vector<Vertex>& v = mesh.vertices;
    const auto near = [](const glm::vec3& a, const glm::vec3& b) { return glm::distance(a, b) < 1e-6f; };
    CHECK(v[0].position == glm::vec3(0, 0, 1));
    CHECK(v[1].position == glm::vec3(1, 0, 1));
    // (1, 1, 0) - (1, 0, 0) = (0, 1, 0), turned (-1, 0, 0), moved by (1, 0, 1).
    CHECK(near(v[2].position, {0, 0, 1}));
    // A quarter of (0, 1, 1), three of what joint 1 makes of (0, 1, 0): (-1, 1, 0) turned (-1, -1, 0), moved (0, -1, 1).
    CHECK(near(v[3].position, glm::vec3(0, 1, 1) * 0.25f + glm::vec3(0, -1, 1) * 0.75f));
    CHECK(near(v[2].normal, {0, 0, 1}));

    // Flat vertices keep their weights; no weight: no move.
    attributes.erase("NORMAL");
    CHECK(near(load().meshes.at(0).vertices[2].position, {0, 0, 1}));
    attributes.erase("WEIGHTS_0");
    CHECK(load().meshes.at(0).vertices[1].position == glm::vec3(1, 0, 0));
    attributes["WEIGHTS_0"] = weights;
    s.json["skins"][0]["joints"] = {1};
    require_message(error_of(load), {"/skins/0: a vertex has joint 1; there are 1"});
    s.json["skins"][0]["joints"] = {1, 9};
    require_message(error_of(load), {"/skins/0/joints/1 = 9: out of range"});
    s.json["skins"][0]["joints"] = {1, 2}, s.json["scenes"][0]["nodes"] = {0};
    require_message(error_of(load), {"/skins/0/joints/0", "not in the scene"});
    s.json["scenes"][0]["nodes"] = {0, 1};
    s.json["accessors"][bind]["type"] = "VEC4", s.json["accessors"][bind]["count"] = 8;
    require_message(error_of(load), {"expected MAT4 at /skins/0/inverseBindMatrices"});
}
