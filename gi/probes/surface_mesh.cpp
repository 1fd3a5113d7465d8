#include "gi/probes/surface_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace plumb::probes {
namespace {

using Ids = std::vector<std::uint32_t>;

double squared(const glm::dvec3& v) { return glm::dot(v, v); }

void measure(SurfaceMesh& m, std::size_t t) {
    glm::dvec3 p[3];
    double largest = 0;
    for (int k = 0; k < 3; ++k) {
        p[k] = m.position(t, k);
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::fabs(p[k][c]));
    }
    const glm::dvec3 across = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double twice = std::sqrt(squared(across));
    const double longest = std::sqrt(std::max({squared(p[1] - p[0]), squared(p[2] - p[1]), squared(p[0] - p[2])}));
    if (!(twice > longest * (largest * 0x1p-22))) return;
    m.area[t] = twice / 2;
    m.normal[t] = across / twice;
}

// Positions to numbers, in the order in which they come.
class Points {
  public:
    explicit Points(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), empty) {}
    std::uint32_t number(const glm::vec3& position) {
        std::array<std::uint32_t, 3> key;
        for (int c = 0; c < 3; ++c) key[std::size_t(c)] = std::bit_cast<std::uint32_t>(position[c] + 0.0f);  // -0 is 0
        std::uint64_t hash = key[0];
        for (std::size_t c = 1; c < 3; ++c) hash = (hash ^ hash >> 29) * 0x9e3779b97f4a7c15u + key[c];
        hash = (hash ^ hash >> 32) * 0x9e3779b97f4a7c15u;
        for (std::size_t slot = hash >> 20;; ++slot) {
            std::uint32_t& at = slots_[slot & (slots_.size() - 1)];
            if (at == empty) {
                at = std::uint32_t(keys_.size());
                keys_.push_back(key);
            }
            if (keys_[at] == key) return at;
        }
    }
    std::size_t count() const { return keys_.size(); }

  private:
    static constexpr std::uint32_t empty = 0xffffffff;
    Ids slots_;
    std::vector<std::array<std::uint32_t, 3>> keys_;
};

// Numbers the points of all triangles with area; a vertex is looked up once.
std::size_t number_points(SurfaceMesh& m) {
    std::uint32_t low = 0xffffffff, high = 0;
    for (std::size_t t = 0; t < m.count; ++t)
        for (int k = 0; k < 3; ++k) low = std::min(low, m.corners(t)[k]), high = std::max(high, m.corners(t)[k]);
    if (low > high) return 0;
    Ids of_vertex(std::size_t(high - low) + 1, 0xffffffff);
    Points points(std::min(of_vertex.size(), 3 * m.count));
    for (std::size_t t = 0; t < m.count; ++t)
        for (int k = 0; k < 3 && m.has_edges(t); ++k) {
            const std::uint32_t v = m.corners(t)[k];
            std::uint32_t& p = of_vertex[v - low];
            if (p == 0xffffffff) p = points.number(m.geometry->vertices[v].position);
            m.point[3 * t + std::size_t(k)] = p;
        }
    return points.count();
}

// Sorts half edges by their lower point, then by the higher one, and numbers the edges.
void link_edges(SurfaceMesh& m, std::size_t points) {
    auto ends = [&](std::uint32_t h) {
        const std::uint32_t a = m.point[h], b = m.point[next_half_edge(h)];
        return std::array{std::min(a, b), std::max(a, b)};
    };
    Ids begin(points + 1, 0);
    for (std::uint32_t h = 0; h < 3 * m.count; ++h)
        if (m.has_edges(h / 3)) ++begin[ends(h)[0] + 1];
    for (std::size_t p = 0; p < points; ++p) begin[p + 1] += begin[p];
    m.half_edges.resize(begin[points]);
    Ids at(begin.begin(), begin.end() - 1);
    for (std::uint32_t h = 0; h < 3 * m.count; ++h)
        if (m.has_edges(h / 3)) m.half_edges[at[ends(h)[0]]++] = h;
    for (std::size_t p = 0; p < points; ++p)
        std::sort(m.half_edges.begin() + begin[p], m.half_edges.begin() + begin[p + 1],
                  [&](std::uint32_t a, std::uint32_t b) {
                      const std::uint32_t high_a = ends(a)[1], high_b = ends(b)[1];
                      return high_a != high_b ? high_a < high_b : a < b;
                  });
    for (std::uint32_t i = 0; i < m.half_edges.size(); ++i) {
        if (i == 0 || ends(m.half_edges[i]) != ends(m.half_edges[i - 1])) m.edge_begin.push_back(i);
        m.edge_of[m.half_edges[i]] = std::uint32_t(m.edge_begin.size() - 1);
    }
    m.edge_begin.push_back(std::uint32_t(m.half_edges.size()));
}

}  // namespace

SurfaceMesh surface_mesh(const Geometry& geometry, int object, std::size_t first, std::size_t count, bool flat_too) {
    SurfaceMesh m;
    m.geometry = &geometry, m.object = object, m.first = first, m.count = count, m.flat_too = flat_too;
    m.area.assign(count, 0), m.normal.assign(count, glm::dvec3(0));
    for (std::size_t t = 0; t < count; ++t) measure(m, t);
    m.edge_of.assign(3 * count, SurfaceMesh::no_edge), m.point.assign(3 * count, 0);
    m.points = number_points(m);
    link_edges(m, m.points);
    return m;
}

}  // namespace plumb::probes
