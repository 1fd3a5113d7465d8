#include <clocale>
#include <cmath>
#include <cstdlib>

#include "core/host_math.h"
#include "gltf_files.h"
#include "io/image_file.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

Json& primitive(GltfSample& s) { return s.json["meshes"][0]["primitives"][0]; }

glm::dvec3 moved(const Mesh& mesh, const glm::dvec3& p) { return glm::dvec3(mesh.transform * glm::dvec4(p, 1)); }

// A PNG of one row, in the document's own buffer.
void give_picture(GltfSample& s, const std::vector<std::uint32_t>& texels) {
    Image<std::uint32_t> image(int(texels.size()), 1);
    std::copy(texels.begin(), texels.end(), image.texels.begin());
    const std::vector<unsigned char> png = encode_png("test", image);
    s.add<unsigned char>(png, 5121, "SCALAR", 1);
    s.json["images"] = Json::array({{{"bufferView", s.json["bufferViews"].size() - 1}, {"mimeType", "image/png"}}});
    s.json["textures"] = Json::array({{{"source", 0}}});
    s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
}

}  // namespace

TEST_CASE("gltf: a square of two triangles arrives as it is", "[io]") {
    const GltfModel m = load(square());
    REQUIRE(m.meshes.size() == 1);
    const Mesh& mesh = m.meshes[0];
    CHECK(mesh.name == "square");
    CHECK(mesh.triangles == std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}});
    CHECK(mesh.material == std::vector<std::int32_t>{0, 0});
    REQUIRE(mesh.vertices.size() == 4);
    CHECK(mesh.vertices[2].position == glm::vec3(1, 1, 0));
    CHECK(mesh.vertices[2].normal == glm::vec3(0, 0, 1));
    // glTF's origin of texture coordinates is the top left, as here: nothing is turned.
    CHECK((mesh.vertices[0].u == 0 && mesh.vertices[0].v == 1));
    CHECK(mesh.tangents.empty());
    CHECK(m.has_texture_coordinates == std::vector<bool>{true});
    REQUIRE(m.materials.size() == 1);
    CHECK(m.materials[0].name == "paint");
    CHECK(m.materials[0].reflectance == glm::vec3(0.25f, 0.5f, 0.75f));
    CHECK(m.notes.empty());
    CHECK(!m.has_camera);
}

TEST_CASE("gltf: indices of 8, 16 and 32 bits and none give the same triangles", "[io]") {
    const std::vector<glm::uvec3> expected = {{0, 1, 2}, {0, 2, 3}};
    GltfSample bytes = square(), words = square(), none = square();
    primitive(bytes)["indices"] = bytes.add<std::uint8_t>({0, 1, 2, 0, 2, 3}, 5121, "SCALAR", 1);
    primitive(words)["indices"] = words.add<std::uint32_t>({0, 1, 2, 0, 2, 3}, 5125, "SCALAR", 1);
    CHECK(load(bytes).meshes[0].triangles == expected);
    CHECK(load(words).meshes[0].triangles == expected);
    // Without indices three vertices are left over.
    primitive(none).erase("indices");
    for (int accessor : {0, 1, 2}) none.json["accessors"][std::size_t(accessor)]["count"] = 3;
    CHECK(load(none).meshes[0].triangles == std::vector<glm::uvec3>{{0, 1, 2}});
}

TEST_CASE("gltf: strips and fans turn as glTF 2.0 3.7.2.1 says", "[io]") {
    GltfSample s = square();
    primitive(s).erase("indices");
    primitive(s)["mode"] = 5;
    CHECK(load(s).meshes[0].triangles == std::vector<glm::uvec3>{{0, 1, 2}, {1, 3, 2}});
    primitive(s)["mode"] = 6;
    CHECK(load(s).meshes[0].triangles == std::vector<glm::uvec3>{{1, 2, 0}, {2, 3, 0}});
    s.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
    const GltfModel m = load(s);
    CHECK(m.meshes[0].triangles.size() == 2);
    CHECK(m.notes == std::vector<std::string>{"not drawn: 1 primitive of lines"});
}

