// What an atlas may not do to the scene, and how many texels a surface gets: seen by the rasterizer that receivers come from, and
// by points thrown at the triangles.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>

#include "core/error.h"
#include "gi/probes/atlas.h"
#include "raster/texture_space.h"
#include "tests/gi/random_scene.h"

namespace plumb::test::atlas {

using namespace probes;

inline Scene scene_of(const std::vector<Mesh>& meshes) {
    Scene scene;
    scene.meshes = meshes;
    scene.materials.resize(5);
    return scene;
}
inline Mesh quad(float width, float height) {
    Mesh mesh;
    test::add_quad(mesh, {0, 0, 0}, {width, 0, 0}, {0, 0, -height}, 0);
    return mesh;
}
inline Mesh box(glm::vec3 size) {
    Mesh mesh;
    test::add_box(mesh, {0, 0, 0}, size, 0);
    return mesh;
}
inline Mesh without_uv(Mesh mesh) {
    for (Vertex& v : mesh.vertices) v.u = v.v = 0;
    return mesh;
}
inline Atlas atlas_of(const Scene& scene, const AtlasParams& params = {}) { return make_atlas(scene, flatten(scene), params); }
inline Atlas atlas_of(const Mesh& mesh, const AtlasParams& params = {}) { return atlas_of(scene_of({mesh}), params); }
inline AtlasParams density(double receivers_per_m2) {
    AtlasParams p;
    p.receivers_per_m2 = receivers_per_m2;
    return p;
}
inline AtlasParams side(int size) {
    AtlasParams p;
    p.size = size;
    return p;
}

// The chart at the centre of each texel, by the pass that makes receivers; -1: none.
inline Image<std::int32_t> drawn(const Atlas& a, const Scene& scene) {
    raster::TextureSpace t;
    raster::draw_texture_space(a.geometry, raster::prepare(scene, a.geometry), a.uv, a.size, {}, t);
    Image<std::int32_t> chart(a.size.x, a.size.y, -1);
    for (std::size_t i = 0; i < chart.size(); ++i)
        if (t.id.texels[i].y >= 0) chart.texels[i] = a.chart[std::size_t(t.id.texels[i].y)];
    return chart;
}
inline std::int64_t covered(const Image<std::int32_t>& chart) {
    return std::count_if(chart.texels.begin(), chart.texels.end(), [](std::int32_t c) { return c >= 0; });
}

inline glm::dvec2 in_texels(const Atlas& a, std::uint32_t v) { return glm::dvec2(a.uv[v]) * double(a.size.x); }
inline glm::dvec3 position(const Geometry& g, std::uint32_t v) { return glm::dvec3(g.vertices[v].position); }
inline double texel_area(const Atlas& a, std::size_t t) {
    const glm::uvec3 c = a.geometry.triangles[t];
    const glm::dvec2 e = in_texels(a, c.y) - in_texels(a, c.x), f = in_texels(a, c.z) - in_texels(a, c.x);
    return std::fabs(e.x * f.y - e.y * f.x) / 2;
}
inline double area(const Geometry& g, std::size_t t) {
    const glm::dvec3 n = glm::cross(position(g, g.triangles[t].y) - position(g, g.triangles[t].x),
                                    position(g, g.triangles[t].z) - position(g, g.triangles[t].x));
    return std::sqrt(glm::dot(n, n)) / 2;
}

// What charts touch, found by throwing points at every triangle, 4 a texel each way and the corners; 2^-9 of a texel
// away from the sides, since a chart may reach 2^-10 beyond its rectangle.
inline Image<std::int32_t> touched(const Atlas& a, int& twice) {
    Image<std::int32_t> chart(a.size.x, a.size.y, -1);
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        if (a.chart[t] < 0) continue;
        glm::dvec2 p[3], middle(0);
        for (int k = 0; k < 3; ++k) p[k] = in_texels(a, a.geometry.triangles[t][k]), middle += p[k] / 3.0;
        double longest = 0;
        for (int k = 0; k < 3; ++k) longest = std::max(longest, glm::length(p[(k + 1) % 3] - p[k]));
        const int n = int(std::ceil(longest * 4)) + 1;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n - i; ++j) {
                glm::dvec2 q = (p[0] * double(i) + p[1] * double(j) + p[2] * double(n - i - j)) / double(n);
                for (int c = 0; c < 2; ++c) q[c] += std::clamp(middle[c] - q[c], -0x1p-9, 0x1p-9);
                std::int32_t& at = chart(std::clamp(int(q.x), 0, a.size.x - 1), std::clamp(int(q.y), 0, a.size.y - 1));
                twice += at >= 0 && at != a.chart[t];
                at = a.chart[t];
            }
    }
    return chart;
}
// Pairs of texels of different charts that have fewer than `gap` texels between them.
inline int too_near(const Image<std::int32_t>& chart, int gap) {
    int near = 0;
    for (int y = 0; y < chart.height; ++y)
        for (int x = 0; x < chart.width; ++x)
            for (int v = y; v <= std::min(y + gap, chart.height - 1) && chart(x, y) >= 0; ++v)
                for (int u = std::max(0, x - gap); u <= std::min(x + gap, chart.width - 1); ++u)
                    near += chart(u, v) >= 0 && chart(u, v) != chart(x, y);
    return near;
}

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// What holds of every atlas.
inline void check_atlas(const Scene& scene, const AtlasParams& params, const Atlas& a) {
    const Geometry g = flatten(scene);
    // The scene stays what it is: the same triangles at the same places, in the same order.
    REQUIRE(a.geometry.triangles.size() == g.triangles.size());
    CHECK(a.geometry.material == g.material);
    CHECK(a.geometry.object == g.object);
    REQUIRE(a.geometry.vertices.size() >= g.vertices.size());
    REQUIRE(a.uv.size() == a.geometry.vertices.size());
    REQUIRE(a.geometry.tangents.size() == (g.tangents.empty() ? 0 : a.geometry.vertices.size()));
    int moved = 0, outside = 0, of_two = 0, spread = 0, flipped = 0;
    std::vector<std::int32_t> chart_of(a.uv.size(), -1);
    for (std::size_t t = 0; t < g.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t from = g.triangles[t][k], to = a.geometry.triangles[t][k];
            moved += !same_bits(g.vertices[from], a.geometry.vertices[to]);
            if (!g.tangents.empty()) moved += !same_bits(g.tangents[from], a.geometry.tangents[to]);
            const glm::vec2 uv = a.uv[to];
            outside += !(uv.x >= 0 && uv.y >= 0 && uv.x <= 1 && uv.y <= 1);
            of_two += chart_of[to] >= 0 && chart_of[to] != a.chart[t];
            chart_of[to] = a.chart[t];
            if (a.chart[t] < 0) {
                spread += uv != a.uv[a.geometry.triangles[t][0]];
                continue;
            }
            // Inside of its rectangle, in texels.
            const Chart& chart = a.charts[std::size_t(a.chart[t])];
            CHECK(chart.object == g.object[t]);
            const glm::dvec2 p = in_texels(a, to) - glm::dvec2(chart.origin);
            for (int c = 0; c < 2; ++c) flipped += !(p[c] >= -0.003 && p[c] <= chart.size[c] + 0.003);
        }
    CHECK(moved == 0);
    CHECK(outside == 0);
    CHECK(of_two == 0);
    CHECK(spread == 0);
    CHECK(flipped == 0);
    CHECK(a.size.x == a.size.y);
    if (params.size > 0) CHECK(a.size.x == params.size);
    if (params.size == 0) CHECK(a.texels_per_m == std::sqrt(params.receivers_per_m2));

    int twice = 0;
    const Image<std::int32_t> touches = touched(a, twice);
    CHECK(twice == 0);
    CHECK(too_near(touches, params.gap) == 0);

    // Every chart gets a receiver, but for those that are counted.
    const Image<std::int32_t> centres = drawn(a, scene);
    const std::set<std::int32_t> seen(centres.texels.begin(), centres.texels.end());
    int without = 0;
    for (std::size_t c = 0; c < a.charts.size(); ++c) without += seen.count(std::int32_t(c)) == 0;
    CHECK(without <= a.summary.charts_without_texel);
    for (std::size_t i = 0; i < centres.size(); ++i)
        if (centres.texels[i] >= 0 && centres.texels[i] != touches.texels[i]) ++twice;
    CHECK(twice == 0);
}

inline std::string refusal(const Scene& scene, const AtlasParams& params) {
    try {
        atlas_of(scene, params);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace plumb::test::atlas
