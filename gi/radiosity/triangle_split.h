// Splits triangles at the middles of their edges. An edge is split or not for all triangles at it, and its middle has the same
// float coordinates in all of them: no T-junction comes from it.
#pragma once

#include <cstdint>
#include <vector>

#include "gi/probes/surface_mesh.h"

namespace plumb::radiosity {

// Throws InputError where splitting makes more triangles than that.
void require_at_most(std::size_t triangles, std::int64_t most);

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

    // The same at points of edges: at[edge], where marked. Texture coordinates, normals and tangents are those of the edge there.
    void split_at(const probes::SurfaceMesh& edges, const std::vector<char>& marked, const std::vector<glm::vec3>& at);
    // Points inside of triangles, at most one each: it becomes three.
    struct Inside {
        std::uint32_t triangle = 0;
        glm::vec3 at{0};
    };
    void insert(const std::vector<Inside>& points);

    // The scene with these triangles, meshes in their order and in world space.
    Scene take(const Scene& scene);

  private:
    std::uint32_t middle(std::uint32_t a, std::uint32_t b);
    // A vertex at p, the mean of a triangle's or an edge's vertices by those weights.
    std::uint32_t mean(const glm::uvec3& of, const glm::dvec3& weights, const glm::vec3& p);
    std::uint32_t on_edge(std::uint32_t a, std::uint32_t b, const glm::vec3& p);
    // make(a, b, edge): the new vertex between two.
    template <class Make>
    std::vector<std::uint32_t> middles(const probes::SurfaceMesh& edges, const std::vector<char>& marked, const Make& make);
    void split(const probes::SurfaceMesh& edges, const std::vector<char>& marked, const std::vector<std::uint32_t>& middles);
    void append_parts(std::size_t t, const std::uint32_t* middles, Geometry& to, std::vector<std::uint32_t>& origin) const;

    Geometry geometry_;
    std::vector<std::int32_t> object_;  // [vertex]
    std::vector<std::uint32_t> origin_;
};

}  // namespace plumb::radiosity
