// A chart as a plane figure in metres, and the rectangle of texels that it takes.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gi/probes/overlap.h"
#include "gi/probes/surface_mesh.h"

namespace plumb::probes {

struct ChartShape {
    bool own_uv = false;
    double metres = 1;                         // own_uv: a unit of the mesh's coordinates
    glm::dvec3 origin{0}, across{0}, down{0};  // otherwise: (x, y) = (p - origin) . (across, down)
    std::vector<std::uint32_t> triangles;      // of its mesh
    glm::dvec2 low{0}, high{0};                // bounds, m
    double area = 0;                           // m2 of the surface
    double inner_radius = 0;                   // m: of a circle that it holds, about the largest
    glm::dvec2 inner_centre{0};

    glm::dvec2 at(const Vertex& v) const {
        if (own_uv) return glm::dvec2(v.u, v.v) * metres;
        const glm::dvec3 d = glm::dvec3(v.position) - origin;
        return {glm::dot(d, across), glm::dot(d, down)};
    }
    PlaneTriangle triangle(const SurfaceMesh& mesh, std::uint32_t t) const {
        return {at(mesh.corner(3 * t)), at(mesh.corner(3 * t + 1)), at(mesh.corner(3 * t + 2))};
    }
};

// Part of a mesh that keeps its coordinates, scaled to metres.
ChartShape own_shape(const SurfaceMesh& mesh, double metres, std::vector<std::uint32_t> triangles);

// Projected onto the plane across `normal`, not mirrored as seen from the front, turned so that its bounding rectangle
// is the smallest of those along the 32 longest edges of its hull, and scaled to the area that the surface has
// (differs: so that curved charts have the density of flat ones; 1 for a flat chart, at most 1 / sqrt(cos angle)).
ChartShape planar_shape(const SurfaceMesh& mesh, const glm::dvec3& normal, std::vector<std::uint32_t> triangles);

// Whole texels for one or more shapes that stay together. A point p lies at p * scale + shift, in texels from the
// rectangle's corner.
struct TexelRectangle {
    glm::ivec2 size{1};
    glm::dvec2 shift{0};
    bool has_centre = true;  // each shape holds the centre of a texel, by texel_margin at least
};
inline constexpr double texel_margin = 1.0 / 128;  // the rasterizer's coordinates are whole 256ths of a texel
inline constexpr double texel_slack = 1.0 / 1024;  // what a chart may reach beyond its rectangle, in texels

// The figure lies in the middle of its rectangle. Where no triangle then holds the centre of a texel by texel_margin,
// the centre of the inner circle is put onto one; where that circle is smaller than the margin, has_centre is false.
TexelRectangle texel_rectangle(const SurfaceMesh& mesh, const ChartShape* shapes, std::size_t count, double scale);

// Finds inner_radius and inner_centre: of a circle inside one triangle, or, where that is small beside the figure, of
// one inside its cells on a grid of 32 x 32.
void find_inner_circle(const SurfaceMesh& mesh, ChartShape& shape);

}  // namespace plumb::probes
