// A glTF file taken apart: its JSON, its buffers, its accessors. Private to io/.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene.h"
#include "io/gltf.h"
#include "io/gltf_json.h"

namespace plumb::io {

inline constexpr std::size_t max_gltf_elements = std::size_t(1) << 28;  // of an accessor
inline constexpr std::size_t max_gltf_total = std::size_t(1) << 28;     // triangles, and vertices, of all meshes
inline constexpr const char* own_generator = "plumb";  // asset/generator of what io/ writes
inline constexpr double unbounded_number = 1.7976931348623157e308;

// Part of a file: bytes that somebody else owns.
struct ByteSpan {
    const unsigned char* data = nullptr;
    std::size_t size = 0;
};

// Primitives that are not drawn, of the meshes that were read.
struct GltfSkipped {
    std::size_t points = 0, lines = 0, without_position = 0;
    // "2 primitives of points, 1 without POSITION"; "" where none is.
    std::string text() const;
};

struct GltfDocument {
    std::string path;
    std::vector<unsigned char> file;
    GltfJson json;
    std::vector<std::vector<unsigned char>> loaded;  // buffers that are not part of the file
    std::vector<ByteSpan> buffers;                   // each of its declared length
    std::vector<std::string> notes;
    bool strict = false;     // what is required and not read is refused, whatever it is
    bool quantized = false;  // KHR_mesh_quantization: attributes may be integers
    GltfSkipped skipped;
    mutable std::size_t zeros = 0;  // elements that were read of accessors without a bufferView

    JsonValue root() const { return JsonValue(path, json); }
    JsonValue list(const char* name) const { return root()[name]; }
    // Zeros take no bytes of a file: nothing but this says how many elements of them all accessors may ask for.
    void count_zeros(std::size_t elements, const JsonValue& place) const;
    // Says something once.
    void note(const std::string& text);
};

// Takes the file apart, reads its buffers and checks the version and the extensions that it requires.
void open_gltf(GltfDocument& document);

// The bytes of a bufferView, `index` being where it is named.
ByteSpan view_bytes(const GltfDocument& document, const JsonValue& index);
// The bytes of a data: URI; none where it is another URI. `uri` gives the place of what is wrong.
std::optional<std::vector<unsigned char>> decode_data_uri(const JsonValue& uri, std::string_view text);
// The path of the file that a relative URI names, beside the document.
std::string file_of_uri(const GltfDocument& document, const JsonValue& uri, std::string_view text);

// All numbers of an accessor, element after element, `components` of them in each: 1 to 4, or 16 of a matrix. Floats, or
// integers (`integers` lists the component types that may be) that are normalised, or not, where `plain` says so. `index` is
// where the accessor is named.
struct FloatsWanted {
    int components = 3;
    std::vector<int> integers{};
    bool plain = false;
};
std::vector<float> read_floats(const GltfDocument& document, const JsonValue& index, const FloatsWanted& wanted);
// Unsigned integers, each below `limit`, `components` of them in each element.
std::vector<std::uint32_t> read_integers(const GltfDocument& document, const JsonValue& index, std::size_t limit,
                                         const char* things, int components = 1);
std::size_t accessor_count(const GltfDocument& document, const JsonValue& index);

// How a material takes its texture coordinates.
struct TextureCoordinates {
    int set = 0;                                      // TEXCOORD_<set>
    glm::dvec2 offset{0}, scale{1};
    double rotation = 0;                              // radians
    friend bool operator==(const TextureCoordinates& a, const TextureCoordinates& b) {
        return a.set == b.set && a.offset == b.offset && a.scale == b.scale && a.rotation == b.rotation;
    }
};

// Fills the model's materials and textures; one TextureCoordinates for each material.
std::vector<TextureCoordinates> read_gltf_materials(GltfDocument& document, GltfModel& model);

// What moves a vertex of a skinned mesh.
struct SkinWeights {
    std::array<std::uint32_t, 4> joint{};
    std::array<float, 4> weight{};  // all 0: nothing moves it
};

// One mesh without its transform, as often as nodes ask for it.
struct GltfMesh {
    Mesh mesh;
    bool has_texture_coordinates = false;
    std::vector<glm::vec2> second_coordinates;  // GltfModel
    std::vector<SkinWeights> skin;              // of each vertex; empty: not asked for
};
struct MeshWanted {
    bool second_coordinates = false, skin = false;
};
GltfMesh read_gltf_mesh(GltfDocument& document, std::size_t index, GltfModel& model,
                        const std::vector<TextureCoordinates>& coordinates, const MeshWanted& wanted);

// Moves the vertices of a mesh to the world as skin `index` says while its joints stand where `to_world` has them, by node
// (glTF 2.0, 3.7.3.3); none: that node is in no scene.
void apply_gltf_skin(const GltfDocument& document, const JsonValue& index, const std::vector<std::optional<glm::dmat4>>& to_world,
                     const std::vector<SkinWeights>& weights, Mesh& mesh);

// The nodes of the default scene, parents first, each with its transform to world space.
struct GltfNode {
    std::size_t index;
    glm::dmat4 to_world;
};
std::vector<GltfNode> read_gltf_nodes(GltfDocument& document);

// What stands at a node.
Camera read_gltf_camera(const JsonValue& camera, const glm::dmat4& to_world);
Light read_gltf_light(const JsonValue& light, const glm::dmat4& to_world, const GltfOptions& options,
                      GltfDocument& document);

// v, or v made unit where it is not within what rounding to floats does; the zero vector stays.
glm::vec3 made_unit(const glm::dvec3& v);

}  // namespace plumb::io
