// Meshes for tests of charts, and what holds of every cut into charts.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "gi/probes/planar_charts.h"
#include "gi/probes/plane_cover.h"
#include "tests/gi/random_scene.h"

namespace plumb::test {

using namespace probes;

// Area that two triangles share, by cutting one with the sides of the other (Sutherland and Hodgman 1974): apart from
// overlap(), which looks for a side that separates them.
inline double shared_area(PlaneTriangle a, const PlaneTriangle& b) {
    if (twice_area(a) < 0) std::swap(a[1], a[2]);
    std::vector<glm::dvec2> piece(b.begin(), b.end());
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 from = a[i], side = a[(i + 1) % 3] - from;
        auto depth = [&](const glm::dvec2& p) { return side.x * (p.y - from.y) - side.y * (p.x - from.x); };
        std::vector<glm::dvec2> cut;
        for (std::size_t k = 0; k < piece.size(); ++k) {
            const glm::dvec2 p = piece[k], q = piece[(k + 1) % piece.size()];
            if (depth(p) >= 0) cut.push_back(p);
            if ((depth(p) >= 0) != (depth(q) >= 0)) cut.push_back(p + (q - p) * (depth(p) / (depth(p) - depth(q))));
        }
        piece = cut;
    }
    double twice = 0;
    for (std::size_t k = 0; k < piece.size(); ++k) {
        const glm::dvec2 p = piece[k], q = piece[(k + 1) % piece.size()];
        twice += p.x * q.y - p.y * q.x;
    }
    return std::fabs(twice) / 2;
}

inline PlaneTriangle random_triangle(test::Dice& dice, float size) {
    const glm::vec3 at = dice.in_box({0, 0, 0}, {1, 1, 0});
    PlaneTriangle t;
    for (glm::dvec2& p : t) {
        const glm::vec3 q = at + dice.in_box(glm::vec3(-size, -size, 0), glm::vec3(size, size, 0));
        p = {q.x, q.y};
    }
    return t;
}

inline Geometry geometry_of(const Mesh& mesh) {
    Scene scene;
    scene.meshes.push_back(mesh);
    return flatten(scene);
}
// Keeps the geometry that it reads.
struct Surface {
    Geometry geometry;
    SurfaceMesh mesh;
    explicit Surface(const Mesh& m)
        : geometry(geometry_of(m)), mesh(surface_mesh(geometry, 0, 0, geometry.triangles.size())) {}
};

// A grid of quads over [0, 1]^2 with shared vertices; `at` places it.
template <class At>
Mesh sheet(int columns, int rows, const At& at) {
    Mesh mesh;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float u = float(i) / float(columns), v = float(j) / float(rows);
            mesh.vertices.push_back({at(double(u), double(v)), u, {0, 1, 0}, v});
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const unsigned a = unsigned(j * (columns + 1) + i), b = a + unsigned(columns) + 1;
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({a + 1, b, b + 1});
            mesh.material.insert(mesh.material.end(), 2, 0);
        }
    return mesh;
}

inline void add_triangle(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const unsigned first = unsigned(mesh.vertices.size());
    for (const glm::vec3& p : {a, b, c}) mesh.vertices.push_back({p, 0, {0, 1, 0}, 0});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.material.push_back(0);
}

inline void set_uv(Mesh& mesh, std::size_t vertex, float u, float v) {
    mesh.vertices[vertex].u = u, mesh.vertices[vertex].v = v;
}

// No two triangles of a chart share area on its plane, and all face it within the angle.
inline void check_charts(const SurfaceMesh& mesh, const PlanarCharts& charts, double angle_deg) {
    std::map<int, std::vector<PlaneTriangle>> planes;
    double shared = 0;
    for (std::uint32_t t = 0; t < mesh.count; ++t) {
        REQUIRE((charts.of[t] >= 0) == (mesh.area[t] > 0));
        if (charts.of[t] < 0) continue;
        const glm::dvec3 n = charts.normal[std::size_t(charts.of[t])];
        CHECK(glm::dot(n, mesh.normal[t]) >= host::cos(angle_deg * host::pi / 180) - 1e-12);
        glm::dvec3 x, y;
        plane_axes(n, x, y);
        PlaneTriangle p;
        for (int k = 0; k < 3; ++k)
            p[std::size_t(k)] = {glm::dot(mesh.position(t, k), x), glm::dot(mesh.position(t, k), y)};
        for (const PlaneTriangle& other : planes[charts.of[t]]) shared = std::max(shared, shared_area(p, other));
        planes[charts.of[t]].push_back(p);
    }
    CHECK(shared < 1e-9);
}

}  // namespace plumb::test
