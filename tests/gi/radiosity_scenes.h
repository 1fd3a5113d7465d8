// Scenes of radiosity's closed forms: front faces where the light is, corners equal floats wherever triangles meet.
#pragma once

#include <array>
#include <cmath>

#include "core/scene.h"

namespace plumb::test {

using Point3 = glm::dvec3;

inline int add_material(Scene& s, double reflectance, double emission = 0) {
    Material m;
    m.reflectance = glm::vec3(float(reflectance)), m.emission = glm::vec3(float(emission));
    s.materials.push_back(m);
    return int(s.materials.size()) - 1;
}

// A parallelogram of columns x rows quads, two triangles each; its front is where u x v points. Vertices are shared within it.
inline Mesh grid(const Point3& from, const Point3& u, const Point3& v, int columns, int rows, int material) {
    Mesh m;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            Vertex vertex;
            vertex.position = glm::vec3(from + u * (double(i) / columns) + v * (double(j) / rows));
            vertex.normal = glm::vec3(glm::normalize(glm::cross(u, v)));
            vertex.u = float(i) / float(columns), vertex.v = float(j) / float(rows);
            m.vertices.push_back(vertex);
        }
    const auto at = [&](int i, int j) { return std::uint32_t(j * (columns + 1) + i); };
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            m.material.insert(m.material.end(), 2, material);
        }
    return m;
}

// Appends a mesh's triangles to another one.
inline void append(Mesh& to, const Mesh& from) {
    const auto first = std::uint32_t(to.vertices.size());
    to.vertices.insert(to.vertices.end(), from.vertices.begin(), from.vertices.end());
    for (const glm::uvec3& t : from.triangles) to.triangles.push_back(t + first);
    to.material.insert(to.material.end(), from.material.begin(), from.material.end());
}

// The inside of a cube [0, side]^3, n x n quads a face; faces in the order -x, +x, -y, +y, -z, +z, a mesh each unless `one`.
struct CubeFaces {
    std::array<double, 6> reflectance{}, emission{};
};
inline Scene cube(int n, const CubeFaces& faces, double side = 1, bool one = false) {
    Scene s;
    for (int f = 0; f < 6; ++f) {
        const int axis = f / 2;
        Point3 u(0), v(0), from(0);
        u[(axis + 1) % 3] = side, v[(axis + 2) % 3] = side;
        if (f % 2) std::swap(u, v), from[axis] = side;  // u x v points inwards
        const int material = add_material(s, faces.reflectance[std::size_t(f)], faces.emission[std::size_t(f)]);
        const Mesh face = grid(from, u, v, n, n, material);
        if (one && f > 0)
            append(s.meshes[0], face);
        else
            s.meshes.push_back(face);
    }
    return s;
}

// A sphere of 8 n^2 triangles (an octahedron blown up), 4 n^2 + 2 vertices, its front outside or inside. Corners lie on the sphere:
// its area is a little less, that of the polyhedron.
inline Mesh sphere(double radius, int n, bool inside, int material) {
    Mesh m;
    // Corner (i, j, n - i - j) of an octant; the others have its signs.
    const auto corner = [&](const glm::ivec3& sign, int i, int j) {
        const Point3 p = glm::normalize(Point3(i, j, n - i - j)) * Point3(sign);
        m.vertices.push_back({glm::vec3(radius * p), 0, glm::vec3(inside ? -p : p), 0});
        return std::uint32_t(m.vertices.size() - 1);
    };
    const auto add = [&](const glm::ivec3& sign, glm::ivec2 a, glm::ivec2 b, const glm::ivec2& c) {
        if ((sign.x * sign.y * sign.z < 0) != inside) std::swap(a, b);
        const std::uint32_t v0 = corner(sign, a.x, a.y), v1 = corner(sign, b.x, b.y), v2 = corner(sign, c.x, c.y);
        m.triangles.push_back({v0, v1, v2}), m.material.push_back(material);
    };
    for (int octant = 0; octant < 8; ++octant) {
        const glm::ivec3 sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j) {
                add(sign, {i, j}, {i + 1, j}, {i, j + 1});
                if (i + j + 1 < n) add(sign, {i + 1, j}, {i + 1, j + 1}, {i, j + 1});
            }
    }
    return m;
}

// Concentric spheres: mesh and material 0 the inner one, looking out, 1 the outer one, looking in.
inline Scene concentric_spheres(double r1, double r2, int n, double rho1, double rho2, double m1, double m2) {
    Scene s;
    s.meshes.push_back(sphere(r1, n, false, add_material(s, rho1, m1)));
    s.meshes.push_back(sphere(r2, n, true, add_material(s, rho2, m2)));
    return s;
}

// A floor z, x in [0, reach] at y = 0, and a wall x = 0 of that height on it: the foot is the z axis. Both are as long as high.
inline Scene floor_and_wall(double reach, int n, bool one_mesh) {
    Scene s;
    const int white = add_material(s, 0.5);
    const Mesh floor = grid({0, 0, -reach}, {0, 0, 2 * reach}, {reach, 0, 0}, 2 * n, n, white);
    const Mesh wall = grid({0, 0, -reach}, {0, reach, 0}, {0, 0, 2 * reach}, n, 2 * n, white);
    s.meshes.push_back(floor);
    if (one_mesh)
        append(s.meshes[0], wall);
    else
        s.meshes.push_back(wall);
    return s;
}

}  // namespace plumb::test