TEST_CASE("gltf: a stride, integers and sparse values reach the vertices", "[io]") {
    GltfSample s = square();
    // Interleaved: position, then 4 bytes that belong to nobody.
    primitive(s)["attributes"]["POSITION"] =
        s.add<float>({0, 0, 5, -1, 1, 0, 5, -1, 1, 1, 5, -1, 0, 1, 5, -1}, 5126, "VEC3", 4);
    s.json["bufferViews"].back()["byteStride"] = 16;
    primitive(s)["attributes"]["TEXCOORD_0"] =
        s.add<std::uint16_t>({0, 65535, 13107, 0, 0, 0, 0, 0}, 5123, "VEC2", 2);
    s.json["accessors"].back()["normalized"] = true;
    const std::size_t index = s.json["bufferViews"].size();
    s.add<std::uint16_t>({2}, 5123, "SCALAR", 1);
    s.add<float>({7, 8, 9}, 5126, "VEC3", 3);
    s.json["accessors"][4]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", index}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", index + 1}}}};
    const GltfModel m = load(s);
    CHECK(m.meshes[0].vertices[1].position == glm::vec3(1, 0, 5));
    CHECK(m.meshes[0].vertices[2].position == glm::vec3(7, 8, 9));
    CHECK(m.meshes[0].vertices[0].v == 1);
    CHECK(m.meshes[0].vertices[1].u == 13107.0f / 65535.0f);
    // An accessor without a view is zeros but for its sparse values.
    s.json["accessors"][4].erase("bufferView");
    CHECK(load(s).meshes[0].vertices[1].position == glm::vec3(0));
    CHECK(load(s).meshes[0].vertices[2].position == glm::vec3(7, 8, 9));
}

TEST_CASE("gltf: coordinates of bytes are parts of 255", "[io]") {
    GltfSample s = square();
    // Two bytes of padding after each element.
    primitive(s)["attributes"]["TEXCOORD_0"] =
        s.add<std::uint8_t>({0, 255, 9, 9, 51, 128, 9, 9, 1, 254, 9, 9, 0, 0, 9, 9}, 5121, "VEC2", 4);
    s.json["bufferViews"].back()["byteStride"] = 4;
    s.json["accessors"].back()["normalized"] = true;
    const GltfModel m = load(s);
    const auto& v = m.meshes[0].vertices;
    CHECK((v[0].u == 0 && v[0].v == 1));
    CHECK((v[1].u == 51.0f / 255.0f && v[1].v == 128.0f / 255.0f));
    CHECK((v[2].u == 1.0f / 255.0f && v[2].v == 254.0f / 255.0f));
}

