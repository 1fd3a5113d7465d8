#include "tools/plumb/coloured_meshes.h"

#include "core/host_math.h"

namespace plumb::cli {
namespace {

constexpr std::uint32_t none = 0xffffffff;

class Maker {
  public:
    Maker(const Scene& scene, const frame::RadiosityBuffers& b) : b_(b), place_(b.elements.position.size(), none) {
        for (const Mesh& mesh : scene.meshes) meshes_.emplace_back().name = mesh.name;
    }

    std::vector<io::ColouredMesh> make() {
        const Geometry& g = b_.elements.geometry;
        for (std::size_t t = 0; t < g.triangles.size(); ++t) {
            io::ColouredMesh& mesh = meshes_[std::size_t(g.object[t])];
            glm::uvec3 corners;
            for (int k = 0; k < 3; ++k) corners[k] = vertex(mesh, b_.elements.of[t][k], g.vertices[g.triangles[t][k]].position);
            mesh.triangles.push_back(corners);
        }
        return std::move(meshes_);
    }

  private:
    // An element at a vertex is one of one mesh alone; one of a triangle has no vertex to share.
    std::uint32_t vertex(io::ColouredMesh& mesh, std::uint32_t element, const glm::vec3& position) {
        const bool shared = b_.elements.kind == radiosity::Kind::vertices;
        if (shared && place_[element] < mesh.position.size() && mesh.position[place_[element]] == position) return place_[element];
        const glm::vec3 h = glm::vec3(b_.lamps[element]) + glm::vec3(b_.irradiance[element]);
        mesh.position.push_back(position), mesh.normal.emplace_back(b_.elements.normal[element]);
        mesh.irradiance.push_back(h);
        glm::vec3 exitance(b_.elements.exitance[element]);
        if (!b_.elements.lamp_exitance.empty()) exitance += glm::vec3(b_.elements.lamp_exitance[element]);
        mesh.radiosity.push_back(exitance + glm::vec3(b_.elements.reflectance[element]) * h);
        return place_[element] = std::uint32_t(mesh.position.size() - 1);
    }

    const frame::RadiosityBuffers& b_;
    std::vector<io::ColouredMesh> meshes_;
    std::vector<std::uint32_t> place_;  // [element]: of its vertex
};

}  // namespace

std::vector<io::ColouredMesh> coloured_meshes(const Scene& scene, const frame::Frame& frame) {
    const frame::RadiosityBuffers& b = frame.radiosity;
    return b.irradiance.empty() ? std::vector<io::ColouredMesh>{} : Maker(scene, b).make();
}

float mesh_scale(const frame::Settings& settings) { return float(double(settings.tonemap.exposure) / host::pi); }

}  // namespace plumb::cli
