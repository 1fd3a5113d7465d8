#include "raster/device_raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/device_polygon.h"
#include "raster/device_triangle.h"

namespace plumb::raster {
namespace {

constexpr int band_rows = 32;
constexpr int chunk_triangles = 4096;

// What consecutive triangles leave to draw, and which of it touches which band of rows:
// entries[start[b]..start[b + 1]), in drawing order. Shape is DeviceTriangle or DevicePolygon.
template <class Shape>
struct Chunk {
    std::vector<Shape> shapes;
    std::vector<std::uint32_t> start, entries;
};

// Rows [first, last) whose centres lie within the triangle's extent.
struct Rows {
    int first, last;
};
template <class Shape>
Rows touched_rows(const Shape& s, int first, int last) {
    const int low = *std::min_element(s.y, s.y + s.count), high = *std::max_element(s.y, s.y + s.count);
    return {std::max(first, (low + 255) >> 8), std::min(last, (high >> 8) + 1)};
}

template <class Shape>
void sort_into_bands(Chunk<Shape>& chunk, int height) {
    const int bands = (height + band_rows - 1) / band_rows;
    chunk.start.assign(std::size_t(bands) + 2, 0);
    auto for_each_band = [&](auto&& visit) {
        for (std::size_t i = 0; i < chunk.shapes.size(); ++i) {
            const Rows rows = touched_rows(chunk.shapes[i], 0, height);
            for (int b = rows.first / band_rows; b <= (rows.last - 1) / band_rows; ++b) visit(std::size_t(b), i);
        }
    };
    // Counts are kept two places further on and starts one, so that filling moves each start to where it belongs.
    for_each_band([&](std::size_t b, std::size_t) { ++chunk.start[b + 2]; });
    for (std::size_t b = 1; b < chunk.start.size(); ++b) chunk.start[b] += chunk.start[b - 1];
    chunk.entries.resize(chunk.start.back());
    for_each_band([&](std::size_t b, std::size_t i) { chunk.entries[chunk.start[b + 1]++] = std::uint32_t(i); });
}

struct Drawing {
    const Geometry& geometry;
    const Buffer<glm::vec4>& clip_positions;
    const DeviceProfile& profile;
    glm::ivec2 size;
    bool reversed_z;
    const std::int32_t* masked = nullptr;  // [material]; null: no material has an alpha mask
    SurfaceArgs masks{};
    const Image1* behind = nullptr;  // only what lies strictly farther is drawn; null: everything

