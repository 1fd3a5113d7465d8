#include <algorithm>
#include <cmath>

#include "gi/probes/chart_shape.h"

namespace plumb::probes {
namespace {

constexpr int side = 32;  // cells

double length(const glm::dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }

void of_triangle(const PlaneTriangle& t, ChartShape& shape) {
    // Corners weighted by the sides opposite to them meet in the centre of the inner circle.
    const double a = length(t[2] - t[1]), b = length(t[0] - t[2]), c = length(t[1] - t[0]);
    const double radius = std::fabs(twice_area(t)) / (a + b + c);
    if (radius > shape.inner_radius)
        shape.inner_radius = radius, shape.inner_centre = (t[0] * a + t[1] * b + t[2] * c) / (a + b + c);
}

// Marks the cells whose centre is in the triangle, given in cells; a millionth of a cell wider, so that none is lost
// between two.
void mark(std::vector<int>& cells, const PlaneTriangle& t) {
    const double turn = twice_area(t) < 0 ? -1 : 1;
    const double top = std::min({t[0].y, t[1].y, t[2].y}), bottom = std::max({t[0].y, t[1].y, t[2].y});
    const double leftmost = std::min({t[0].x, t[1].x, t[2].x}), rightmost = std::max({t[0].x, t[1].x, t[2].x});
    const int y0 = std::max(0, int(std::ceil(top - 0.5))), y1 = std::min(side - 1, int(std::floor(bottom - 0.5)));
    const int x0 = std::max(0, int(std::ceil(leftmost - 0.5))),
              x1 = std::min(side - 1, int(std::floor(rightmost - 0.5)));
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            bool inside = true;
            for (std::size_t i = 0; i < 3; ++i) {
                const glm::dvec2 s = (t[(i + 1) % 3] - t[i]) * turn, d = glm::dvec2(x + 0.5, y + 0.5) - t[i];
                inside = inside && s.x * d.y - s.y * d.x >= -1e-6 * length(s);
            }
            if (inside) cells[std::size_t(y * side + x)] = 1;
        }
}

}  // namespace

void find_inner_circle(const SurfaceMesh& mesh, ChartShape& shape) {
    for (std::uint32_t t : shape.triangles) of_triangle(shape.triangle(mesh, t), shape);
    const glm::dvec2 cell = (shape.high - shape.low) / double(side);
    const double smaller = std::min(cell.x, cell.y);
    if (shape.triangles.size() <= 2 || shape.inner_radius > 4 * smaller || !(smaller > 0)) return;
    std::vector<int> cells(side * side, 0);
    for (std::uint32_t t : shape.triangles) {
        PlaneTriangle p = shape.triangle(mesh, t);
        for (glm::dvec2& corner : p) corner = (corner - shape.low) / cell;
        mark(cells, p);
    }
    // The side of the largest square of marked cells that ends in each; a circle within its cells' centres.
    int most = 0;
    glm::ivec2 at(0);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            int& own = cells[std::size_t(y * side + x)];
            if (own && x > 0 && y > 0)
                own = 1 + std::min({cells[std::size_t((y - 1) * side + x)], cells[std::size_t(y * side + x - 1)],
                                    cells[std::size_t((y - 1) * side + x - 1)]});
            if (own > most) most = own, at = {x, y};
        }
    const double radius = (most - 1) * 0.5 * smaller;
    if (!(radius > shape.inner_radius)) return;
    shape.inner_radius = radius;
    shape.inner_centre = shape.low + (glm::dvec2(at) + 1.0 - 0.5 * most) * cell;
}

}  // namespace plumb::probes
