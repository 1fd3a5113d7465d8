#include "gi/probes/chart_shape.h"

#include <algorithm>
#include <cmath>

#include "gi/probes/planar_charts.h"

namespace plumb::probes {
namespace {

using Points = std::vector<glm::dvec2>;

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }
double length(const glm::dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }

// Convex hull, counter-clockwise with y up, without points on its sides (Andrew 1979).
Points hull_of(Points points) {
    std::stable_sort(points.begin(), points.end(),
                     [](const glm::dvec2& a, const glm::dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3) return points;
    Points hull;
    auto add_chain = [&](auto first, auto last) {
        const std::size_t begin = hull.size();
        for (auto p = first; p != last; ++p) {
            while (hull.size() >= begin + 2 && cross(hull.back() - hull[hull.size() - 2], *p - hull.back()) <= 0)
                hull.pop_back();
            hull.push_back(*p);
        }
        hull.pop_back();
    };
    add_chain(points.begin(), points.end());
    add_chain(points.rbegin(), points.rend());
    return hull;
}

glm::dvec2 turned(const glm::dvec2& p, const glm::dvec2& axis) {
    return {p.x * axis.x + p.y * axis.y, p.y * axis.x - p.x * axis.y};
}

// The direction along which the points' bounding rectangle is smallest: x, or one of the hull's longest edges.
glm::dvec2 best_axis(const Points& points) {
    const Points hull = hull_of(points);
    std::vector<glm::dvec2> axes{{1, 0}};
    Points edges;
    for (std::size_t i = 0; i < hull.size(); ++i) edges.push_back(hull[(i + 1) % hull.size()] - hull[i]);
    std::stable_sort(edges.begin(), edges.end(),
                     [](const glm::dvec2& a, const glm::dvec2& b) { return length(a) > length(b); });
    for (std::size_t i = 0; i < std::min<std::size_t>(edges.size(), 32); ++i)
        if (length(edges[i]) > 0) axes.push_back(edges[i] / length(edges[i]));
    glm::dvec2 best(1, 0);
    double smallest = HUGE_VAL;
    for (const glm::dvec2& axis : axes) {
        glm::dvec2 low(HUGE_VAL), high(-HUGE_VAL);
        for (const glm::dvec2& p : hull) low = glm::min(low, turned(p, axis)), high = glm::max(high, turned(p, axis));
        const double area = (high.x - low.x) * (high.y - low.y);
        // A difference of roundings decides nothing.
        if (area < smallest * (1 - 1e-9)) smallest = area, best = axis;
    }
    return best;
}

void measure(const SurfaceMesh& mesh, ChartShape& shape) {
    shape.low = glm::dvec2(HUGE_VAL), shape.high = glm::dvec2(-HUGE_VAL);
    for (std::uint32_t t : shape.triangles) {
        const PlaneTriangle p = shape.triangle(mesh, t);
        for (const glm::dvec2& corner : p)
            shape.low = glm::min(shape.low, corner), shape.high = glm::max(shape.high, corner);
        shape.area += mesh.area[t];
    }
    find_inner_circle(mesh, shape);
}

// Whether a texel's centre lies inside the triangle, given in texels, by texel_margin: row by row of centres, the
// columns that all three sides leave.
bool holds_centre(const PlaneTriangle& t) {
    const double turn = twice_area(t) < 0 ? -1 : 1;
    const double top = std::min({t[0].y, t[1].y, t[2].y}), bottom = std::max({t[0].y, t[1].y, t[2].y});
    for (double y = std::ceil(top - 0.5) + 0.5; y <= bottom; ++y) {
        double left = -HUGE_VAL, right = HUGE_VAL;
        for (std::size_t i = 0; i < 3; ++i) {
            // Inside: turn (side x (p - corner)) >= margin |side|, which is turn side.y x <= most.
            const glm::dvec2 side = (t[(i + 1) % 3] - t[i]) * turn;
            const double most = side.x * (y - t[i].y) + side.y * t[i].x - texel_margin * length(side);
            if (side.y > 0) right = std::min(right, most / side.y);
            if (side.y < 0) left = std::max(left, most / side.y);
            if (side.y == 0 && most < 0) right = -HUGE_VAL;
        }
        if (std::ceil(left - 0.5) + 0.5 <= right) return true;
    }
    return false;
}

PlaneTriangle in_texels(PlaneTriangle t, double scale, const glm::dvec2& shift) {
    for (glm::dvec2& p : t) p = p * scale + shift;
    return t;
}

// Whether the centre of a texel lies inside, drawn with that scale and shift.
bool covers_centre(const SurfaceMesh& mesh, const ChartShape& shape, double scale, const glm::dvec2& shift) {
    // Wherever it lies, a circle of that size holds one.
    if (shape.inner_radius * scale > 0.75) return true;
    return std::any_of(shape.triangles.begin(), shape.triangles.end(),
                       [&](std::uint32_t t) { return holds_centre(in_texels(shape.triangle(mesh, t), scale, shift)); });
}

constexpr double too_many = 1 << 20;  // texels a side: no atlas has room for them
int whole_texels(double extent) { return int(std::clamp(std::ceil(extent - texel_slack), 1.0, too_many)); }

}  // namespace

ChartShape own_shape(const SurfaceMesh& mesh, double metres, std::vector<std::uint32_t> triangles) {
    ChartShape shape;
    shape.own_uv = true;
    shape.metres = metres;
    shape.triangles = std::move(triangles);
    measure(mesh, shape);
    return shape;
}

ChartShape planar_shape(const SurfaceMesh& mesh, const glm::dvec3& normal, std::vector<std::uint32_t> triangles) {
    ChartShape shape;
    shape.triangles = std::move(triangles);
    shape.origin = mesh.position(shape.triangles[0], 0);
    glm::dvec3 first, second;
    plane_axes(normal, first, second);
    shape.across = first, shape.down = -second;
    Points points;
    double projected = 0, area = 0;
    for (std::uint32_t t : shape.triangles) {
        const PlaneTriangle p = shape.triangle(mesh, t);
        points.insert(points.end(), p.begin(), p.end());
        projected += std::fabs(twice_area(p)) / 2, area += mesh.area[t];
    }
    const glm::dvec2 axis = best_axis(points);
    const double grow = std::sqrt(area / projected);
    const glm::dvec3 across = shape.across, down = shape.down;
    shape.across = (across * axis.x + down * axis.y) * grow;
    shape.down = (down * axis.x - across * axis.y) * grow;
    measure(mesh, shape);
    return shape;
}

TexelRectangle texel_rectangle(const SurfaceMesh& mesh, const ChartShape* shapes, std::size_t count, double scale) {
    glm::dvec2 low = shapes[0].low, high = shapes[0].high;
    for (std::size_t i = 1; i < count; ++i) low = glm::min(low, shapes[i].low), high = glm::max(high, shapes[i].high);
    TexelRectangle r;
    for (int c = 0; c < 2; ++c) {
        const double extent = (high[c] - low[c]) * scale;
        r.size[c] = whole_texels(extent);
        r.shift[c] = (r.size[c] - extent) / 2 - low[c] * scale;
    }
    if (std::max(r.size.x, r.size.y) >= int(too_many)) return r;
    for (std::size_t i = 0; i < count; ++i)
        if (!covers_centre(mesh, shapes[i], scale, r.shift)) r.has_centre = false;
    if (r.has_centre || count > 1) return r;
    // Puts the inner circle's centre onto that of a texel, with as few texels before and behind it as hold the figure.
    const glm::dvec2 centre = shapes[0].inner_centre;
    r.has_centre = shapes[0].inner_radius * scale >= texel_margin;
    for (int c = 0; c < 2; ++c) {
        const double before = (centre[c] - low[c]) * scale, behind = (high[c] - centre[c]) * scale;
        const int texels_before = std::max(0, int(std::ceil(before - 0.5 - texel_slack)));
        r.size[c] = texels_before + 1 + std::max(0, int(std::ceil(behind - 0.5 - texel_slack)));
        r.shift[c] = texels_before + 0.5 - centre[c] * scale;
    }
    return r;
}

}  // namespace plumb::probes