    bool is_masked(std::int32_t triangle) const {
        return masked && masked[geometry.material[std::size_t(triangle)]] != 0;
    }
};

// Not inlined: its arithmetic must not move out of its caller's FlushedDenormals.
template <class Shape>
__attribute__((noinline)) void set_up(const Drawing& in, int first, int last, Chunk<Shape>& chunk) {
    for (int i = first; i < last; ++i) {
        const glm::uvec3& t = in.geometry.triangles[std::size_t(i)];
        const glm::vec4 corners[3] = {in.clip_positions[t.x], in.clip_positions[t.y], in.clip_positions[t.z]};
        append_device_shape(chunk.shapes, corners, i, in.size, in.profile);
    }
    sort_into_bands(chunk, in.size.y);
}

// Draws one shape into rows [first, last): depth, and who won it, row by row from `first` on.
template <class Shape>
void draw_shape(const Drawing& in, const Shape& s, int first, int last, VisibilityBuffer& out,
                std::vector<const Shape*>& winner) {
    const bool fma = in.profile.fused_raster, masked = in.is_masked(s.triangle);
    const Rows rows = touched_rows(s, first, last);
    for (int y = rows.first; y < rows.last; ++y) {
        int begin, end;
        covered_columns(s, y, in.size.x, begin, end);
        for (int x = begin; x <= end; ++x) {
            const float depth = depth_at(s, x, y, fma);
            float& nearest = out.depth(x, y);
            if (!(in.reversed_z ? depth > nearest : depth < nearest)) continue;
            if (in.behind && !(in.reversed_z ? depth < (*in.behind)(x, y) : depth > (*in.behind)(x, y))) continue;
            if (masked && !passes_alpha<float>(in.masks, s.triangle, barycentrics_at(s, x, y, fma))) continue;
            nearest = depth;
            winner[std::size_t(y - first) * std::size_t(in.size.x) + std::size_t(x)] = &s;
        }
    }
}

template <class Shape>
__attribute__((noinline)) void draw_band(const Drawing& in, const std::vector<Chunk<Shape>>& chunks, int first, int last,
                                         VisibilityBuffer& out) {
    const std::size_t band = std::size_t(first / band_rows);
    std::vector<const Shape*> winner(std::size_t(last - first) * std::size_t(in.size.x));
    for (int y = first; y < last; ++y)
        for (int x = 0; x < in.size.x; ++x) out.depth(x, y) = in.reversed_z ? 0.0f : 1.0f;
    for (const Chunk<Shape>& chunk : chunks)
        for (std::uint32_t k = chunk.start[band]; k < chunk.start[band + 1]; ++k)
            draw_shape(in, chunk.shapes[chunk.entries[k]], first, last, out, winner);

    for (int y = first; y < last; ++y) {
        for (int x = 0; x < in.size.x; ++x) {
            const Shape* s = winner[std::size_t(y - first) * std::size_t(in.size.x) + std::size_t(x)];
            out.triangle(x, y) = s ? s->triangle : -1;
            const glm::vec2 l = s ? barycentrics_at(*s, x, y, in.profile.fused_raster) : glm::vec2(0);
            // Compilers give NaN this sign or that.
            out.barycentrics(x, y) = {l.x == l.x ? l.x : __builtin_nanf(""), l.y == l.y ? l.y : __builtin_nanf("")};
        }
    }
}

template <class Shape>
void draw(const Drawing& drawing, const RunOptions& options, VisibilityBuffer& out) {
    const int n = int(drawing.geometry.triangles.size());
    std::vector<Chunk<Shape>> chunks(std::size_t((n + chunk_triangles - 1) / chunk_triangles));
    parallel_bands(n, chunk_triangles, options.threads, [&](int first, int last) {
        const FlushedDenormals flushed;
        set_up(drawing, first, last, chunks[std::size_t(first / chunk_triangles)]);
    });
    parallel_bands(drawing.size.y, band_rows, options, [&](int first, int last) {
        const FlushedDenormals flushed;
        draw_band(drawing, chunks, first, last, out);
    });
}

void check_finite(const Buffer<glm::vec4>& positions) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const glm::vec4& p = positions[i];
        if (p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0 && p.w - p.w == 0) continue;
        throw InputError(fmt::format("raster: vertex {}: its clip position is not finite", i));
    }
}

}  // namespace

void draw_device_visibility(const Geometry& geometry, const Surfaces* surfaces,
                            const Buffer<glm::vec4>& clip_positions, bool reversed_z, glm::ivec2 size,
                            const DeviceProfile& profile, const RunOptions& options, VisibilityBuffer& out,
                            const Image1* behind) {
    if (profile.interpolation == Interpolation::ideal) {
        draw_visibility(geometry, surfaces, clip_positions, reversed_z, size, options, out, nullptr, behind);
        return;
    }
    check_frame_size(size);
    check_behind(behind, size);
    check_finite(clip_positions);
    if (out.triangle.width != size.x || out.triangle.height != size.y)
        out = {Image<std::int32_t>(size.x, size.y), Image1(size.x, size.y), Image<glm::vec2>(size.x, size.y)};
    Drawing drawing{geometry, clip_positions, profile, size, reversed_z};
    drawing.behind = behind;
    if (surfaces && surfaces->any_masked) {
        drawing.masked = surfaces->masked.data();
        drawing.masks = surface_args(geometry, *surfaces, View());
    }
    if (profile.interpolation == Interpolation::snapped_planes)
        draw<DevicePolygon>(drawing, options, out);
    else
        draw<DeviceTriangle>(drawing, options, out);
}

}  // namespace plumb::raster
