#include "raster/visibility.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/screen_triangle.h"

namespace plumb::raster {
namespace {

constexpr int band_rows = 32;

// Which triangles touch which band of rows: entries[start[b]..start[b + 1]), in drawing order.
struct Bins {
    std::vector<std::size_t> start;
    std::vector<std::int32_t> entries;
};

// Rows whose centres lie within the triangle's extent, clipped to [first, last); empty: first >= last.
struct Rows {
    int first, last;
};
Rows touched_rows(const ScreenTriangle& t, int first, int last) {
    const int low = std::min({t.y[0], t.y[1], t.y[2]}), high = std::max({t.y[0], t.y[1], t.y[2]});
    return {std::max(first, (low + 255) >> 8), std::min(last, (high >> 8) + 1)};
}

Bins sort_into_bands(const std::vector<ScreenTriangle>& triangles, int first, int last) {
    Bins bins;
    bins.start.assign(std::size_t((last - first + band_rows - 1) / band_rows) + 1, 0);
    auto for_each_band = [&](auto&& visit) {
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const Rows rows = touched_rows(triangles[i], first, last);
            if (rows.first >= rows.last) continue;
            for (int b = (rows.first - first) / band_rows; b <= (rows.last - 1 - first) / band_rows; ++b) visit(b, i);
        }
    };
    for_each_band([&](int b, std::size_t) { ++bins.start[std::size_t(b) + 1]; });
    for (std::size_t b = 1; b < bins.start.size(); ++b) bins.start[b] += bins.start[b - 1];
    bins.entries.resize(bins.start.back());
    std::vector<std::size_t> next(bins.start.begin(), bins.start.end() - 1);
    for_each_band([&](int b, std::size_t i) { bins.entries[next[std::size_t(b)]++] = std::int32_t(i); });
    return bins;
}

// Draws one triangle into rows [first, last): depth, and who won it.
void draw_triangle(const ScreenTriangle& t, std::int32_t index, bool reversed_z, int first, int last,
                   VisibilityBuffer& out, Image<std::int32_t>& winner, int winner_row) {
    const std::int64_t area = area2(t);
    const bool clockwise = area > 0;
    const double scale = 1 / double(clockwise ? area : -area);
    const double z[3] = {t.z[0] * scale, t.z[1] * scale, t.z[2] * scale};
    const int low = std::min({t.x[0], t.x[1], t.x[2]}), high = std::max({t.x[0], t.x[1], t.x[2]});
    const Rows rows = touched_rows(t, first, last);
    for (int y = rows.first; y < rows.last; ++y) {
        const EdgeRow edges[3] = {edge_row(t, clockwise, 0, y), edge_row(t, clockwise, 1, y),
                                  edge_row(t, clockwise, 2, y)};
        std::int64_t x = std::max(0, (low + 255) >> 8), end = std::min(out.depth.width - 1, high >> 8);
        covered_columns(edges, x, end);
        for (; x <= end; ++x) {
            // Depth is affine in the window: the weights are exact, and one rounding to float ends the sum.
            double depth = 0;
            for (int i = 0; i < 3; ++i) depth += double(edges[i].value + edges[i].step * x) * z[i];
            const float d = std::min(float(depth), 1.0f);
            float& nearest = out.depth(int(x), y);
            if (reversed_z ? d > nearest : d < nearest) {
                nearest = d;
                winner(int(x), y - winner_row) = index;
            }
        }
    }
}

// Names the triangle of each pixel and where in it the pixel's centre lies.
void resolve_winners(const ScreenTriangles& screen, const Image<std::int32_t>& winner, int first, int last,
                     VisibilityBuffer& out) {
    for (int y = first; y < last; ++y) {
        for (int x = 0; x < out.triangle.width; ++x) {
            const std::int32_t w = winner(x, y - first);
            if (w < 0) continue;
            const ScreenTriangle& t = screen.triangles[std::size_t(w)];
            const bool clockwise = area2(t) > 0;
            double e[3];
            for (int i = 0; i < 3; ++i) {
                const EdgeRow edge = edge_row(t, clockwise, i, y);
                e[i] = double(edge.value + edge.step * x);
            }
            out.triangle(x, y) = t.triangle;
            out.barycentrics(x, y) = barycentrics(t, screen.corners, e);
        }
    }
}

}  // namespace

VisibilityBuffer draw_visibility_rows(const Geometry& geometry, const View& view, glm::ivec2 size, int first, int last,
                                      const RunOptions& options) {
    if (size.x < 1 || size.y < 1 || size.x > max_frame_side || size.y > max_frame_side)
        throw InputError(fmt::format("raster: size = {} x {}: expected 1 to {} pixels a side", size.x, size.y,
                                     max_frame_side));
    VisibilityBuffer out{Image<std::int32_t>(size.x, size.y, -1), Image1(size.x, size.y, view.reversed_z ? 0.0f : 1.0f),
                         Image<glm::vec2>(size.x, size.y, glm::vec2(0))};
    const ScreenTriangles screen = screen_triangles(geometry, view, size, options.threads);
    const Bins bins = sort_into_bands(screen.triangles, first, last);
    parallel_bands(last - first, band_rows, options, [&](int from, int to) {
        const std::size_t band = std::size_t(from / band_rows);
        Image<std::int32_t> winner(size.x, to - from, -1);
        for (std::size_t k = bins.start[band]; k < bins.start[band + 1]; ++k) {
            const std::int32_t i = bins.entries[k];
            draw_triangle(screen.triangles[std::size_t(i)], i, view.reversed_z, first + from, first + to, out, winner,
                          first + from);
        }
        resolve_winners(screen, winner, first + from, first + to, out);
    });
    return out;
}

VisibilityBuffer draw_visibility(const Geometry& geometry, const View& view, glm::ivec2 size,
                                 const RunOptions& options) {
    return draw_visibility_rows(geometry, view, size, 0, size.y, options);
}

}  // namespace plumb::raster
