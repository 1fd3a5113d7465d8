#include "gi/zbuffer/vertex_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "raster/surface_kernel.h"

namespace plumb::zbuffer {

namespace {

// Of any scale: kernels make what they multiply unit again.
void add_rows(const glm::dmat3& m, Buffer<glm::vec4>& rows) {
    double largest = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) largest = std::max(largest, std::fabs(m[c][r]));
    const double scale = largest > 0 ? 1 / largest : 1;
    for (int r = 0; r < 3; ++r) rows.emplace_back(glm::vec3(glm::dvec3(m[0][r], m[1][r], m[2][r]) * scale), 0.0f);
}

glm::vec3 face_of(const Geometry& g, const glm::uvec3& t) {
    const glm::vec3 a = g.vertices[t.x].position;
    return raster::normalised(raster::face_normal(g.vertices[t.y].position - a, g.vertices[t.z].position - a));
}

}  // namespace

VertexTable vertex_table(const Scene& scene, const Geometry& g) {
    VertexTable t;
    for (const Material& m : scene.materials) {
        t.materials.emplace_back(m.reflectance, 0.0f);
        t.materials.emplace_back(m.specular, m.exponent);
    }
    for (const Mesh& mesh : scene.meshes) {
        const glm::dmat3 m(mesh.transform);
        add_rows(m * glm::transpose(m), t.objects);
        add_rows(m, t.objects);
    }
    // Of each vertex of the geometry the last that it became, and of each of those the one before.
    std::vector<std::int32_t> last(g.vertices.size(), -1), before;
    t.corners.reserve(g.triangles.size());
    for (std::size_t i = 0; i < g.triangles.size(); ++i) {
        const std::int32_t material = g.material[i];
        if (material < 0 || std::size_t(material) >= scene.materials.size())
            throw InputError(fmt::format("zbuffer: triangle {}: material {}: expected one of {}", i, material, scene.materials.size()));
        glm::ivec4 corners(0);
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = g.triangles[i][k];
            const Vertex& vertex = g.vertices[v];
            const bool given = glm::dot(vertex.normal, vertex.normal) > 0;
            std::int32_t at = given ? last[v] : -1;
            while (at >= 0 && t.kinds[std::size_t(at)].x != material) at = before[std::size_t(at)];
            if (at < 0) {
                at = std::int32_t(t.kinds.size());
                t.vertices.emplace_back(vertex.position, 0.0f);
                t.vertices.emplace_back(given ? vertex.normal : face_of(g, g.triangles[i]), 0.0f);
                t.kinds.emplace_back(material, g.object[i]);
                before.push_back(last[v]);
                if (given) last[v] = at;
            }
            corners[k] = at;
        }
        t.corners.push_back(corners);
    }
    return t;
}

}  // namespace plumb::zbuffer
