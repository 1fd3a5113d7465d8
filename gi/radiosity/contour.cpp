#include "gi/radiosity/contour.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/radiosity/edge_integral.h"

namespace plumb::radiosity {
namespace {

using host::pi;

constexpr double margin = 1e-13;  // of the polygons' size: corners so near to a plane lie on it

constexpr double rounding = 4e-15;  // of the terms that are summed

double largest(const glm::dvec3& v) { return std::fmax(std::fmax(std::fabs(v.x), std::fabs(v.y)), std::fabs(v.z)); }

glm::dvec3 unit_normal(const Polygon& polygon) {
    const glm::dvec3 a = area_vector(polygon);
    return a / glm::length(a);
}

// Moved to the first polygon's first corner and scaled to a size of about 1: logarithms cancel least there.
struct Frame {
    glm::dvec3 origin;
    double scale;
    Polygon operator()(const Polygon& polygon) const {
        Polygon moved;
        for (const glm::dvec3& corner : polygon) moved.push_back((corner - origin) * scale);
        return moved;
    }
};
Frame frame_of(const Polygon& a, const Polygon& b) {
    double size = 0;
    for (const Polygon* p : {&a, &b})
        for (const glm::dvec3& corner : *p) size = std::fmax(size, largest(corner - a[0]));
    return {a[0], 1 / size};
}

// 2 pi A F, without its sign, of polygons that lie wholly in front of each other.
EdgeIntegral contours(const Polygon& a, const Polygon& b, double tolerance) {
    EdgeIntegral sum;
    if (a.size() < 3 || b.size() < 3) return sum;
    const double each = std::fmax(tolerance / double(a.size() * b.size()), 1e-17);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j) {
            const EdgeIntegral pair = edge_integral({a[i], a[(i + 1) % a.size()]}, {b[j], b[(j + 1) % b.size()]}, each);
            sum.value += pair.value, sum.error += pair.error, sum.magnitude += pair.magnitude;
        }
    sum.value = std::fabs(sum.value);
    return sum;
}

}  // namespace

glm::dvec3 area_vector(const Polygon& polygon) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < polygon.size(); ++i)
        sum += glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
    return 0.5 * sum;
}
double area(const Polygon& polygon) { return glm::length(area_vector(polygon)); }
double area(const std::vector<Polygon>& polygons) {
    double sum = 0;
    for (const Polygon& p : polygons) sum += area(p);
    return sum;
}

void check_polygon(const std::string& name, const Polygon& polygon, double flatness) {
    auto refuse = [&](const std::string& cause) { throw InputError(name + ": " + cause); };
    if (polygon.size() < 3) refuse(fmt::format("{} corners: a polygon has 3 or more", polygon.size()));
    double size = 0;
    for (const glm::dvec3& corner : polygon) {
        for (int k = 0; k < 3; ++k)
            if (!(std::fabs(corner[k]) < 1e100))
                refuse(fmt::format("corner {}, {}, {}: expected finite numbers", corner.x, corner.y, corner.z));
        size = std::fmax(size, largest(corner - polygon[0]));
    }
    if (!(area(polygon) > 1e-12 * size * size)) refuse("no area");
    const glm::dvec3 normal = unit_normal(polygon);
    double turns = 0;  // of the outline; above 1 where it winds more than once
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 corner = polygon[i], in = corner - polygon[(i + polygon.size() - 1) % polygon.size()],
                         out = polygon[(i + 1) % polygon.size()] - corner;
        if (std::fabs(glm::dot(normal, corner - polygon[0])) > flatness * size)
            refuse(fmt::format("corner {} is {:.3g} m off the plane of the others: expected a flat polygon", i,
                               std::fabs(glm::dot(normal, corner - polygon[0]))));
        const double turn = glm::dot(normal, glm::cross(in, out));
        if (glm::length(out) == 0) refuse(fmt::format("corner {} stands twice", i));
        if (turn < -1e-12 * size * size) refuse(fmt::format("not convex at corner {}: cut it into convex ones", i));
        turns += host::atan2(turn, glm::dot(in, out)) / (2 * pi);
    }
    if (turns > 1.5) refuse("its outline crosses itself");
}

Polygon clip_to_front(const Polygon& polygon, const glm::dvec3& point, const glm::dvec3& normal, double near) {
    std::vector<double> height;
    bool in_front = false;
    for (const glm::dvec3& corner : polygon) {
        const double h = glm::dot(normal, corner - point);
        height.push_back(std::fabs(h) <= near ? 0 : h);
        in_front = in_front || height.back() > 0;
    }
    Polygon kept;
    if (!in_front) return kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const std::size_t next = (i + 1) % polygon.size();
        const double a = height[i], b = height[next];
        if (a >= 0) kept.push_back(polygon[i]);
        if ((a > 0 && b < 0) || (a < 0 && b > 0))
            kept.push_back(polygon[i] + (polygon[next] - polygon[i]) * (a / (a - b)));
    }
    return kept;
}

double point_form_factor(const glm::dvec3& point, const glm::dvec3& normal, const Polygon& target, Sides sides) {
    const glm::dvec3 n = normal / glm::length(normal), to = target[0] - point;
    double size = 0;
    for (const glm::dvec3& corner : target) size = std::fmax(size, largest(corner - point));
    const double height = -glm::dot(unit_normal(target), to);
    if (std::fabs(height) <= margin * size || (sides == Sides::front && height < 0)) return 0;
    const Polygon seen = clip_to_front(target, point, n, margin * size);
    double sum = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const glm::dvec3 r = seen[i] - point, s = seen[(i + 1) % seen.size()] - point, across = glm::cross(r, s);
        const double length = glm::length(across);
        if (length > 0) sum += host::atan2(length, glm::dot(r, s)) * glm::dot(n, across) / length;
    }
    return std::fabs(sum) / (2 * pi);
}

ContourFactor polygon_form_factor(const Polygon& from, const Polygon& to, Sides sides, double tolerance) {
    const Frame frame = frame_of(from, to);
    const Polygon a = frame(from), b = frame(to);
    const glm::dvec3 n = unit_normal(a), m = unit_normal(b);
    const double whole = 2 * pi * area(a);
    const Polygon seen = clip_to_front(b, a[0], n, margin);
    if (seen.empty()) return {};
    EdgeIntegral sum = contours(clip_to_front(a, b[0], m, margin), seen, tolerance * whole);
    if (sides == Sides::both) {
        const EdgeIntegral behind = contours(clip_to_front(a, b[0], -m, margin), seen, tolerance * whole);
        sum.value += behind.value, sum.error += behind.error, sum.magnitude += behind.magnitude;
    }
    return {sum.value / whole, (sum.error + rounding * sum.magnitude) / whole};
}

ContourFactor surface_form_factor(const std::vector<Polygon>& from, const std::vector<Polygon>& to, Sides sides,
                                  double tolerance) {
    ContourFactor mean;
    const double whole = area(from);
    for (const Polygon& a : from) {
        const double share = area(a) / whole;
        for (const Polygon& b : to) {
            const ContourFactor f = polygon_form_factor(a, b, sides, tolerance);
            mean.value += share * f.value, mean.error += share * f.error;
        }
    }
    return mean;
}

double point_form_factor(const glm::dvec3& point, const glm::dvec3& normal, const std::vector<Polygon>& to,
                         Sides sides) {
    double sum = 0;
    for (const Polygon& b : to) sum += point_form_factor(point, normal, b, sides);
    return sum;
}

}  // namespace plumb::radiosity
