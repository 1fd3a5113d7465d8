// A triangle in window space: snapped corners, exact edge functions, interpolation.
//
// Window coordinates are integers in 1/256 pixel, y down; the centre of pixel (i, j) is (256 i, 256 j). Every
// coordinate is within 2^24 (raster/clip.h), pixel centres are within 2^23, so differences are below 2^25, their
// products below 2^50, and an edge function, the difference of two products, below 2^51: exact in 64-bit integers and
// in double.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/image.h"
#include "core/number.h"
#include "core/scene.h"
#include "core/view.h"
#include "raster/clip.h"

namespace plumb::raster {

struct ScreenTriangle {
    std::int32_t x[3], y[3];
    double z[3];             // of the depth buffer
    double inverse_w[3];
    std::int32_t triangle;   // index into Geometry::triangles
    std::int32_t corners;    // -1: corner i is the triangle's corner i; else index into ScreenTriangles::corners
};

// l1, l2 of the corners of a piece of a clipped triangle.
struct PieceCorners {
    glm::dvec2 barycentrics[3];
};

struct ScreenTriangles {
    std::vector<ScreenTriangle> triangles;
    std::vector<PieceCorners> corners;
};

// Clip-space positions, computed in double and rounded once: where a GPU's twin starts too. Throws InputError for the
// first one that is not finite.
Buffer<glm::vec4> clip_positions(const Geometry& geometry, const View& view, int threads);
glm::vec4 clip_position(const glm::dmat4& world_to_clip, const glm::vec3& position);

// The error about vertex i.
[[noreturn]] void throw_not_finite(const Geometry& geometry, int i);

// Appends what is seen of one triangle: itself, or the pieces of its clipped polygon, or nothing.
void append_triangle(ScreenTriangles& out, const glm::vec4 corners[3], std::int32_t triangle, glm::ivec2 size,
                     const ClipVolume& volume);

// All triangles, in their order, whatever the number of threads.
ScreenTriangles screen_triangles(const Geometry& geometry, const Buffer<glm::vec4>& clip_positions, glm::ivec2 size,
                                 int threads);
ScreenTriangles screen_triangles(const Geometry& geometry, const View& view, glm::ivec2 size, int threads);

// Round to nearest even of (X - 0.5) 256 for the window coordinate X = (clip / w + 1) side / 2.
//
// clip side 128 / w is rounded before 128 (side - 1), a whole and even number, is added, so that ties stay ties. clip
// and w are floats: the product is exact, and the quotient's distance from any tie that it does not hit exceeds the
// rounding of a double, so the result is that of exact arithmetic (raster/README.md).
std::int32_t snap(double clip, double w, int side);

// Twice the signed area, in (1/256 pixel)^2; positive where the corners turn clockwise as seen on the screen.
PLUMB_INLINE std::int64_t area2(const ScreenTriangle& t) {
    return std::int64_t(t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - std::int64_t(t.y[1] - t.y[0]) * (t.x[2] - t.x[0]);
}

// The edge opposite corner i as a function of the pixel's column along a row: value + step * column, positive inside; a
// centre is covered where it is at least `least`: 0 on a top or left edge, 1 on any other.
struct EdgeRow {
    std::int64_t value, step, least;
};
PLUMB_INLINE EdgeRow edge_row(const ScreenTriangle& t, bool clockwise, int i, int row) {
    const int a = (i + 1) % 3, b = (i + 2) % 3, sign = clockwise ? 1 : -1;
    const std::int64_t dx = sign * (t.x[b] - t.x[a]), dy = sign * (t.y[b] - t.y[a]);
    // With y down and the inside to the right of its direction, a left edge runs up and a top edge runs to the right.
    const bool top_left = dy < 0 || (dy == 0 && dx > 0);
    return {dx * (256 * std::int64_t(row) - t.y[a]) + dy * t.x[a], -256 * dy, top_left ? 0 : 1};
}

// The columns [first, last] of a row that the triangle covers, within [first, last] as given; empty: first > last.
void covered_columns(const EdgeRow edges[3], std::int64_t& first, std::int64_t& last);

// l1, l2 of the whole triangle at a point with edge functions e, perspective-correct:
// l_k = sum e_i l_ki / w_i / sum e_i / w_i. `corners` is ScreenTriangles::corners.
glm::vec2 barycentrics(const ScreenTriangle& t, const PieceCorners* corners, const double e[3]);

}  // namespace plumb::raster