TEST_CASE("gltf: the second set of coordinates is read where it is asked for, as it is", "[io]") {
    GltfSample s = square();
    const std::vector<glm::vec2> expected = {{0.25f, 0.5f}, {0.75f, 0.5f}, {0.75f, 1}, {0.25f, 1}};
    primitive(s)["attributes"]["TEXCOORD_1"] = s.add<float>({0.25f, 0.5f, 0.75f, 0.5f, 0.75f, 1, 0.25f, 1}, 5126, "VEC2", 2);
    CHECK(load(s).second_coordinates.empty());
    GltfOptions options;
    options.second_coordinates = true;
    const GltfModel m = load(s, options);
    REQUIRE(m.second_coordinates.size() == 1);
    CHECK(m.second_coordinates[0] == expected);
    CHECK(m.meshes[0].vertices.size() == 4);
    // A corner of a flat triangle has its own vertex, and the coordinate of the one that it stands for.
    GltfSample flat = s;
    primitive(flat)["attributes"].erase("NORMAL");
    const GltfModel f = load(flat, options);
    REQUIRE(f.second_coordinates[0].size() == 6);
    for (std::size_t t = 0; t < 2; ++t)
        for (int k = 0; k < 3; ++k)
            CHECK(f.second_coordinates[0][f.meshes[0].triangles[t][k]] == expected[m.meshes[0].triangles[t][k]]);
    // A primitive without the set leaves the mesh without; two that differ in it alone share no vertices.
    GltfSample lacks = s;
    Json other = primitive(lacks);
    other["attributes"].erase("TEXCOORD_1");
    lacks.json["meshes"][0]["primitives"].push_back(other);
    CHECK(load(lacks, options).second_coordinates[0].empty());
    GltfSample two = s;
    other = primitive(two);
    other["attributes"]["TEXCOORD_1"] = two.add<float>({0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC2", 2);
    two.json["meshes"][0]["primitives"].push_back(other);
    REQUIRE(load(two, options).second_coordinates[0].size() == 8);
    CHECK(load(two, options).second_coordinates[0][0] == expected[0]);
    CHECK(load(two, options).second_coordinates[0][4] == glm::vec2(0));
    CHECK(load(two).meshes[0].vertices.size() == 4);
    // As many as there are vertices.
    GltfSample few = s;
    primitive(few)["attributes"]["TEXCOORD_1"] = few.add<float>({0, 0}, 5126, "VEC2", 2);
    CHECK_THROWS_WITH(load(few, options), Catch::Matchers::Contains("TEXCOORD_1"));
}

TEST_CASE("gltf: second coordinates follow vertices that tangents split, and models their scene", "[io]") {
    GltfSample s = square();
    give_picture(s, {0xffff8080u});
    s.json["materials"][0]["normalTexture"] = {{"index", 0}};
    // The second triangle shows the picture mirrored, so that the corners they share need two tangents.
    primitive(s)["attributes"]["TEXCOORD_0"] = s.add<float>({0, 1, 1, 1, 1, 0, 1, 1}, 5126, "VEC2", 2);
    primitive(s)["attributes"]["TEXCOORD_1"] = s.add<float>({0.25f, 0.5f, 0.75f, 0.5f, 0.75f, 1, 0.25f, 1}, 5126, "VEC2", 2);
    const std::vector<glm::vec2> expected = {{0.25f, 0.5f}, {0.75f, 0.5f}, {0.75f, 1}, {0.25f, 1}};
    const glm::uvec3 corners[] = {{0, 1, 2}, {0, 2, 3}};
    const Folder folder;
    folder.put("a.gltf", s.gltf());
    folder.put("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string scene = folder.put("a.toml", "[[mesh]]\nfile = \"plain.obj\"\n[[mesh]]\nfile = \"a.gltf\"\n");
    for (const std::string& file : {folder / "a.gltf", scene}) {
        SecondCoordinates second(7);
        const Scene loaded = load_scene(file, {}, second);
        REQUIRE(second.size() == loaded.meshes.size());
        if (second.size() == 2) CHECK(second[0].empty());  // an OBJ has none
        const Mesh& mesh = loaded.meshes.back();
        REQUIRE(mesh.vertices.size() == 6);
        REQUIRE(second.back().size() == 6);
        for (std::size_t t = 0; t < 2; ++t)
            for (int k = 0; k < 3; ++k) CHECK(second.back()[mesh.triangles[t][k]] == expected[corners[t][k]]);
    }
}

TEST_CASE("gltf: without normals every triangle is flat; a zero normal is its triangle's", "[io]") {
    GltfSample s = square();
    primitive(s)["attributes"].erase("NORMAL");
    const GltfModel flat = load(s);
    REQUIRE(flat.meshes[0].vertices.size() == 6);
    for (const Vertex& v : flat.meshes[0].vertices) CHECK(v.normal == glm::vec3(0, 0, 1));
    CHECK(flat.meshes[0].triangles[1] == glm::uvec3(3, 4, 5));
    CHECK(flat.meshes[0].vertices[5].position == glm::vec3(0, 1, 0));
    GltfSample zero = square();
    zero.buffer.replace(48, 12, std::string(12, '\0'));
    zero.buffer.replace(60, 12, bytes_of<float>({0, 3, 4}));
    CHECK(load(zero).meshes[0].vertices[0].normal == glm::vec3(0, 0, 1));
    CHECK(load(zero).meshes[0].vertices[1].normal == glm::vec3(0, 0.6f, 0.8f));
}

TEST_CASE("gltf: nodes are moved by their parents; each becomes a mesh", "[io]") {
    GltfSample s = square();
    // The parent turns a quarter about z, x to y, and moves; the child doubles and moves.
    s.json["nodes"] = Json::parse(R"([
        {"children": [1, 2], "translation": [10, 0, 0], "rotation": [0, 0, 0.70710678118654752, 0.70710678118654752]},
        {"mesh": 0, "translation": [1, 0, 0], "scale": [2, 2, 2]},
        {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,3,1]}])");
    const GltfModel m = load(s);
    REQUIRE(m.meshes.size() == 2);
    const glm::dvec3 p = moved(m.meshes[0], {1, 0, 0});  // 2, 0, 0; 3, 0, 0; 0, 3, 0; 10, 3, 0
    CHECK(p.x == Approx(10).margin(1e-12));
    CHECK(p.y == Approx(3).margin(1e-12));
    CHECK(moved(m.meshes[1], {0, 0, 0}) == glm::dvec3(10, 0, 3));
    CHECK(m.meshes[0].vertices.size() == m.meshes[1].vertices.size());
    // The default scene alone is read.
    s.json["scenes"] = Json::parse(R"([{"nodes": [0]}, {"nodes": []}])");
    s.json["scene"] = 1;
    require_message(error_of([&] { load(s); }),
                    {"holds no triangle: no node of the scene that is read (of 2) refers to a mesh; 2 elsewhere do"});
}

