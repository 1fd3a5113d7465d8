#include "gi/probes/own_uv.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gi/probes/overlap.h"

namespace plumb::probes {
namespace {

double length(const glm::dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }
double length(const glm::dvec3& v) { return std::sqrt(glm::dot(v, v)); }

glm::dvec2 uv_of(const Vertex& v) { return {v.u, v.v}; }

PlaneTriangle uv_triangle(const SurfaceMesh& m, std::size_t t) {
    const std::uint32_t h = std::uint32_t(3 * t);
    return {uv_of(m.corner(h)), uv_of(m.corner(h + 1)), uv_of(m.corner(h + 2))};
}

double longest_side(const PlaneTriangle& t) {
    return std::max({length(t[1] - t[0]), length(t[2] - t[1]), length(t[0] - t[2])});
}

// The largest |u| or |v| of triangles with area; infinity where one is not finite.
double largest_coordinate(const SurfaceMesh& m) {
    double largest = 0;
    for (std::size_t t = 0; t < m.count; ++t)
        for (int k = 0; k < 3 && m.area[t] > 0; ++k) {
            const Vertex& v = m.corner(std::uint32_t(3 * t) + std::uint32_t(k));
            if (!(v.u - v.u == 0 && v.v - v.v == 0)) return HUGE_VAL;
            largest = std::max({largest, std::fabs(double(v.u)), std::fabs(double(v.v))});
        }
    return largest;
}

bool all_have_height(const SurfaceMesh& m, double tolerance) {
    for (std::size_t t = 0; t < m.count; ++t) {
        if (m.area[t] == 0) continue;
        const PlaneTriangle uv = uv_triangle(m, t);
        if (!(std::fabs(twice_area(uv)) > longest_side(uv) * tolerance)) return false;
    }
    return true;
}

// The ends of a half edge in the plane, from the lower point to the higher one.
std::array<glm::dvec2, 2> ends(const SurfaceMesh& m, std::uint32_t h) {
    const std::uint32_t n = next_half_edge(h);
    std::array<glm::dvec2, 2> e{uv_of(m.corner(h)), uv_of(m.corner(n))};
    if (m.point[h] > m.point[n]) std::swap(e[0], e[1]);
    return e;
}

// sum |e|/|j| / |E|. An edge at a seam has several j, and counts once for each.
double mean_edge_ratio(const SurfaceMesh& m) {
    double sum = 0;
    std::int64_t edges = 0;
    for (std::size_t e = 0; e + 1 < m.edge_begin.size(); ++e)
        for (std::uint32_t i = m.edge_begin[e]; i < m.edge_begin[e + 1]; ++i) {
            const std::uint32_t h = m.half_edges[i], n = next_half_edge(h);
            const auto j = ends(m, h);
            bool known = false;
            const std::uint32_t from = std::max(m.edge_begin[e], i >= 8 ? i - 8 : 0);
            for (std::uint32_t before = from; before < i && !known; ++before)
                known = ends(m, m.half_edges[before]) == j;
            if (known) continue;
            sum += length(glm::dvec3(m.corner(n).position) - glm::dvec3(m.corner(h).position)) / length(j[1] - j[0]);
            ++edges;
        }
    return sum / double(edges);
}

// The most metres that a unit step in the plane covers on the triangle: the larger singular value of the mapping from
// the plane, whose columns are P = de/du and Q = de/dv.
double largest_step(const SurfaceMesh& m, std::size_t t) {
    const PlaneTriangle uv = uv_triangle(m, t);
    const glm::dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const glm::dvec3 e = m.position(t, 1) - m.position(t, 0), f = m.position(t, 2) - m.position(t, 0);
    const double twice = twice_area(uv);
    const glm::dvec3 p = (e * b.y - f * a.y) / twice, q = (f * a.x - e * b.x) / twice;
    const double pp = glm::dot(p, p), qq = glm::dot(q, q), pq = glm::dot(p, q), half = (pp - qq) / 2;
    return std::sqrt((pp + qq) / 2 + std::sqrt(half * half + pq * pq));
}

bool stretched(const SurfaceMesh& m, double metres) {
    double area = 0, plane = 0;
    for (std::size_t t = 0; t < m.count; ++t) {
        if (m.area[t] == 0) continue;
        if (!(largest_step(m, t) <= largest_stretch * metres)) return true;
        area += m.area[t], plane += std::fabs(twice_area(uv_triangle(m, t))) / 2;
    }
    return !(plane * metres * metres <= largest_area_ratio * area);
}

bool overlapping(const SurfaceMesh& m, double tolerance) {
    std::vector<PlaneTriangle> triangles;
    for (std::size_t t = 0; t < m.count; ++t)
        if (m.area[t] > 0) triangles.push_back(uv_triangle(m, t));
    return any_overlap(triangles, tolerance);
}

}  // namespace

void find_islands(const SurfaceMesh& m, UvIslands& islands) {
    std::vector<std::uint32_t> parent(m.count);
    std::iota(parent.begin(), parent.end(), 0u);
    auto root = [&](std::uint32_t t) {
        while (parent[t] != t) t = parent[t] = parent[parent[t]];
        return t;
    };
    for (std::size_t e = 0; e + 1 < m.edge_begin.size(); ++e)
        for (std::uint32_t i = m.edge_begin[e]; i < m.edge_begin[e + 1]; ++i)
            for (std::uint32_t k = i + 1; k < std::min(m.edge_begin[e + 1], i + 8); ++k)
                if (ends(m, m.half_edges[i]) == ends(m, m.half_edges[k])) {
                    const std::uint32_t a = root(m.half_edges[i] / 3), b = root(m.half_edges[k] / 3);
                    parent[std::max(a, b)] = std::min(a, b);
                }
    islands.of.assign(m.count, -1);
    std::vector<double> signed_area;
    for (std::uint32_t t = 0; t < m.count; ++t) {
        if (m.area[t] == 0) continue;
        std::int32_t& of_root = islands.of[root(t)];  // the root is the island's first triangle
        if (of_root < 0) of_root = islands.count++, signed_area.push_back(0);
        islands.of[t] = of_root;
        signed_area[std::size_t(of_root)] += twice_area(uv_triangle(m, t));
    }
    // v points down: a front whose corners turn counter-clockwise has a negative area.
    for (double a : signed_area) islands.mirrored += a > 0;
}

UvIslands judge_own_uv(const SurfaceMesh& mesh) {
    UvIslands islands;
    const double largest = largest_coordinate(mesh), tolerance = largest * 0x1p-22;
    islands.verdict = OwnUv::degenerate;
    if (mesh.half_edges.empty() || largest == 0 || largest == HUGE_VAL || !all_have_height(mesh, tolerance))
        return islands;
    islands.metres = mean_edge_ratio(mesh);
    islands.verdict = OwnUv::stretched;
    if (stretched(mesh, islands.metres)) return islands;
    islands.verdict = OwnUv::overlapping;
    if (overlapping(mesh, tolerance)) return islands;
    islands.verdict = OwnUv::kept;
    find_islands(mesh, islands);
    return islands;
}

}  // namespace plumb::probes
