#include "tools/bench_raster/load.h"

#include "io/scenes/generate.h"

namespace plumb::bench {

std::size_t Resident::bytes() const {
    return geometry.vertices.size() * sizeof(Vertex) +
           geometry.triangles.size() * (sizeof(glm::uvec3) + 2 * sizeof(std::int32_t)) +
           surfaces.texels.size() * sizeof(std::int32_t) + surfaces.materials.size() * sizeof(float);
}

Resident load(const std::string& name, std::int64_t triangles) {
    Resident out;
    out.name = name;
    io::GenerateOptions options;
    options.triangles = triangles;
    out.scene = io::generate_scene(name, options, "bench");
    for (Material& m : out.scene.materials) m.normal_texture = -1;
    for (Texture& t : out.scene.textures) t.mips = false;
    for (Mesh& mesh : out.scene.meshes) mesh.tangents = {};
    out.geometry = flatten(out.scene);
    out.surfaces = raster::prepare(out.scene, out.geometry);
    out.scene.meshes = {};
    return out;
}

bool can_build(const std::string& name, std::int64_t triangles) {
    for (const io::GeneratedScene& scene : io::generated_scenes())
        if (name == scene.name) return triangles >= scene.least_triangles && triangles <= scene.most_triangles;
    return false;
}

}  // namespace plumb::bench