TEST_CASE("gltf: what is skipped is counted, and a file without a triangle says why", "[io][robustness]") {
    GltfSample s = square();
    Json& primitives = s.json["meshes"][0]["primitives"];
    const Json whole = primitives[0];
    Json bare = whole;
    bare["attributes"].erase("POSITION");
    for (const int mode : {0, 0, 1, 2, 3}) primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
    primitives.push_back(bare);
    s.json["nodes"].push_back({{"mesh", 0}});  // a mesh counts once, however often it stands
    s.json["scenes"][0]["nodes"] = {0, 1};
    const GltfModel m = load(s);
    CHECK(m.meshes.size() == 2);
    CHECK(m.meshes[0].triangles.size() == 2);
    const std::string skipped = "2 primitives of points, 3 primitives of lines, 1 primitive without POSITION";
    CHECK(m.notes == std::vector<std::string>{"not drawn: " + skipped});

    primitives.erase(0);
    require_message(error_of([&] { load(s); }), {"a.gltf: holds no triangle: " + skipped + ", and nothing else in the meshes"});
    primitives = Json::array({bare});
    require_message(error_of([&] { load(s); }), {"holds no triangle: 1 primitive without POSITION"});
    s.json["nodes"] = Json::parse(R"([{"name": "empty"}, {"name": "empty, too"}])");
    require_message(error_of([&] { load(s); }), {"holds no triangle: no node refers to a mesh, of which the file has 1"});
    s.json.erase("meshes");
    require_message(error_of([&] { load(s); }), {"holds no triangle: the file has no mesh"});

    // Corners in a line, or in one point: nothing would be seen.
    GltfSample flat = square();
    const std::vector<float> line = {0, 0, 0, 0.1f, 0.2f, 0.3f, 0.2f, 0.4f, 0.6f, 0.4f, 0.8f, 1.2f};
    flat.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = flat.add<float>(line, 5126, "VEC3", 3);
    CHECK(load(flat).notes == std::vector<std::string>{"nothing is seen: the corners of each of the 2 triangles lie in a line"});
    flat.json["meshes"][0]["primitives"].push_back(whole);
    CHECK(load(flat).notes.empty());
    CHECK(load(flat).meshes[0].triangles.size() == 4);
}

TEST_CASE("gltf: materials: exitance is pi times emission, masks have a cutoff", "[io]") {
    GltfSample s = square();
    s.json["materials"][0] = Json::parse(R"({"emissiveFactor": [1, 0.5, 0], "alphaMode": "MASK",
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}},
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}})");
    const GltfModel m = load(s);
    CHECK(m.materials[0].name == "material0");
    CHECK(m.materials[0].emission == glm::vec3(float(4 * host::pi), float(2 * host::pi), 0));
    CHECK(m.materials[0].alpha == 0.25f);
    CHECK(m.materials[0].alpha_cutoff == 0.5f);  // glTF's default
    CHECK(m.notes.empty());
    s.json["materials"][0]["alphaMode"] = "BLEND";
    CHECK(load(s).materials[0].alpha_cutoff == 0.5f);
    CHECK(load(s).notes.size() == 1);
    // No material is glTF's default one, white.
    primitive(s).erase("material");
    const GltfModel none = load(s);
    CHECK(none.materials[std::size_t(none.meshes[0].material[0])].reflectance == glm::vec3(1));
    CHECK(none.materials.back().name == "default");
    CHECK((none.materials.back().microfacet && none.materials.back().metalness == 1 && none.materials.back().roughness == 1));
}

