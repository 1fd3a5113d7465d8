#include "core/scene.h"

#include <algorithm>

namespace plumb {

Geometry flatten(const Scene& scene) {
    Geometry g;
    for (std::size_t object = 0; object < scene.meshes.size(); ++object) {
        const Mesh& mesh = scene.meshes[object];
        const std::uint32_t first = std::uint32_t(g.vertices.size());
        const glm::dmat3 linear(mesh.transform);
        const glm::dmat3 for_normals = glm::transpose(glm::inverse(linear));
        const bool identity = mesh.transform == glm::dmat4(1);
        for (Vertex v : mesh.vertices) {
            if (!identity) {
                const glm::dvec3 p(mesh.transform * glm::dvec4(glm::dvec3(v.position), 1));
                const glm::dvec3 n = for_normals * glm::dvec3(v.normal);
                const double length = __builtin_sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
                v.position = glm::vec3(p);
                v.normal = length > 0 ? glm::vec3(n / length) : v.normal;
            }
            g.vertices.push_back(v);
        }
        // A mirroring transform turns the triangles around: swap two corners, so that their front stays in front.
        const bool mirrored = glm::determinant(linear) < 0;
        const std::size_t drawn = std::size_t(mesh.share * double(mesh.triangles.size()));
        for (std::size_t t = 0; t < std::min(drawn, mesh.triangles.size()); ++t) {
            glm::uvec3 triangle = mesh.triangles[t] + glm::uvec3(first);
            if (mirrored) std::swap(triangle.y, triangle.z);
            g.triangles.push_back(triangle);
            g.material.push_back(mesh.material[t]);
            g.object.push_back(std::int32_t(object));
        }
    }
    return g;
}

bool bounds(const Geometry& g, glm::vec3& low, glm::vec3& high) {
    if (g.triangles.empty()) return false;
    low = high = g.vertices[g.triangles[0].x].position;
    for (const glm::uvec3& t : g.triangles)
        for (std::uint32_t i : {t.x, t.y, t.z}) {
            const glm::vec3 p = g.vertices[i].position;
            for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
        }
    return true;
}

}  // namespace plumb
