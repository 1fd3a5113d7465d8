#include "gi/probes/chart_layout.h"

#include <algorithm>
#include <cmath>

#include "core/image.h"

namespace plumb::probes {
namespace {

using Texels = Image<std::int32_t>;  // which shape touches a texel, from 1; 0: none

// The columns that the triangle touches between y and y + 1.
bool touched(const PlaneTriangle& t, double y, double& left, double& right) {
    left = HUGE_VAL, right = -HUGE_VAL;
    auto see = [&](double x) { left = std::min(left, x), right = std::max(right, x); };
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 a = t[i], b = t[(i + 1) % 3];
        if (a.y >= y && a.y <= y + 1) see(a.x);
        for (double line : {y, y + 1})
            if ((a.y < line) != (b.y < line)) see(a.x + (line - a.y) / (b.y - a.y) * (b.x - a.x));
    }
    return left <= right;
}

// Marks what the triangle touches; false where another shape does, too.
bool mark(Texels& texels, const PlaneTriangle& t, std::int32_t shape) {
    bool alone = true;
    const double top = std::min({t[0].y, t[1].y, t[2].y}), bottom = std::max({t[0].y, t[1].y, t[2].y});
    const int y0 = std::max(0, int(std::floor(top + texel_slack)));
    const int y1 = std::min(texels.height, int(std::ceil(bottom - texel_slack)));
    for (int y = y0; y < y1; ++y) {
        double left, right;
        if (!touched(t, y, left, right)) continue;
        const int x0 = std::max(0, int(std::floor(left + texel_slack)));
        const int x1 = std::min(texels.width, int(std::ceil(right - texel_slack)));
        for (int x = x0; x < x1; ++x) {
            alone = alone && (texels(x, y) == 0 || texels(x, y) == shape);
            texels(x, y) = shape;
        }
    }
    return alone;
}

// Whether no window of n x n texels shows two islands.
bool windows_agree(const Texels& texels, int n) {
    // The one island of each row of n texels from (x, y) on; two in a row end it at once.
    Texels rows(texels.width, texels.height);
    auto join = [](std::int32_t& seen, std::int32_t other) {
        if (seen == 0) seen = other;
        return other == 0 || other == seen;
    };
    for (int y = 0; y < texels.height; ++y)
        for (int x = 0; x < texels.width; ++x)
            for (int i = x; i < std::min(x + n, texels.width); ++i)
                if (!join(rows(x, y), texels(i, y))) return false;
    for (int y = 0; y < texels.height; ++y)
        for (int x = 0; x < texels.width; ++x) {
            std::int32_t seen = 0;
            for (int i = y; i < std::min(y + n, texels.height); ++i)
                if (!join(seen, rows(x, i))) return false;
        }
    return true;
}

// What all shapes touch; false where two of them touch one texel.
bool mark_all(Texels& texels, const SurfaceMesh& mesh, const ChartShape* shapes, std::size_t count, double scale,
              const glm::dvec2& shift) {
    bool alone = true;
    for (std::size_t i = 0; i < count; ++i)
        for (std::uint32_t t : shapes[i].triangles) {
            PlaneTriangle p = shapes[i].triangle(mesh, t);
            for (glm::dvec2& corner : p) corner = corner * scale + shift;
            alone = mark(texels, p, std::int32_t(i) + 1) && alone;
        }
    return alone;
}

// Marks every texel within `gap` of one that is marked, rows first.
void widen(Texels& texels, int gap) {
    const Texels before = texels;
    for (int y = 0; y < texels.height; ++y)
        for (int x = 0; x < texels.width; ++x)
            if (before(x, y) != 0)
                for (int i = std::max(0, x - gap); i <= std::min(texels.width - 1, x + gap); ++i) texels(i, y) = 1;
    const Texels rows = texels;
    for (int y = 0; y < texels.height; ++y)
        for (int x = 0; x < texels.width; ++x)
            if (rows(x, y) != 0)
                for (int i = std::max(0, y - gap); i <= std::min(texels.height - 1, y + gap); ++i) texels(x, i) = 1;
}

// The largest rectangle without a marked texel; the first of equals, row by row of its bottom.
TexelHole largest_hole(const Texels& texels) {
    TexelHole best;
    std::int64_t most = 0;
    std::vector<int> height(std::size_t(texels.width) + 1, 0);  // free texels above each column; 0 behind the last
    std::vector<int> open;                                      // columns where a rectangle begins, lower ones first
    for (int y = 0; y < texels.height; ++y) {
        for (int x = 0; x < texels.width; ++x) height[std::size_t(x)] = texels(x, y) ? 0 : height[std::size_t(x)] + 1;
        open.clear();
        for (int x = 0; x <= texels.width; ++x) {
            while (!open.empty() && height[std::size_t(open.back())] >= height[std::size_t(x)]) {
                const int h = height[std::size_t(open.back())];
                open.pop_back();
                const int left = open.empty() ? 0 : open.back() + 1;
                if (std::int64_t(h) * (x - left) > most)
                    most = std::int64_t(h) * (x - left), best = {{left, y + 1 - h}, {x - left, h}};
            }
            open.push_back(x);
        }
    }
    return best;
}

}  // namespace

bool apart(const SurfaceMesh& mesh, const std::vector<ChartShape>& islands, const TexelRectangle& rectangle,
           double scale, int gap) {
    double area = 0;
    for (const ChartShape& island : islands) {
        const glm::dvec2 size = (island.high - island.low) * scale;
        area += size.x * size.y;
    }
    if (!(4 * area >= double(rectangle.size.x) * double(rectangle.size.y))) return false;
    Texels texels(rectangle.size.x, rectangle.size.y);
    return mark_all(texels, mesh, islands.data(), islands.size(), scale, rectangle.shift) &&
           windows_agree(texels, gap + 1);
}

std::vector<TexelHole> holes(const SurfaceMesh& mesh, const ChartShape* shapes, std::size_t count,
                             const TexelRectangle& rectangle, double scale, int gap) {
    double area = 0;
    for (std::size_t i = 0; i < count; ++i) area += shapes[i].area * scale * scale;
    const double room = double(rectangle.size.x) * double(rectangle.size.y);
    if (room < 64 || area > 0.8 * room) return {};
    Texels texels(rectangle.size.x, rectangle.size.y);
    mark_all(texels, mesh, shapes, count, scale, rectangle.shift);
    widen(texels, gap);
    std::vector<TexelHole> found;
    while (found.size() < 8) {
        const TexelHole hole = largest_hole(texels);
        if (std::int64_t(hole.size.x) * hole.size.y < std::max(4.0, room / 64)) break;
        found.push_back(hole);
        // What comes into two holes is the gap apart, too.
        const glm::ivec2 low = glm::max(hole.origin - gap, glm::ivec2(0));
        const glm::ivec2 high = glm::min(hole.origin + hole.size + gap, rectangle.size);
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x) texels(x, y) = 1;
    }
    return found;
}

}  // namespace plumb::probes
