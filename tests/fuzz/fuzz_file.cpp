// Formats whose readers open a file by its name: it is put into the scratch folder. The first byte chooses the reader.
#include "core/error.h"
#include "io/bundle_file.h"
#include "io/camera_list.h"
#include "io/file.h"
#include "io/manifest.h"
#include "io/npy.h"
#include "io/scene_file.h"
#include "targets.h"

namespace plumb::fuzz {
namespace {

// A parsed value of TOML takes about a hundred bytes where its text has two.
constexpr std::size_t toml_growth = 64;

std::string put(const char* name, const std::uint8_t* data, std::size_t size) {
    const std::string path = scratch_folder() + "/" + name;
    io::write_file(path, {{reinterpret_cast<const char*>(data), size}});
    return path;
}

std::size_t bytes_of(const Scene& scene) {
    std::size_t bytes = 0;
    for (const Mesh& mesh : scene.meshes)
        bytes += sizeof(Mesh) + mesh.vertices.size() * sizeof(Vertex) + mesh.triangles.size() * 16;
    for (const Texture& texture : scene.textures) bytes += texture.texels.size() * 4;
    return bytes;
}

}  // namespace

std::size_t fuzz_toml(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::uint8_t* const text = data + 1;
    const std::size_t need = toml_growth * size;
    // A generated scene has as many triangles as its file asks for: that is honest work, and not what is tried here.
    if (std::string_view(reinterpret_cast<const char*>(text), size - 1).find("triangles") != std::string_view::npos) return need;
    try {
        switch (data[0] % 4) {
            case 0: return need + bytes_of(io::load_scene(put("a.toml", text, size - 1), {"rsm", "shadow"}));
            case 1: io::read_camera_list(put("cameras.toml", text, size - 1)); break;
            case 2: io::read_manifest(put("manifest.toml", text, size - 1)); break;
            default: io::read_manifest(put("manifest.json", text, size - 1)); break;
        }
    } catch (const InputError&) {
    }
    return need;
}

std::size_t fuzz_array(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    try {
        if (data[0] % 2 == 0)
            io::read_npy(put("a.npy", data + 1, size - 1));
        else
            io::read_bundle(put("a.bundle", data + 1, size - 1));
    } catch (const InputError&) {
    }
    return 16 * size;
}

}  // namespace plumb::fuzz
