#include "whole.h"

#include <cmath>
#include <stdexcept>

namespace plumb::fuzz {
namespace {

void require(bool holds, const char* what) {
    if (!holds) throw std::logic_error(what);
}

bool finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool unit(const glm::vec3& v) { return std::fabs(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z - 1) < 1e-5; }

}  // namespace

void require_whole(const Mesh& mesh, const std::vector<Material>& materials, const std::vector<Texture>& textures) {
    for (const Vertex& v : mesh.vertices) {
        require(finite(v.position), "a position is not finite");
        require(unit(v.normal), "a normal is not of length 1");
        require(std::isfinite(v.u) && std::isfinite(v.v), "a texture coordinate is not finite");
    }
    require(mesh.tangents.empty() || mesh.tangents.size() == mesh.vertices.size(), "tangents for other vertices");
    for (const glm::vec4& t : mesh.tangents) require(finite(glm::vec3(t)) && std::fabs(t.w) <= 1, "a tangent is not finite");
    require(mesh.material.size() == mesh.triangles.size(), "materials for other triangles");
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) require(mesh.triangles[t][k] < mesh.vertices.size(), "a vertex is out of range");
        require(mesh.material[t] >= 0 && std::size_t(mesh.material[t]) < materials.size(), "a material is out of range");
    }
    for (int i = 0; i < 16; ++i) require(std::isfinite(mesh.transform[i / 4][i % 4]), "a transform is not finite");
    for (const Material& m : materials) {
        for (const glm::vec3& colour : {m.reflectance, m.emission, m.specular, m.mirror})
            for (int c = 0; c < 3; ++c) require(std::isfinite(colour[c]) && colour[c] >= 0, "a colour is not finite, or negative");
        for (const int texture : {m.texture, m.emission_texture, m.normal_texture})
            require(texture >= -1 && texture < int(textures.size()), "a texture is out of range");
        require(std::isfinite(m.exponent) && std::isfinite(m.normal_scale) && std::isfinite(m.alpha), "a number is not finite");
    }
    for (const Texture& t : textures)
        require(t.texels.width > 0 && t.texels.height > 0 &&
                    t.texels.size() == std::size_t(t.texels.width) * std::size_t(t.texels.height),
                "a texture without texels");
}

}  // namespace plumb::fuzz
