// Counts what a rasterizer draws of a view: with and without a depth test.
#include <algorithm>
#include <cmath>

#include "raster/screen_triangle.h"
#include "tools/experiments/lra.h"

namespace plumb::cli {

namespace {

class Counter {
  public:
    explicit Counter(glm::ivec2 size) : size_(size), nearest_(size.x, size.y, 1.0f) {}

    void add(const raster::ScreenTriangle& t) {
        const std::int64_t area = raster::area2(t);
        const bool clockwise = area > 0;
        const double scale = 1 / double(clockwise ? area : -area);
        const auto [left, right] = std::minmax({t.x[0], t.x[1], t.x[2]});
        const auto [top, bottom] = std::minmax({t.y[0], t.y[1], t.y[2]});
        const std::uint64_t before = counts.drawn;
        for (int y = std::max(0, (top + 255) >> 8), end = std::min(size_.y - 1, bottom >> 8); y <= end; ++y) {
            raster::EdgeRow edges[3];
            for (int i = 0; i < 3; ++i) edges[i] = raster::edge_row(t, clockwise, i, y);
            std::int64_t x = std::max(0, (left + 255) >> 8), last = std::min(size_.x - 1, right >> 8);
            raster::covered_columns(edges, x, last);
            for (; x <= last; ++x) {
                double depth = 0;
                for (int i = 0; i < 3; ++i) depth += double(edges[i].value + edges[i].step * x) * scale * t.z[i];
                draw(std::min(float(depth), 1.0f), nearest_(int(x), y));
            }
        }
        counts.triangles += counts.drawn > before;
    }

    LraFragments counts;

  private:
    // A depth buffer that is empty holds 1: nothing lies there.
    void draw(float depth, float& nearest) {
        ++counts.drawn;
        if (!(depth < nearest)) return;
        ++counts.passing;
        if (nearest == 1.0f) ++counts.covered;
        nearest = depth;
    }

    glm::ivec2 size_;
    Image1 nearest_;
};

}  // namespace

LraFragments count_fragments(const Geometry& geometry, const View& view, glm::ivec2 size) {
    const Buffer<glm::vec4> clip = raster::clip_positions(geometry, view, 0);
    const raster::ClipVolume volume = raster::clip_volume(size);
    Counter counter(size);
    raster::ScreenTriangles pieces;
    for (const glm::uvec3& t : geometry.triangles) {
        const glm::vec4 corners[3] = {clip[t.x], clip[t.y], clip[t.z]};
        pieces.triangles.clear(), pieces.corners.clear();
        raster::append_triangle(pieces, corners, 0, size, volume);
        for (const raster::ScreenTriangle& piece : pieces.triangles) counter.add(piece);
    }
    return counter.counts;
}

}  // namespace plumb::cli
