#include "gi/radiosity/corner_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/host_math.h"

namespace plumb::radiosity {
namespace {

using probes::SurfaceMesh;
using probes::next_half_edge;

constexpr double of_cosines = 1e-6;    // by which two normals may miss the crease's angle
constexpr double two_sides = -0.999;   // cosine from which on two triangles are the sides of a sheet
constexpr double rises = 0.02;         // sine of the angle from which a triangle stands on a surface
constexpr std::uint32_t most_at_edge = 16;

class Groups {
  public:
    explicit Groups(std::size_t corners) : least_(corners) { std::iota(least_.begin(), least_.end(), 0u); }
    std::uint32_t find(std::uint32_t c) {
        for (; least_[c] != c; c = least_[c]) least_[c] = least_[least_[c]];
        return c;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        least_[std::max(a, b)] = std::min(a, b);
    }
    std::vector<std::uint32_t> take() {
        for (std::uint32_t c = 0; c < least_.size(); ++c) least_[c] = find(c);
        return std::move(least_);
    }

  private:
    std::vector<std::uint32_t> least_;
};

// Across the edge into the half edge's triangle, unit.
glm::dvec3 away_from_edge(const SurfaceMesh& m, std::uint32_t h) {
    const glm::dvec3 from(m.corner(h).position), to(m.corner(next_half_edge(h)).position);
    const glm::dvec3 across = glm::cross(m.normal[h / 3], to - from);
    return across / std::sqrt(glm::dot(across, across));
}

struct Edge {
    const SurfaceMesh& m;
    const std::uint32_t* begin;
    const std::uint32_t* end;

    bool one_surface(const Geometry& g, std::uint32_t a, std::uint32_t b, double least_cosine) const {
        const std::size_t t = m.first + a / 3, s = m.first + b / 3;
        return m.point[a] == m.point[next_half_edge(b)] && g.object[t] == g.object[s] && g.material[t] == g.material[s] &&
               glm::dot(m.normal[a / 3], m.normal[b / 3]) >= least_cosine;
    }
    // Whether another triangle at the edge rises in front of those of a and b.
    bool something_stands(std::uint32_t a, std::uint32_t b) const {
        const glm::dvec3 sum = m.normal[a / 3] + m.normal[b / 3];
        const double length = std::sqrt(glm::dot(sum, sum));
        return std::any_of(begin, end, [&](std::uint32_t c) {
            return c != a && c != b && m.area[c / 3] > 0 && glm::dot(away_from_edge(m, c), sum) > rises * length;
        });
    }
};

}  // namespace

CornerGroups corner_groups(const Geometry& geometry, const SurfaceMesh& m, double crease_deg) {
    const double least_cosine = std::max(two_sides, host::cos(crease_deg * (host::pi / 180)) - of_cosines);
    Groups groups(3 * m.count);
    CornerGroups out;
    out.goes_on.assign(3 * m.count, 0);
    for (std::size_t e = 0; e + 1 < m.edge_begin.size(); ++e) {
        const Edge edge{m, m.half_edges.data() + m.edge_begin[e], m.half_edges.data() + m.edge_begin[e + 1]};
        if (edge.end - edge.begin > most_at_edge) continue;
        for (const std::uint32_t* a = edge.begin; a < edge.end; ++a)
            for (const std::uint32_t* b = a + 1; b < edge.end; ++b) {
                if (!(m.area[*a / 3] > 0) || !(m.area[*b / 3] > 0) || !edge.one_surface(geometry, *a, *b, least_cosine)) continue;
                if (edge.end - edge.begin > 2 && edge.something_stands(*a, *b)) continue;
                groups.join(*a, next_half_edge(*b));
                groups.join(next_half_edge(*a), *b);
                out.goes_on[*a] = out.goes_on[*b] = 1;
            }
    }
    out.group = groups.take();
    return out;
}

namespace {

// Corners of triangles with area by a number that equal ones share; those without have no angle to bring in, and stay alone.
template <class Number>
CornerGroups by_number(const SurfaceMesh& m, std::size_t numbers, const Number& number) {
    CornerGroups out;
    out.group.resize(3 * m.count), out.goes_on.assign(3 * m.count, 0);
    std::vector<std::uint32_t> first(numbers, SurfaceMesh::no_edge);
    for (std::uint32_t c = 0; c < out.group.size(); ++c) {
        out.group[c] = c;
        if (!(m.area[c / 3] > 0)) continue;
        std::uint32_t& at = first[number(c)];
        if (at == SurfaceMesh::no_edge) at = c;
        out.group[c] = at;
    }
    for (std::size_t e = 0; e + 1 < m.edge_begin.size(); ++e) {
        const std::uint32_t* begin = m.half_edges.data() + m.edge_begin[e];
        const std::uint32_t* end = std::min(begin + most_at_edge, m.half_edges.data() + m.edge_begin[e + 1]);
        for (const std::uint32_t* a = begin; a < end; ++a)
            for (const std::uint32_t* b = a + 1; b < end; ++b) {
                const std::uint32_t c = next_half_edge(*a), d = next_half_edge(*b);
                const bool opposite = number(*a) == number(d) && number(c) == number(*b);
                const bool alike = number(*a) == number(*b) && number(c) == number(d);
                if (m.area[*a / 3] > 0 && m.area[*b / 3] > 0 && (opposite || alike)) out.goes_on[*a] = out.goes_on[*b] = 1;
            }
    }
    return out;
}

}  // namespace

CornerGroups corners_by_position(const SurfaceMesh& m) {
    return by_number(m, m.points, [&](std::uint32_t c) { return m.point[c]; });
}

CornerGroups corners_by_vertex(const Geometry& geometry, const SurfaceMesh& m) {
    return by_number(m, geometry.vertices.size(), [&](std::uint32_t c) { return geometry.triangles[c / 3][int(c % 3)]; });
}

}  // namespace plumb::radiosity
