#include "io/triangulate.h"

#include <cmath>
#include <numeric>

namespace plumb::io {
namespace {

// Twice the signed area of a, b, c.
double area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Newell's normal: its components are twice the areas of the projections along the axes.
glm::dvec3 newell(const std::vector<glm::vec3>& p) {
    glm::dvec3 n(0);
    for (std::size_t i = 0; i < p.size(); ++i) {
        const glm::dvec3 a(p[i]), b(p[(i + 1) % p.size()]);
        n.x += (a.y - b.y) * (a.z + b.z);
        n.y += (a.z - b.z) * (a.x + b.x);
        n.z += (a.x - b.x) * (a.y + b.y);
    }
    return n;
}

// Drops the axis along which the polygon shows its largest area; turns it so that it runs counter-clockwise.
std::vector<glm::dvec2> flattened(const std::vector<glm::vec3>& p) {
    const glm::dvec3 n = newell(p);
    const double x = std::fabs(n.x), y = std::fabs(n.y), z = std::fabs(n.z);
    const int axis = x > y && x > z ? 0 : y > z ? 1 : 2;
    const int u = n[axis] < 0 ? (axis + 2) % 3 : (axis + 1) % 3, v = 3 - axis - u;
    std::vector<glm::dvec2> flat;
    flat.reserve(p.size());
    for (const glm::vec3& q : p) flat.emplace_back(q[u], q[v]);
    return flat;
}

// Turns left at every corner and goes around once: the direction of the edges crosses the x axis twice.
bool convex(const std::vector<glm::dvec2>& p) {
    const std::size_t n = p.size();
    int crossings = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const glm::dvec2 a = p[i], b = p[(i + 1) % n], c = p[(i + 2) % n];
        if (!(area(a, b, c) >= 0)) return false;
        crossings += (b.y - a.y < 0) != (c.y - b.y < 0);
    }
    return crossings <= 2;
}

bool inside(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0;
}

// No other corner of what is left lies in the triangle at corner k, and the polygon turns left there.
bool is_ear(const std::vector<glm::dvec2>& p, const std::vector<std::uint32_t>& left, std::size_t k) {
    const std::size_t n = left.size(), before = (k + n - 1) % n, after = (k + 1) % n;
    const glm::dvec2 a = p[left[before]], b = p[left[k]], c = p[left[after]];
    if (!(area(a, b, c) > 0)) return false;
    for (std::size_t i = 0; i < n; ++i) {
        if (i == before || i == k || i == after) continue;
        const glm::dvec2 q = p[left[i]];
        if (q != a && q != b && q != c && inside(q, a, b, c)) return false;
    }
    return true;
}

}  // namespace

bool triangulate(const std::vector<glm::vec3>& corners, std::vector<std::array<std::uint32_t, 3>>& triangles) {
    std::vector<std::uint32_t> left(corners.size());
    std::iota(left.begin(), left.end(), 0u);

    // Cuts ears while the polygon is not convex.
    if (corners.size() > 3) {
        const std::vector<glm::dvec2> flat = flattened(corners);
        if (!convex(flat)) {
            if (corners.size() > max_concave_corners) return false;
            for (std::size_t k = 0, misses = 0; left.size() > 3 && misses < left.size();) {
                k %= left.size();
                if (!is_ear(flat, left, k)) {
                    ++k, ++misses;
                    continue;
                }
                triangles.push_back({left[(k + left.size() - 1) % left.size()], left[k], left[(k + 1) % left.size()]});
                left.erase(left.begin() + std::ptrdiff_t(k));
                misses = 0;
            }
        }
    }

    // The rest is a fan.
    for (std::size_t i = 1; i + 1 < left.size(); ++i) triangles.push_back({left[0], left[i], left[i + 1]});
    return true;
}

}  // namespace plumb::io
