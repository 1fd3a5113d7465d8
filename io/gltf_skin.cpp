// glTF's skins, in the pose that the nodes have. glTF 2.0, 3.7.3.
#include <fmt/format.h>

#include <cmath>

#include "io/gltf_document.h"

namespace plumb::io {
namespace {

// Of each joint: from the mesh's space to the world.
std::vector<glm::dmat4> joints_of(const GltfDocument& document, const JsonValue& skin,
                                  const std::vector<std::optional<glm::dmat4>>& to_world) {
    const JsonValue joints = skin["joints"].required(), bind = skin["inverseBindMatrices"];
    std::vector<glm::dmat4> result;
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const std::size_t node = *joints[i].index(to_world.size(), "nodes");
        if (!to_world[node]) joints[i].fail("is a node that is not in the scene");
        result.push_back(*to_world[node]);
    }
    if (!bind) return result;
    const std::vector<float> matrices = read_floats(document, bind, {16});
    if (matrices.size() < 16 * result.size())
        bind.fail(fmt::format("has {} matrices for {} joints", matrices.size() / 16, result.size()));
    for (std::size_t i = 0; i < result.size(); ++i) {
        glm::dmat4 m;
        for (int k = 0; k < 16; ++k) m[k / 4][k % 4] = double(matrices[16 * i + std::size_t(k)]);
        result[i] = result[i] * m;
    }
    return result;
}

}  // namespace

void apply_gltf_skin(const GltfDocument& document, const JsonValue& index, const std::vector<std::optional<glm::dmat4>>& to_world,
                     const std::vector<SkinWeights>& weights, Mesh& mesh) {
    const JsonValue skins = document.list("skins");
    const JsonValue skin = skins[*index.index(skins.size(), "skins")];
    const std::vector<glm::dmat4> joints = joints_of(document, skin, to_world);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const SkinWeights& of = weights[v];
        glm::dmat4 m(0);
        double sum = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if (of.weight[k] == 0) continue;
            if (of.joint[k] >= joints.size())
                skin.fail(fmt::format("a vertex has joint {}; there are {}", of.joint[k], joints.size()));
            m += joints[of.joint[k]] * double(of.weight[k]);
            sum += double(of.weight[k]);
        }
        if (!(sum > 0)) continue;
        m = m / sum;
        Vertex& vertex = mesh.vertices[v];
        const glm::dmat3 linear(m);
        vertex.position = glm::vec3(glm::dvec3(m * glm::dvec4(glm::dvec3(vertex.position), 1)));
        if (!(std::fabs(vertex.position.x) + std::fabs(vertex.position.y) + std::fabs(vertex.position.z) < 1e37f))
            skin.fail(fmt::format("moves vertex {} to where floats do not reach", v));
        // The matrix of cofactors: normals keep across the surface, whatever the joint's scale is.
        const glm::dvec3 n(vertex.normal);
        const glm::dvec3 turned = glm::cross(linear[1], linear[2]) * n.x + glm::cross(linear[2], linear[0]) * n.y +
                                  glm::cross(linear[0], linear[1]) * n.z;
        const glm::vec3 unit = made_unit(glm::determinant(linear) < 0 ? -turned : turned);
        if (unit != glm::vec3(0)) vertex.normal = unit;
        if (mesh.tangents.empty()) continue;
        glm::vec4& tangent = mesh.tangents[v];
        tangent = glm::vec4(made_unit(linear * glm::dvec3(tangent)), tangent.w);
    }
}

}  // namespace plumb::io
