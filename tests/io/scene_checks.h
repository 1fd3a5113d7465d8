// What every generated scene has to hold, and rays against it by brute force.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>

#include "core/content_hash.h"
#include "core/scene.h"

namespace plumb {

inline std::int64_t triangle_count(const Scene& scene) {
    std::int64_t count = 0;
    for (const Mesh& mesh : scene.meshes) count += std::int64_t(mesh.triangles.size());
    return count;
}

// Indices in range, no triangle without area, unit normals on the side that the corners' order gives.
struct Faults {
    int index = 0, area = 0, normal = 0, side = 0, coordinate = 0;
};
inline Faults faults_of(const Scene& scene) {
    Faults faults;
    for (const Mesh& mesh : scene.meshes) {
        faults.index += mesh.material.size() != mesh.triangles.size();
        for (const Vertex& v : mesh.vertices) {
            const glm::dvec3 n(v.normal);
            faults.normal += !(std::abs(n.x * n.x + n.y * n.y + n.z * n.z - 1) < 1e-5);
            faults.coordinate += !(std::abs(v.u) < 1e4f && std::abs(v.v) < 1e4f);
        }
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const glm::uvec3 t = mesh.triangles[i];
            if (t.x >= mesh.vertices.size() || t.y >= mesh.vertices.size() || t.z >= mesh.vertices.size() ||
                mesh.material[i] < 0 || mesh.material[i] >= int(scene.materials.size())) {
                ++faults.index;
                continue;
            }
            const glm::dvec3 a(mesh.vertices[t.x].position), b(mesh.vertices[t.y].position),
                c(mesh.vertices[t.z].position);
            const glm::dvec3 n = glm::cross(b - a, c - a);
            faults.area += !(glm::dot(n, n) > 0);
            const glm::dvec3 shading = glm::dvec3(mesh.vertices[t.x].normal) + glm::dvec3(mesh.vertices[t.y].normal) +
                                       glm::dvec3(mesh.vertices[t.z].normal);
            faults.side += !(glm::dot(n, shading) > 0);
        }
    }
    for (const Material& m : scene.materials) faults.index += m.texture >= int(scene.textures.size());
    return faults;
}

inline std::uint64_t scene_hash(const Scene& scene) {
    std::uint64_t hash = 0;
    for (const Mesh& m : scene.meshes) {
        hash = content_hash(m.vertices.data(), m.vertices.size() * sizeof(Vertex), hash);
        hash = content_hash(m.triangles.data(), m.triangles.size() * sizeof(glm::uvec3), hash);
        hash = content_hash(m.material.data(), m.material.size() * sizeof(std::int32_t), hash);
    }
    for (const Texture& t : scene.textures) hash = content_hash(t.texels, hash);
    return hash;
}

// The first surface along a ray (Moeller and Trumbore 1997).
struct RayHit {
    double t = 1e30;
    bool front = false;
};
inline RayHit first_hit(const Scene& scene, const glm::dvec3& from, const glm::dvec3& d) {
    RayHit hit;
    for (const Mesh& mesh : scene.meshes)
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::dvec3 a(mesh.vertices[t.x].position), u = glm::dvec3(mesh.vertices[t.y].position) - a,
                v = glm::dvec3(mesh.vertices[t.z].position) - a, p = glm::cross(d, v);
            const double determinant = glm::dot(u, p);
            if (determinant == 0) continue;
            const glm::dvec3 s = from - a, q = glm::cross(s, u);
            const double x = glm::dot(s, p) / determinant, y = glm::dot(d, q) / determinant,
                         z = glm::dot(v, q) / determinant;
            if (x >= 0 && y >= 0 && x + y <= 1 && z > 1e-9 && z < hit.t) hit = {z, determinant > 0};
        }
    return hit;
}

}  // namespace plumb
