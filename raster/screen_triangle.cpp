#include "raster/screen_triangle.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/number.h"
#include "core/parallel.h"

namespace plumb::raster {
namespace {

constexpr int chunk = 4096;

bool finite(const glm::vec4& v) {
    return v.x - v.x == 0 && v.y - v.y == 0 && v.z - v.z == 0 && v.w - v.w == 0;
}

std::int64_t floor_division(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0); }  // b > 0

ScreenTriangle screen_triangle(const glm::dvec4 corners[3], std::int32_t triangle, glm::ivec2 size) {
    ScreenTriangle t;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec4& c = corners[i];
        t.x[i] = snap(c.x, c.w, size.x);
        t.y[i] = snap(c.y, c.w, size.y);
        t.z[i] = c.z / c.w;
        t.inverse_w[i] = 1 / c.w;
    }
    t.triangle = triangle;
    t.corners = -1;
    return t;
}

// Cuts the polygon into a fan. Snapping may bend it: pieces that turn against the whole are left out. A bend is
// narrower than 1/256 pixel; at worst a centre within it belongs to a neighbour too, never to nobody.
void append_polygon(ScreenTriangles& out, const ClipPolygon& polygon, std::int32_t triangle, glm::ivec2 size) {
    ScreenTriangle pieces[ClipPolygon::capacity - 2];
    std::int64_t whole = 0;
    for (int i = 0; i + 2 < polygon.count; ++i) {
        const glm::dvec4 corners[3] = {polygon.vertices[0].position, polygon.vertices[i + 1].position,
                                       polygon.vertices[i + 2].position};
        pieces[i] = screen_triangle(corners, triangle, size);
        whole += area2(pieces[i]);
    }
    for (int i = 0; i + 2 < polygon.count; ++i) {
        const std::int64_t area = area2(pieces[i]);
        if (area == 0 || (area > 0) != (whole > 0)) continue;
        pieces[i].corners = std::int32_t(out.corners.size());
        out.triangles.push_back(pieces[i]);
        out.corners.push_back({{polygon.vertices[0].barycentrics, polygon.vertices[i + 1].barycentrics,
                                polygon.vertices[i + 2].barycentrics}});
    }
}

}  // namespace

std::int32_t snap(double clip, double w, int side) {
    return number<double>::round_to_index(clip * (128.0 * side) / w) + 128 * (side - 1);
}

Buffer<glm::vec4> clip_positions(const Geometry& geometry, const View& view, int threads) {
    const glm::dmat4 m = view.world_to_clip();
    const int n = int(geometry.vertices.size());
    Buffer<glm::vec4> clip(geometry.vertices.size());
    std::vector<int> wrong(std::size_t(n / chunk + 1), n);
    parallel_bands(n, chunk, threads, [&](int first, int last) {
        for (int i = last - 1; i >= first; --i) {
            clip[i] = clip_position(m, geometry.vertices[i].position);
            if (!finite(clip[i])) wrong[first / chunk] = i;
        }
    });
    const int i = *std::min_element(wrong.begin(), wrong.end());
    if (i < n) throw_not_finite(geometry, i);
    return clip;
}

glm::vec4 clip_position(const glm::dmat4& m, const glm::vec3& position) {
    const glm::dvec3 p(position);
    glm::vec4 clip;
    for (int r = 0; r < 4; ++r) clip[r] = float(m[0][r] * p.x + m[1][r] * p.y + m[2][r] * p.z + m[3][r]);
    return clip;
}

void throw_not_finite(const Geometry& geometry, int i) {
    const glm::vec3 p = geometry.vertices[i].position;
    throw InputError(fmt::format("raster: vertex {} at ({}, {}, {}) m: its clip position is not finite in a float", i,
                                 p.x, p.y, p.z));
}

void append_triangle(ScreenTriangles& out, const glm::vec4 corners[3], std::int32_t triangle, glm::ivec2 size,
                     const ClipVolume& volume) {
    if (outside_frame(corners)) return;
    if (inside(volume, corners[0]) && inside(volume, corners[1]) && inside(volume, corners[2])) {
        const glm::dvec4 exact[3] = {glm::dvec4(corners[0]), glm::dvec4(corners[1]), glm::dvec4(corners[2])};
        const ScreenTriangle t = screen_triangle(exact, triangle, size);
        if (area2(t) != 0) out.triangles.push_back(t);
        return;
    }
    append_polygon(out, clip(volume, corners), triangle, size);
}

ScreenTriangles screen_triangles(const Geometry& geometry, const View& view, glm::ivec2 size, int threads) {
    return screen_triangles(geometry, clip_positions(geometry, view, threads), size, threads);
}

ScreenTriangles screen_triangles(const Geometry& geometry, const Buffer<glm::vec4>& positions, glm::ivec2 size,
                                 int threads) {
    const ClipVolume volume = clip_volume(size);
    const int n = int(geometry.triangles.size());
    std::vector<ScreenTriangles> chunks(std::size_t((n + chunk - 1) / chunk));
    parallel_bands(n, chunk, threads, [&](int first, int last) {
        for (int i = first; i < last; ++i) {
            const glm::uvec3& t = geometry.triangles[i];
            const glm::vec4 corners[3] = {positions[t.x], positions[t.y], positions[t.z]};
            append_triangle(chunks[first / chunk], corners, i, size, volume);
        }
    });

    // Join the chunks in order.
    ScreenTriangles all;
    std::size_t total = 0;
    for (const ScreenTriangles& c : chunks) total += c.triangles.size();
    all.triangles.reserve(total);
    for (const ScreenTriangles& c : chunks) {
        const std::int32_t offset = std::int32_t(all.corners.size());
        for (ScreenTriangle t : c.triangles) {
            if (t.corners >= 0) t.corners += offset;
            all.triangles.push_back(t);
        }
        all.corners.insert(all.corners.end(), c.corners.begin(), c.corners.end());
    }
    return all;
}

void covered_columns(const EdgeRow edges[3], std::int64_t& first, std::int64_t& last) {
    for (int i = 0; i < 3; ++i) {
        const auto [value, step, least] = edges[i];
        if (step > 0)
            first = std::max(first, -floor_division(value - least, step));
        else if (step < 0)
            last = std::min(last, floor_division(value - least, -step));
        else if (value < least)
            last = first - 1;
    }
}

glm::vec2 barycentrics(const ScreenTriangle& t, const PieceCorners* corners, const double e[3]) {
    const double q[3] = {e[0] * t.inverse_w[0], e[1] * t.inverse_w[1], e[2] * t.inverse_w[2]};
    const double sum = q[0] + q[1] + q[2];
    if (t.corners < 0) return {float(q[1] / sum), float(q[2] / sum)};
    const glm::dvec2* l = corners[t.corners].barycentrics;
    return {float((q[0] * l[0].x + q[1] * l[1].x + q[2] * l[2].x) / sum),
            float((q[0] * l[0].y + q[1] * l[1].y + q[2] * l[2].y) / sum)};
}

}  // namespace plumb::raster
