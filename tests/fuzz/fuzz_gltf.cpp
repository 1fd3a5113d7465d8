// glTF as JSON and as GLB. Files that they name are looked for where none can be.
#include "core/error.h"
#include "io/gltf.h"
#include "targets.h"
#include "whole.h"

namespace plumb::fuzz {
namespace {

std::size_t bytes_of(const io::GltfModel& model) {
    std::size_t bytes = model.materials.size() * sizeof(Material) + model.lights.size() * sizeof(Light);
    for (const Mesh& mesh : model.meshes)
        bytes += sizeof(Mesh) + mesh.vertices.size() * sizeof(Vertex) + mesh.tangents.size() * sizeof(glm::vec4) +
                 mesh.triangles.size() * (sizeof(glm::uvec3) + sizeof(std::int32_t));
    for (const auto& coordinates : model.second_coordinates) bytes += coordinates.size() * sizeof(glm::vec2);
    for (const Texture& texture : model.textures) bytes += texture.texels.size() * 4;
    return bytes;
}

// A parsed value of JSON has sixteen bytes where its text has two ("0,").
constexpr std::size_t json_growth = 8;

std::size_t read(const std::string& name, const std::uint8_t* data, std::size_t size) {
    io::GltfOptions options;
    options.second_coordinates = true;
    try {
        const io::GltfModel model = io::parse_gltf("/dev/null/" + name, {data, data + size}, options);
        for (const Mesh& mesh : model.meshes) require_whole(mesh, model.materials, model.textures);
        return json_growth * size + bytes_of(model);
    } catch (const InputError&) {
        return json_growth * size;
    }
}

}  // namespace

std::size_t fuzz_gltf(const std::uint8_t* data, std::size_t size) { return read("a.gltf", data, size); }
std::size_t fuzz_glb(const std::uint8_t* data, std::size_t size) { return read("a.glb", data, size); }

}  // namespace plumb::fuzz
