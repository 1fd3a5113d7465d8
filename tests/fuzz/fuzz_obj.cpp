// OBJ and MTL. Each is tried with a fixed partner, so that changes are of one of them.
#include "core/error.h"
#include "io/obj.h"
#include "targets.h"
#include "whole.h"

namespace plumb::fuzz {
namespace {

std::size_t bytes_of(const io::ObjModel& model) {
    std::size_t bytes = model.mesh.vertices.size() * sizeof(Vertex) +
                        model.mesh.triangles.size() * (sizeof(glm::uvec3) + sizeof(std::int32_t)) +
                        model.materials.size() * sizeof(Material);
    for (const Texture& texture : model.textures) bytes += texture.texels.size() * 4;
    return bytes;
}

// A line of three bytes may become a corner of twelve.
constexpr std::size_t obj_growth = 4;

std::size_t read(const std::string& obj, const std::string& mtl) {
    const std::size_t file = obj.size() + mtl.size();
    // There is one library, by any name without a blank that does not begin with "no".
    const io::ReadLibrary library = [&](const std::string& name, std::int64_t, io::Findings*) -> std::optional<io::Library> {
        if (name.find(' ') != name.npos || name.substr(0, 2) == "no") return {};
        return io::Library{scratch_folder() + "/" + name, mtl};
    };
    try {
        const io::ObjModel model = io::parse_obj(scratch_folder() + "/a.obj", obj, library);
        require_whole(model.mesh, model.materials, model.textures);
        return file + bytes_of(model);
    } catch (const InputError&) {
        return obj_growth * file;
    }
}

}  // namespace

std::size_t fuzz_obj(const std::uint8_t* data, std::size_t size) {
    static const std::string mtl =
        "newmtl a\nKd 0.5 0.4 0.3\nnewmtl b c\nKd 1 1 1\nKs 0.1 0.1 0.1\nNs 10\nillum 2\nnewmtl m\nKe 1 1 1\n"
        "map_Kd -s 1e6 2 -o 0.5 a.png\n";
    return read(std::string(reinterpret_cast<const char*>(data), size), mtl);
}

std::size_t fuzz_mtl(const std::uint8_t* data, std::size_t size) {
    static const std::string obj =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 3e38\nvn 0 0 1\nf 1/1 2/2 3/3\nusemtl a\n"
        "f 1/1 2/2 3/3\nf 1/1/1 2/2/1 3/1/1\nusemtl b\nf 1/1/1 2/2/1 3/1/1\n";
    return read(obj, std::string(reinterpret_cast<const char*>(data), size));
}

}  // namespace plumb::fuzz
