// What the raster tests share: geometry placed straight in clip space, a random stream, analytic rays.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/scene.h"
#include "raster/screen_triangle.h"

namespace plumb::raster::test {

// x, y in [-1, 1] are the frame (y down), z is the depth buffer's, w = 1.
inline View clip_space_view() {
    View view;
    view.orthographic = true;
    view.forward = {0, 0, 1};
    view.eye = {0, 0, 0};
    return view;
}

// PCG (O'Neill 2014), 32 bits a call.
struct Random {
    std::uint64_t state;
    explicit Random(std::uint64_t seed) : state(seed * 2 + 1) { next(), next(); }
    std::uint32_t next() {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const std::uint32_t x = std::uint32_t(((state >> 18) ^ state) >> 27), turn = std::uint32_t(state >> 59);
        return (x >> turn) | (x << ((32 - turn) & 31));
    }
    int below(int n) { return int(next() % std::uint32_t(n)); }
    double uniform() { return next() * 0x1p-32; }
    double between(double low, double high) { return low + (high - low) * uniform(); }
    glm::vec3 vector(double low, double high) {
        const double x = between(low, high), y = between(low, high), z = between(low, high);
        return {x, y, z};
    }
};

inline void add_triangle(Geometry& g, const Vertex& a, const Vertex& b, const Vertex& c, int material = 0,
                         int object = 0) {
    const std::uint32_t first = std::uint32_t(g.vertices.size());
    g.vertices.insert(g.vertices.end(), {a, b, c});
    g.triangles.push_back({first, first + 1, first + 2});
    g.material.push_back(material);
    g.object.push_back(object);
}

inline Vertex at(const glm::vec3& position, const glm::vec3& normal = {0, 0, 0}, float u = 0, float v = 0) {
    return {position, u, normal, v};
}

// How many triangles cover each pixel, without a depth test.
inline Image<int> coverage(const Geometry& geometry, const View& view, glm::ivec2 size) {
    Image<int> count(size.x, size.y, 0);
    const ScreenTriangles screen = screen_triangles(geometry, view, size, 1);
    for (const ScreenTriangle& t : screen.triangles)
        for (int y = 0; y < size.y; ++y) {
            const bool clockwise = area2(t) > 0;
            const EdgeRow edges[3] = {edge_row(t, clockwise, 0, y), edge_row(t, clockwise, 1, y),
                                      edge_row(t, clockwise, 2, y)};
            std::int64_t first = 0, last = size.x - 1;
            covered_columns(edges, first, last);
            for (std::int64_t x = first; x <= last; ++x) ++count(int(x), y);
        }
    return count;
}

inline double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace plumb::raster::test