TEST_CASE("gltf: textures of a material lie as its first does, or are left out; one without a picture is", "[io]") {
    GltfSample s = square();
    give_picture(s, {0xff030201u, 0xffaabbccu});
    Json& material = s.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    material["emissiveTexture"] = {{"index", 0}, {"texCoord", 1}};
    material["normalTexture"] = {{"index", 0}};
    const GltfModel model = load(s);
    CHECK((model.materials[0].texture >= 0 && model.materials[0].normal_texture >= 0));
    CHECK(model.materials[0].emission_texture == -1);
    REQUIRE(model.notes.size() == 1);
    CHECK(model.notes[0].find("takes other texture coordinates") != std::string::npos);
    s.json["textures"][0].erase("source");
    material.erase("emissiveTexture");
    const GltfModel without = load(s);
    CHECK((without.materials[0].texture == -1 && without.textures.empty()));
    REQUIRE(without.notes.size() == 1);
    CHECK(without.notes[0].find("a texture whose picture an extension has") != std::string::npos);
}

TEST_CASE("gltf: metalness and roughness: factors, 1 by default, and a texture that is linear", "[io][microfacet]") {
    GltfSample s = square();
    give_picture(s, {0xff030201u, 0x00aabbccu});
    Json& material = s.json["materials"][0];
    material = Json::parse(R"({"pbrMetallicRoughness": {"metallicFactor": 0.25, "roughnessFactor": 0.125,
        "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}}})");
    const GltfModel m = load(s);
    const Material& read = m.materials[0];
    CHECK((read.microfacet && read.metalness == 0.25f && read.roughness == 0.125f));
    REQUIRE((read.surface_texture >= 0 && read.surface_texture != read.texture));
    CHECK(!m.textures[std::size_t(read.surface_texture)].srgb);
    CHECK(m.textures[std::size_t(read.texture)].srgb);
    CHECK(m.notes.empty());
    // Of other coordinates than the rest it is left out, and said.
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"]["texCoord"] = 1;
    const GltfModel other = load(s);
    CHECK(other.materials[0].surface_texture == -1);
    REQUIRE(other.notes.size() == 1);
    CHECK_THAT(other.notes[0], Catch::Contains("takes other texture coordinates"));
    for (const char* defaults : {"{}", R"({"pbrMetallicRoughness": {}})"}) {
        material = Json::parse(defaults);
        const Material d = load(s).materials[0];
        CHECK((d.microfacet && d.metalness == 1 && d.roughness == 1 && d.surface_texture == -1));
    }
    for (const char* wrong : {R"({"pbrMetallicRoughness": {"metallicFactor": 1.5}})", R"({"pbrMetallicRoughness": {"roughnessFactor": -1}})"}) {
        material = Json::parse(wrong);
        require_message(error_of([&] { load(s); }), {"pbrMetallicRoughness", "expected"});
    }
}

TEST_CASE("gltf: materials of another model have no microfacets", "[io][microfacet]") {
    GltfSample s = square();
    Json& material = s.json["materials"][0];
    auto read = [&] { return load(s).materials[0]; };
    CHECK(read().microfacet);
    material["extensions"]["KHR_materials_unlit"] = Json::object();
    CHECK(!read().microfacet);
    material.erase("extensions");
    // What this program keeps: a lobe, a mirror, or nothing of the kind in a file of its own.
    material["extras"]["plumb"]["mirror"] = {0.25, 0.25, 0.25};
    CHECK((!read().microfacet && read().mirror == glm::vec3(0.25f)));
    material["extras"]["plumb"]["microfacet"] = true;
    require_message(error_of(read), {"microfacet", "expected one or the other"});
    material.erase("extras");
    s.json["asset"]["generator"] = "plumb";
    CHECK(!read().microfacet);
    material["extras"]["plumb"]["microfacet"] = true;
    CHECK(read().microfacet);
}

