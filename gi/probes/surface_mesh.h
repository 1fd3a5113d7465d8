// One object's triangles as a surface: which have an area, where they face, and which share an edge.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/scene.h"

namespace plumb::probes {

// Triangles are counted from the object's first one. Half edge 3 t + k runs from corner k of triangle t to the next.
struct SurfaceMesh {
    const Geometry* geometry = nullptr;
    int object = 0;
    std::size_t first = 0, count = 0;  // of Geometry::triangles

    // m2. 0 where a triangle has no area to speak of: its height is within four roundings of its largest coordinate
    // (2^-22 of it), so that its corners may as well lie on a line.
    std::vector<double> area;
    std::vector<glm::dvec3> normal;  // unit, by the order of the corners; 0 where there is no area

    // Half edges of triangles with area (or of all, where asked), edge by edge; corners are the same point where their
    // positions are equal floats.
    std::vector<std::uint32_t> half_edges;
    std::vector<std::uint32_t> edge_begin;  // [edge + 1]: index into half_edges
    std::vector<std::uint32_t> edge_of;     // [half edge]; no_edge for triangles without area
    std::vector<std::uint32_t> point;       // [half edge]: of the corner where it begins
    std::size_t points = 0;
    bool flat_too = false;  // triangles without area have edges and points, too
    static constexpr std::uint32_t no_edge = 0xffffffff;

    bool has_edges(std::size_t t) const { return flat_too || area[t] > 0; }
    glm::uvec3 corners(std::size_t t) const { return geometry->triangles[first + t]; }
    const Vertex& corner(std::uint32_t half_edge) const {
        return geometry->vertices[corners(half_edge / 3)[int(half_edge % 3)]];
    }
    glm::dvec3 position(std::size_t t, int k) const {
        return glm::dvec3(corner(std::uint32_t(3 * t) + std::uint32_t(k)).position);
    }
};

// Half edge of the next corner of the same triangle.
inline std::uint32_t next_half_edge(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }

SurfaceMesh surface_mesh(const Geometry& geometry, int object, std::size_t first, std::size_t count, bool flat_too = false);

}  // namespace plumb::probes
