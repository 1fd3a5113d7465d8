// Splits triangles at the middles of their edges. An edge is split or not for all triangles at it, and its middle has the same
// float coordinates in all of them: no T-junction comes from it.
#pragma once

#include <cstdint>
#include <vector>

#include "gi/probes/surface_mesh.h"

namespace plumb::radiosity {

class TriangleSplit {
  public:
    // Works in world space: edges of two meshes whose transforms differ are split alike, too.
    explicit TriangleSplit(const Scene& scene);

    const Geometry& geometry() const { return geometry_; }
    // [triangle]: of which triangle of flatten(scene) it is a part.
    const std::vector<std::uint32_t>& origin() const { return origin_; }
    // Of all triangles, those without area too. Valid until the next split().
    probes::SurfaceMesh edges() const;

    // Whether both halves are shorter than 0.8 of the edge: where floats are coarse its middle may lie near an end.
    static bool can_split(const probes::SurfaceMesh& edges, std::uint32_t edge);
    static double squared_length(const probes::SurfaceMesh& edges, std::uint32_t edge);  // m2

    // How many triangles there would be.
    std::size_t count_after(const probes::SurfaceMesh& edges, const std::vector<char>& marked) const;
    // A triangle of one, two or three marked edges becomes 2, 3 or 4: its longest marked edge is joined to the corner opposite,
    // and the middles of others to the middle of that (Rivara 1984, 4-triangles longest-edge). marked: [edge].
    void split(const probes::SurfaceMesh& edges, const std::vector<char>& marked);

    // The scene with these triangles, meshes in their order and in world space.
    Scene take(const Scene& scene);

  private:
    std::uint32_t middle(std::uint32_t a, std::uint32_t b);
    std::vector<std::uint32_t> middles(const probes::SurfaceMesh& edges, const std::vector<char>& marked);
    void append_parts(std::size_t t, const std::uint32_t* middles, Geometry& to, std::vector<std::uint32_t>& origin) const;

    Geometry geometry_;
    std::vector<std::int32_t> object_;  // [vertex]
    std::vector<std::uint32_t> origin_;
};

}  // namespace plumb::radiosity