TEST_CASE("gltf: textures: sampler, colour space by use, no mips", "[io]") {
    GltfSample s = square();
    give_picture(s, {0xff030201u, 0x00aabbccu});
    s.json["samplers"] = Json::parse(R"([{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}])");
    s.json["textures"][0]["sampler"] = 0;
    s.json["materials"][0]["normalTexture"] = {{"index", 0}, {"scale", 0.5}};
    const GltfModel m = load(s);
    REQUIRE(m.textures.size() == 2);
    const Texture& colour = m.textures[std::size_t(m.materials[0].texture)];
    const Texture& normal = m.textures[std::size_t(m.materials[0].normal_texture)];
    CHECK(colour.srgb);
    CHECK(!normal.srgb);
    CHECK(m.materials[0].normal_scale == 0.5f);
    CHECK(colour.texels(0, 0) == 0xff030201u);
    CHECK(colour.texels(1, 0) == 0x00aabbccu);  // straight: a colour without alpha is still there
    CHECK(colour.filter == Filter::nearest);
    CHECK(colour.wrap_u == Wrap::clamp_to_edge);
    CHECK(colour.wrap_v == Wrap::mirrored_repeat);
    CHECK(!colour.mips);
    s.json["textures"][0].erase("sampler");
    CHECK(load(s).textures[0].filter == Filter::bilinear);
    CHECK(load(s).textures[0].wrap_u == Wrap::repeat);
}

TEST_CASE("gltf: KHR_texture_transform scales, turns counter-clockwise with v down, moves", "[io]") {
    GltfSample s = square();
    give_picture(s, {0xffffffffu});
    s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] =
        Json::parse(R"({"offset": [10, 20], "scale": [2, 3], "rotation": 1.5707963267948966})");
    const Mesh mesh = load(s).meshes[0];
    // (1, 0) becomes (2, 0), turns up to (0, -2), moves. (0, 1) becomes (0, 3), turns right to (3, 0), moves.
    CHECK(mesh.vertices[2].u == Approx(10).margin(1e-6));
    CHECK(mesh.vertices[2].v == Approx(18).margin(1e-6));
    CHECK(mesh.vertices[0].u == Approx(13).margin(1e-6));
    CHECK(mesh.vertices[0].v == Approx(20).margin(1e-6));
}

TEST_CASE("gltf: lights are photometric: 683 lm/W; their nodes aim them", "[io]") {
    GltfSample s = square();
    s.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::parse(R"([
        {"type": "spot", "intensity": 1366, "color": [1, 0.5, 0],
         "spot": {"innerConeAngle": 0.5235987755982988, "outerConeAngle": 0.7853981633974483}},
        {"type": "directional", "intensity": 683}, {"type": "point", "name": "my lamp"}])");
    s.json["nodes"] = Json::parse(R"([{"mesh": 0},
        {"name": "key", "translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"name": "key", "rotation": [1, 0, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}}])");
    s.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
    const GltfModel m = load(s);
    REQUIRE(m.lights.size() == 3);
    CHECK(m.lights[0].type == LightType::spot);
    CHECK(m.lights[0].intensity == glm::vec3(2, 1, 0));
    CHECK(m.lights[0].position == glm::vec3(1, 2, 3));
    CHECK(m.lights[0].direction == glm::vec3(0, 0, -1));
    CHECK(m.lights[0].cone_inner_deg == 30);
    CHECK(m.lights[0].cone_outer_deg == 45);
    CHECK(m.lights[1].intensity == glm::vec3(1));
    CHECK(m.lights[1].direction == glm::vec3(0, 0, 1));  // half a turn about x
    CHECK(m.lights[1].name != m.lights[0].name);
    CHECK(m.lights[2].type == LightType::point);
    CHECK(m.lights[2].name == "my_lamp");
    GltfOptions as_is;
    as_is.photometric_as_is = true;
    CHECK(load(s, as_is).lights[0].intensity == glm::vec3(1366, 683, 0));
}

TEST_CASE("gltf: the first camera of the scene is its camera", "[io]") {
    GltfSample s = square();
    s.json["cameras"] = Json::parse(R"([{"type": "orthographic"},
        {"type": "perspective", "perspective": {"yfov": 1.5707963267948966, "znear": 0.5}},
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 1, "zfar": 2}}])");
    s.json["nodes"] = Json::parse(R"([{"mesh": 0}, {"camera": 0}, {"camera": 1, "translation": [0, 0, 5]}, {"camera": 2}])");
    s.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
    const GltfModel m = load(s);
    REQUIRE(m.has_camera);
    CHECK(m.camera.position == glm::dvec3(0, 0, 5));
    CHECK(m.camera.look_at == glm::dvec3(0, 0, 4));
    CHECK(m.camera.up == glm::dvec3(0, 1, 0));
    CHECK(m.camera.fov_y_deg == Approx(90));
    CHECK(m.camera.near == 0.5);
    CHECK(std::isinf(m.camera.far));
    CHECK(m.notes.size() == 2);
}

