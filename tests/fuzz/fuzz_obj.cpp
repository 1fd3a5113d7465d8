// OBJ and MTL. Each is tried with a fixed partner, so that changes are of one of them.
#include "core/error.h"
#include "io/obj.h"
#include "targets.h"

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
    try {
        return file + bytes_of(io::parse_obj(scratch_folder() + "/a.obj", obj, [&](const std::string&) { return mtl; }));
    } catch (const InputError&) {
        return obj_growth * file;
    }
}

}  // namespace

std::size_t fuzz_obj(const std::uint8_t* data, std::size_t size) {
    static const std::string mtl =
        "newmtl a\nKd 0.5 0.4 0.3\nnewmtl b c\nKd 1 1 1\nKs 0.1 0.1 0.1\nNs 10\nillum 2\nnewmtl m\nKe 1 1 1\nmap_Kd a.png\n";
    return read(std::string(reinterpret_cast<const char*>(data), size), mtl);
}

std::size_t fuzz_mtl(const std::uint8_t* data, std::size_t size) {
    static const std::string obj =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nusemtl a\nf 1/1 2/2 3/3\n"
        "usemtl b\nf 1 2 3\n";
    return read(obj, std::string(reinterpret_cast<const char*>(data), size));
}

}  // namespace plumb::fuzz
