#include "raster/visibility_reference.h"

#include <algorithm>

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

// Edge functions at the centre of a pixel, positive inside.
struct Edges {
    double e[3];
};
Edges edges_at(const ScreenTriangle& t, int x, int y) {
    Edges edges;
    for (int i = 0; i < 3; ++i) {
        const EdgeRow edge = edge_row(t, area2(t) > 0, i, y);
        edges.e[i] = double(edge.value + edge.step * x);
    }
    return edges;
}

// What a frame is drawn from.
struct Drawing {
    const ScreenTriangles& screen;
    const SurfaceArgs* masks;           // null: no material has an alpha mask
    const std::int32_t* masked;         // [material]
    const std::int32_t* material;       // [triangle]
    bool reversed_z;
    const Image1* behind;               // null: nothing is peeled off
};

// Whether a depth lies strictly farther than what is peeled off. NaN never does.
bool lies_behind(const Drawing& in, float depth, int x, int y) {
    if (!in.behind) return true;
    const float peeled = (*in.behind)(x, y);
    return in.reversed_z ? depth < peeled : depth > peeled;
}

// Whether there is a surface at the pixel, or its material's alpha is below the cutoff.
bool passes_alpha_test(const Drawing& in, const ScreenTriangle& t, int x, int y) {
    if (!in.masks || !in.masked[in.material[t.triangle]]) return true;
    const glm::vec2 l = barycentrics(t, in.screen.corners.data(), edges_at(t, x, y).e);
    return passes_alpha<float>(*in.masks, t.triangle, l);
}

// Draws one triangle into rows [first, last): depth, and who won it.
void draw_triangle(const Drawing& in, std::int32_t index, int first, int last, VisibilityBuffer& out,
                   Image<std::int32_t>& winner, int winner_row) {
    const ScreenTriangle& t = in.screen.triangles[std::size_t(index)];
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
            if (!lies_behind(in, d, int(x), y)) continue;
            if ((in.reversed_z ? d > nearest : d < nearest) && passes_alpha_test(in, t, int(x), y)) {
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
            out.triangle(x, y) = t.triangle;
            out.barycentrics(x, y) = barycentrics(t, screen.corners.data(), edges_at(t, x, y).e);
        }
    }
}

}  // namespace

VisibilityBuffer reference_visibility(const Geometry& geometry, const Surfaces* surfaces,
                                      const Buffer<glm::vec4>& clip_positions, bool reversed_z, glm::ivec2 size,
                                      int first, int last, const RunOptions& options, const Image1* behind) {
    check_frame_size(size);
    check_behind(behind, size);
    VisibilityBuffer out{Image<std::int32_t>(size.x, size.y, -1), Image1(size.x, size.y, reversed_z ? 0.0f : 1.0f),
                         Image<glm::vec2>(size.x, size.y, glm::vec2(0))};
    const ScreenTriangles screen = screen_triangles(geometry, clip_positions, size, options.threads);
    const Bins bins = sort_into_bands(screen.triangles, first, last);
    SurfaceArgs masks{};
    Drawing drawing{screen, nullptr, nullptr, geometry.material.data(), reversed_z, behind};
    if (surfaces && surfaces->any_masked) {
        masks = surface_args(geometry, *surfaces, View());
        drawing.masks = &masks;
        drawing.masked = surfaces->masked.data();
    }
    parallel_bands(last - first, band_rows, options, [&](int from, int to) {
        const std::size_t band = std::size_t(from / band_rows);
        Image<std::int32_t> winner(size.x, to - from, -1);
        for (std::size_t k = bins.start[band]; k < bins.start[band + 1]; ++k)
            draw_triangle(drawing, bins.entries[k], first + from, first + to, out, winner, first + from);
        resolve_winners(screen, winner, first + from, first + to, out);
    });
    return out;
}

VisibilityBuffer reference_visibility(const Geometry& geometry, const Surfaces* surfaces, const View& view,
                                      glm::ivec2 size, int first, int last, const RunOptions& options,
                                      const Image1* behind) {
    check_frame_size(size);
    return reference_visibility(geometry, surfaces, clip_positions(geometry, view, options.threads), view.reversed_z,
                                size, first, last, options, behind);
}

}  // namespace plumb::raster