TEST_CASE("gltf: a GLB, a file with a buffer beside it and data: are the same model", "[io]") {
    const Folder folder;
    GltfSample s = square();
    const GltfModel a = load(folder, "a.gltf", s.gltf()), b = load(folder, "b.glb", s.glb());
    folder.put("the buffer.bin", s.buffer);
    s.json["buffers"][0] = {{"byteLength", s.buffer.size()}, {"uri", "the%20buffer.bin"}};
    const GltfModel c = load(folder, "c.gltf", s.gltf());
    for (const GltfModel* m : {&b, &c}) {
        CHECK(m->meshes[0].triangles == a.meshes[0].triangles);
        CHECK(bytes_of(m->meshes[0].vertices) == bytes_of(a.meshes[0].vertices));
    }
}

TEST_CASE("gltf: what is not read is said", "[io]") {
    GltfSample s = square();
    s.json["extensionsUsed"] = {"KHR_materials_unlit", "KHR_lights_punctual"};
    s.json["animations"] = Json::array({Json::object()});
    primitive(s)["attributes"]["COLOR_0"] = 1;
    s.json["nodes"][0]["extras"] = 7;  // somebody else's: not looked at
    CHECK(load(s).notes == std::vector<std::string>{"extension KHR_materials_unlit is not read",
                                                    "animations are not read: all stands still",
                                                    "colours of vertices are not read"});
}

TEST_CASE("scene: a glTF brings its camera and lights where the file has none", "[io]") {
    const Folder folder;
    GltfSample s = square();
    s.json["cameras"] = Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.5}}])");
    s.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::parse(R"([{"type": "point", "intensity": 683}])");
    s.json["nodes"].push_back(Json::parse(R"({"name": "lamp", "camera": 0, "translation": [1, 2, 3],
        "extensions": {"KHR_lights_punctual": {"light": 0}}})"));
    s.json["scenes"][0]["nodes"] = {0, 1};
    folder.put("a.glb", s.glb());
    const auto scene = [&](const std::string& text) { return load_scene(folder.put("s.toml", text), {}); };
    const std::string mesh = "[[mesh]]\nfile = \"a.glb\"\n";
    const Scene its = scene(mesh + "translate = [10, 0, 0]\n");
    CHECK(its.camera.position == glm::dvec3(11, 2, 3));
    REQUIRE(its.lights.size() == 1);
    CHECK(its.lights[0].position == glm::vec3(11, 2, 3));
    CHECK(its.lights[0].intensity == glm::vec3(1));
    CHECK(its.notes == std::vector<std::string>{"no light in the file: the 1 of its meshes",
                                                "no camera in the file: the one of \"a.glb\""});
    CHECK(scene("photometric = \"as_is\"\n" + mesh).lights[0].intensity == glm::vec3(683));
    const Scene own = scene(mesh + "[[light]]\nname = \"sun\"\n[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\n");
    REQUIRE(own.lights.size() == 1);
    CHECK(own.lights[0].name == "sun");
    CHECK(own.camera.position == glm::dvec3(0, 0, 9));
    CHECK(own.camera.fov_y_deg == 45);
    // The materials' new keys.
    const Scene m = scene(mesh + "[[material]]\nname = \"paint\"\nalpha_cutoff = 0.25\nnormal_scale = 2\n");
    CHECK(m.materials[0].alpha_cutoff == 0.25f);
    CHECK(m.materials[0].normal_scale == 2);
    CHECK(load_scene(folder / "a.glb", {}).lights.size() == 1);
}

TEST_CASE("assets: every model of the shared folder loads", "[io][assets]") {
    const char* named = std::getenv("PLUMB_ASSETS");
    const std::filesystem::path folder =
        named ? std::filesystem::path(named) : std::filesystem::path(PLUMB_SOURCE_DIR) / "../shared/assets";
    if (!std::filesystem::is_directory(folder)) {
        WARN("skipped: no folder of assets (PLUMB_ASSETS names one)");
        return;
    }
    int loaded = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string extension = extension_of(entry.path().string());
        if (extension != "gltf" && extension != "glb" && extension != "obj") continue;
        CAPTURE(entry.path().filename().string());
        const Scene scene = load_scene(entry.path().string(), {});
        CHECK(!flatten(scene).triangles.empty());
        CHECK(scene.lights.size() == 1);
        ++loaded;
    }
    CHECK(loaded > 0);
}
