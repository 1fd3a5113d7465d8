// The lightmap atlas (IPR 3.2.1.1): what it may not do to the scene, how many texels a surface gets, and that charts
// keep apart; drawn by the rasterizer that receivers come from, and by points thrown at the triangles.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>

#include "core/content_hash.h"
#include "core/error.h"
#include "gi/probes/atlas.h"
#include "raster/texture_space.h"
#include "tests/gi/random_scene.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

Scene scene_of(const std::vector<Mesh>& meshes) {
    Scene scene;
    scene.meshes = meshes;
    scene.materials.resize(5);
    return scene;
}
Mesh quad(float width, float height) {
    Mesh mesh;
    test::add_quad(mesh, {0, 0, 0}, {width, 0, 0}, {0, 0, -height}, 0);
    return mesh;
}
Mesh box(glm::vec3 size) {
    Mesh mesh;
    test::add_box(mesh, {0, 0, 0}, size, 0);
    return mesh;
}
Mesh without_uv(Mesh mesh) {
    for (Vertex& v : mesh.vertices) v.u = v.v = 0;
    return mesh;
}
Atlas atlas_of(const Scene& scene, const AtlasParams& params = {}) { return make_atlas(scene, flatten(scene), params); }
Atlas atlas_of(const Mesh& mesh, const AtlasParams& params = {}) { return atlas_of(scene_of({mesh}), params); }
AtlasParams density(double receivers_per_m2) {
    AtlasParams p;
    p.receivers_per_m2 = receivers_per_m2;
    return p;
}
AtlasParams side(int size) {
    AtlasParams p;
    p.size = size;
    return p;
}

// The chart at the centre of each texel, by the pass that makes receivers; -1: none.
Image<std::int32_t> drawn(const Atlas& a, const Scene& scene) {
    raster::TextureSpace t;
    raster::draw_texture_space(a.geometry, raster::prepare(scene, a.geometry), a.uv, a.size, {}, t);
    Image<std::int32_t> chart(a.size.x, a.size.y, -1);
    for (std::size_t i = 0; i < chart.size(); ++i)
        if (t.id.texels[i].y >= 0) chart.texels[i] = a.chart[std::size_t(t.id.texels[i].y)];
    return chart;
}
std::int64_t covered(const Image<std::int32_t>& chart) {
    return std::count_if(chart.texels.begin(), chart.texels.end(), [](std::int32_t c) { return c >= 0; });
}

glm::dvec2 in_texels(const Atlas& a, std::uint32_t v) { return glm::dvec2(a.uv[v]) * double(a.size.x); }
glm::dvec3 position(const Geometry& g, std::uint32_t v) { return glm::dvec3(g.vertices[v].position); }
double texel_area(const Atlas& a, std::size_t t) {
    const glm::uvec3 c = a.geometry.triangles[t];
    const glm::dvec2 e = in_texels(a, c.y) - in_texels(a, c.x), f = in_texels(a, c.z) - in_texels(a, c.x);
    return std::fabs(e.x * f.y - e.y * f.x) / 2;
}
double area(const Geometry& g, std::size_t t) {
    const glm::dvec3 n = glm::cross(position(g, g.triangles[t].y) - position(g, g.triangles[t].x),
                                    position(g, g.triangles[t].z) - position(g, g.triangles[t].x));
    return std::sqrt(glm::dot(n, n)) / 2;
}

// What charts touch, found by throwing points at every triangle, 4 a texel each way and the corners; 2^-9 of a texel
// away from the sides, since a chart may reach 2^-10 beyond its rectangle.
Image<std::int32_t> touched(const Atlas& a, int& twice) {
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
int too_near(const Image<std::int32_t>& chart, int gap) {
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
void check_atlas(const Scene& scene, const AtlasParams& params, const Atlas& a) {
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

std::string refusal(const Scene& scene, const AtlasParams& params) {
    try {
        atlas_of(scene, params);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("atlas: a square metre has as many texels as its density says", "[probes][IPR 3.2.1.1][analytic]") {
    for (const Mesh& mesh : {quad(1, 1), without_uv(quad(1, 1))}) {
        const Scene scene = scene_of({mesh});
        const Atlas a = atlas_of(scene, density(100));
        CHECK(a.size == glm::ivec2(10));
        CHECK(covered(drawn(a, scene)) == 100);
        CHECK(a.summary.used == Approx(1).epsilon(1e-6));
        // sqrt 80 = 8.94: nine rows and columns of centres lie within, the outer ones 0.47 texels from the edge.
        const Atlas b = atlas_of(scene, density(80));
        CHECK(b.size == glm::ivec2(9));
        CHECK(covered(drawn(b, scene)) == 81);
        CHECK(b.summary.used == Approx(80.0 / 81));
        double least = 9, most = 0;
        for (std::uint32_t v = 0; v < 4; ++v)
            least = std::min(least, in_texels(b, v).x), most = std::max(most, in_texels(b, v).x);
        CHECK(least == Approx((9 - std::sqrt(80.0)) / 2).margin(1e-5));
        CHECK(most == Approx((9 + std::sqrt(80.0)) / 2).margin(1e-5));
    }
    const Scene scene = scene_of({without_uv(quad(2.5f, 0.4f))});
    CHECK(covered(drawn(atlas_of(scene, density(100)), scene)) == 25 * 4);
}

TEST_CASE("atlas: a flat chart keeps its lengths, and the charts' area is that of the surface",
          "[probes][IPR 3.2.1.1][analytic]") {
    Mesh mesh = without_uv(box({1, 2, 3}));
    mesh.transform = glm::dmat4(glm::dvec4(0.36, 0.48, -0.8, 0), glm::dvec4(-0.8, 0.6, 0, 0),
                                glm::dvec4(0.48, 0.64, 0.6, 0), glm::dvec4(1, -2, 3, 1));  // turned and moved
    const Atlas a = atlas_of(mesh, density(400));
    CHECK(a.charts.size() == 6);
    double sum = 0;
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        const glm::uvec3 c = a.geometry.triangles[t];
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t p = c[k], q = c[(k + 1) % 3];
            const double length = glm::length(position(a.geometry, q) - position(a.geometry, p));
            CHECK(glm::length(in_texels(a, q) - in_texels(a, p)) == Approx(20 * length).epsilon(1e-5));
        }
        sum += texel_area(a, t);
    }
    CHECK(sum == Approx(400 * 22).epsilon(1e-5));
    CHECK(a.summary.used == Approx(400.0 * 22 / a.size.x / a.size.x).epsilon(1e-6));
    // Seen from the front no chart is mirrored: with v down, corners turn counter-clockwise.
    for (const glm::uvec3& c : a.geometry.triangles) {
        const glm::dvec2 e = in_texels(a, c.y) - in_texels(a, c.x), f = in_texels(a, c.z) - in_texels(a, c.x);
        CHECK(e.x * f.y - e.y * f.x < 0);
    }
}

TEST_CASE("atlas: curved charts have the density of flat ones on average", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {0, 0, 0}, 1, 20, 0);
    const Scene scene = scene_of({without_uv(mesh)});
    const Atlas a = atlas_of(scene, density(2000));
    check_atlas(scene, density(2000), a);
    std::vector<double> texels(a.charts.size()), metres(a.charts.size());
    double longest = 0;
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        if (a.chart[t] < 0) continue;
        texels[std::size_t(a.chart[t])] += texel_area(a, t), metres[std::size_t(a.chart[t])] += area(a.geometry, t);
        // At 60 degrees a texel covers two of its sides, before the chart as a whole is scaled up.
        longest = std::max(longest, area(a.geometry, t) * 2000 / texel_area(a, t));
    }
    for (std::size_t c = 0; c < a.charts.size(); ++c) CHECK(texels[c] == Approx(2000 * metres[c]).epsilon(1e-4));
    CHECK(longest < 2);
    CHECK(longest > 1);
}

TEST_CASE("atlas: own coordinates are scaled by the mean edge ratio, and stay as they are",
          "[probes][IPR 3.2.1.1][analytic]") {
    Mesh mesh = quad(2, 1);
    const float uv[4][2] = {{0.25f, 0.75f}, {0.75f, 0.75f}, {0.75f, 0.25f}, {0.25f, 0.25f}};
    for (std::size_t k = 0; k < 4; ++k) mesh.vertices[k].u = uv[k][0], mesh.vertices[k].v = uv[k][1];
    const Atlas a = atlas_of(mesh, density(10000));
    CHECK(a.summary.meshes_kept == 1);
    REQUIRE(a.charts.size() == 1);
    CHECK(a.charts[0].own_uv);
    const double texels = 100 * (2 * 4 + 2 * 2 + std::sqrt(10.0)) / 5;  // of a unit of the coordinates
    for (std::size_t k = 1; k < 4; ++k) {
        const glm::dvec2 step = in_texels(a, std::uint32_t(k)) - in_texels(a, 0);
        CHECK(step.x == Approx(texels * (double(uv[k][0]) - uv[0][0])).margin(1e-3));
        CHECK(step.y == Approx(texels * (double(uv[k][1]) - uv[0][1])).margin(1e-3));
    }
}

TEST_CASE("atlas: islands stay together where they are the gap apart, and are split where not",
          "[probes][IPR 3.2.1.1]") {
    // Two squares of a metre, whose coordinates are metres, `apart` metres from each other.
    auto pair_of = [](float apart) {
        Mesh mesh;
        test::add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
        test::add_quad(mesh, {5, 0, 0}, {6, 0, 0}, {5, 0, -1}, 0);
        for (std::size_t k = 4; k < 8; ++k) mesh.vertices[k].u += 1 + apart;
        return mesh;
    };
    for (const float apart : {0.0f, 0.2f, 0.3f, 0.4f, 0.5f, 10.0f}) {
        CAPTURE(apart);
        const Scene scene = scene_of({pair_of(apart)});
        const Atlas a = atlas_of(scene, density(100));
        check_atlas(scene, density(100), a);
        CHECK(a.summary.meshes_kept == 1);
        // 10 texels a metre, so three are 0.3 m. At 10 m apart a sixth of the rectangle is filled.
        const bool together = apart > 0.295f && apart < 9;
        CHECK(a.charts.size() == (together ? 1 : 2));
        CHECK(a.summary.layouts_split == (together ? 0 : 1));
        if (together) CHECK(in_texels(a, 4).x - in_texels(a, 0).x == Approx(10 * (1 + apart)).margin(1e-3));
    }
}

TEST_CASE("atlas: an island without a texel's centre is taken out of its layout", "[probes][IPR 3.2.1.1]") {
    // A square of 10 x 10 texels and one of a fifth of a texel beside it, on either side of a texel's centre.
    for (const float at : {1.53f, 1.56f}) {
        Mesh mesh;
        test::add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
        test::add_quad(mesh, {5, 0, 0}, {5.02f, 0, 0}, {5, 0, -0.02f}, 0);
        for (std::size_t k = 4; k < 8; ++k)
            mesh.vertices[k].u = at + 0.02f * mesh.vertices[k].u,
            mesh.vertices[k].v = 0.54f + 0.02f * mesh.vertices[k].v;
        const Scene scene = scene_of({mesh});
        const Atlas a = atlas_of(scene, density(100));
        check_atlas(scene, density(100), a);
        CHECK(a.summary.charts_without_texel == 0);
    }
}

TEST_CASE("atlas: smaller charts fill what a frame or a ring leaves", "[probes][IPR 3.2.1.1]") {
    // A ring of 32 corners, radii 2 m and 1.8 m, and squares of 0.1 m to 0.9 m.
    Mesh ring;
    for (int i = 0; i <= 32; ++i)
        for (const double r : {1.8, 2.0}) {
            const double turn = host::pi * (i % 32) / 16;
            ring.vertices.push_back({glm::vec3(r * host::cos(turn), 0, -r * host::sin(turn)), 0, {0, 1, 0}, 0});
        }
    for (unsigned i = 0; i < 64; i += 2) {
        ring.triangles.push_back({i, i + 1, i + 2}), ring.triangles.push_back({i + 2, i + 1, i + 3});
        ring.material.insert(ring.material.end(), 2, 0);
    }
    for (int gap : {0, 1, 3, 5}) {
        CAPTURE(gap);
        std::vector<Mesh> meshes{ring};
        for (int i = 0; i < 60; ++i)
            meshes.push_back(without_uv(quad(0.1f + 0.1f * float(i % 9), 0.1f + 0.05f * float(i % 7))));
        const Scene scene = scene_of(meshes);
        AtlasParams params = density(100);
        params.gap = gap;
        const Atlas a = atlas_of(scene, params);
        check_atlas(scene, params, a);
        const Chart& outer = a.charts[0];
        CHECK(outer.size == glm::ivec2(40));
        int inside = 0;
        for (std::size_t c = 1; c < a.charts.size(); ++c) {
            const glm::ivec2 at = a.charts[c].origin - outer.origin;
            inside += at.x > 0 && at.y > 0 && at.x < 40 && at.y < 40;
        }
        CHECK(inside >= 2);
    }
}

TEST_CASE("atlas: tangents go with their vertices", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {0, 0, 0}, 1, 10, 0);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) mesh.tangents.push_back({float(v), 1, 2, v % 2 ? 1 : -1});
    Scene scene = scene_of({without_uv(mesh)});
    scene.materials[0].normal_texture = 0;
    scene.textures.emplace_back().texels = Image<std::uint32_t>(1, 1, 0xffff8080u);
    const Atlas a = atlas_of(scene);
    CHECK(a.geometry.vertices.size() > mesh.vertices.size());
    REQUIRE_FALSE(a.geometry.tangents.empty());
    check_atlas(scene, {}, a);
}

TEST_CASE("atlas: small and thin charts hold the centre of a texel", "[probes][IPR 3.2.1.1]") {
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        // Triangles from a hundredth of a texel to some texels; a texel is 0.1 m.
        Mesh mesh;
        for (int i = 0; i < 60; ++i) {
            const float size = 0.001f * float(host::pow(600, double(dice.unit()))),
                        thin = dice.one_in(2) ? 1 : dice.between(0.02f, 0.2f);
            const glm::vec3 at = dice.in_box(glm::vec3(-1), glm::vec3(1)), d = dice.direction(), e = dice.direction();
            const unsigned first = unsigned(mesh.vertices.size());
            for (const glm::vec3& p : {at, at + d * size, at + d * (size * dice.unit()) + e * (size * thin)})
                mesh.vertices.push_back({p, 0, {0, 1, 0}, 0});
            mesh.triangles.push_back({first, first + 1, first + 2}), mesh.material.push_back(0);
        }
        const Scene scene = scene_of({mesh});
        const Atlas a = atlas_of(scene, density(100));
        check_atlas(scene, density(100), a);
        // Only where the inner circle is below 1/128 of a texel may one be without.
        int tiny = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            double around = 0;
            for (int k = 0; k < 3; ++k)
                around += glm::length(position(a.geometry, a.geometry.triangles[t][(k + 1) % 3]) -
                                      position(a.geometry, a.geometry.triangles[t][k]));
            tiny += 2 * area(a.geometry, t) / around * 10 < 1.001 / 128;
        }
        CHECK(a.summary.charts_without_texel <= tiny);
    }
}

TEST_CASE("atlas: fine meshes that are small as a whole have a texel", "[probes][IPR 3.2.1.1]") {
    // Balls of 2 mm to 6 cm at 80 receivers a square metre: triangles of a twentieth of a texel at most, charts of a
    // half.
    for (const float radius : {0.001f, 0.003f, 0.01f, 0.02f, 0.03f}) {
        CAPTURE(radius);
        Mesh mesh;
        test::add_ball(mesh, {0.3f, 0.2f, 0.1f}, radius, 20, 0);
        const Scene scene = scene_of({without_uv(mesh)});
        const Atlas a = atlas_of(scene);
        check_atlas(scene, {}, a);
        CHECK(a.charts.size() >= 4);
        if (radius == 0.03f) CHECK(a.summary.charts_without_texel == 0);
    }
}

TEST_CASE("atlas: holds for scenes of all sorts, gaps and sizes", "[probes][IPR 3.2.1.1]") {
    int cut = 0, kept = 0;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        Scene scene;
        test::add_materials(dice, scene);
        for (Material& m : scene.materials) m.alpha_cutoff = 0;  // holes are the receivers' concern
        test::add_meshes(dice, scene);
        if (flatten(scene).triangles.empty()) continue;
        if (dice.one_in(2)) scene.meshes[0] = without_uv(scene.meshes[0]);
        if (dice.one_in(3)) scene.meshes[0].tangents.assign(scene.meshes[0].vertices.size(), glm::vec4(1, 0, 0, 1));
        if (dice.one_in(3)) scene.materials[0].normal_texture = 0;
        AtlasParams params;
        params.gap = dice.below(6);
        params.receivers_per_m2 = dice.between(5, 100);
        if (dice.one_in(2)) params.size = 64 + dice.below(200);
        const Atlas a = atlas_of(scene, params);
        check_atlas(scene, params, a);
        cut += a.summary.meshes_cut, kept += a.summary.meshes_kept;
    }
    CHECK(cut > 10);
    CHECK(kept > 10);
}

TEST_CASE("atlas: a size is filled with the largest density that fits", "[probes][IPR 3.2.1.1][analytic]") {
    CHECK(atlas_of(quad(1, 1), side(100)).texels_per_m == Approx(100).epsilon(1e-6));
    // Six squares of a cube and two gaps of 3: 83 texels a side; the scale is found within 2^(1/256).
    const Atlas a = atlas_of(box({1, 1, 1}), side(256));
    CHECK(a.texels_per_m <= 83.01);
    CHECK(a.texels_per_m >= 83 * host::exp2(-1 / 256.0));
    // More texels, more density.
    double before = 0;
    for (int size : {32, 64, 128, 256, 512}) {
        const Scene scene = scene_of({box({1, 2, 3}), quad(4, 1)});
        const Atlas b = atlas_of(scene, side(size));
        check_atlas(scene, side(size), b);
        CHECK(b.texels_per_m > before);
        before = b.texels_per_m;
    }
}

TEST_CASE("atlas: any unit of length", "[probes][extreme]") {
    // 0.2 mm and 2000 km across: the same atlas, since all lengths are powers of two apart.
    const Atlas metre = atlas_of(scene_of({box({1, 0.5f, 0.25f}), quad(1, 1)}), side(128));
    for (const int exponent : {-12, 21}) {
        const float scale = std::ldexp(1.0f, exponent);
        const Scene scene = scene_of({box(scale * glm::vec3(1, 0.5f, 0.25f)), quad(scale, scale)});
        const Atlas a = atlas_of(scene, side(128));
        check_atlas(scene, side(128), a);
        CHECK(a.uv == metre.uv);
        CHECK(a.texels_per_m == Approx(metre.texels_per_m / scale).epsilon(1e-12));
    }
    // At the default density a scene of 0.2 mm has a texel a chart.
    const Scene small = scene_of({box(glm::vec3(2e-4f))});
    const Atlas a = atlas_of(small);
    check_atlas(small, {}, a);
    for (const Chart& chart : a.charts) CHECK(chart.size == glm::ivec2(1));
}

TEST_CASE("atlas: triangles without area have no texels and change nothing for others", "[probes][degenerate]") {
    const Scene plain = scene_of({box({1, 1, 1})});
    Scene with = plain;
    Mesh& mesh = with.meshes[0];
    mesh.triangles.insert(mesh.triangles.begin() + 3, {0, 0, 1});  // a line
    mesh.triangles.insert(mesh.triangles.begin(), {4, 4, 4});      // a point
    mesh.triangles.push_back({1, 1, 6});                           // a line
    mesh.material.assign(mesh.triangles.size(), 0);
    with.meshes.emplace_back();  // nothing but a point
    with.meshes[1].vertices.assign(3, with.meshes[0].vertices[0]);
    with.meshes[1].triangles = {{0, 1, 2}}, with.meshes[1].material = {0};
    const Atlas a = atlas_of(with, density(80)), b = atlas_of(plain, density(80));
    check_atlas(with, density(80), a);
    CHECK(a.size == b.size);
    CHECK(a.charts.size() == b.charts.size());
    std::int64_t none = 0;
    for (std::size_t t = 0; t < a.chart.size(); ++t) none += a.chart[t] < 0;
    CHECK(a.summary.triangles_without_area == none);
    CHECK(none >= 3);
    CHECK(covered(drawn(a, with)) == covered(drawn(b, plain)));
    // Its place is that of a neighbour, so that a ray which hits it finds light from there.
    CHECK(a.uv[a.geometry.triangles[0].x] == b.uv[b.geometry.triangles[2].x]);
}

TEST_CASE("atlas: refuses what it cannot do, in one line that says why", "[probes][input]") {
    const Scene one = scene_of({quad(1, 1)});
    CHECK(refusal(Scene{}, {}) == "atlas: scene: no surfaces: expected a triangle that has an area");
    Mesh line;
    line.vertices.assign(3, {{1, 2, 3}, 0, {0, 1, 0}, 0});
    line.triangles = {{0, 1, 2}}, line.material = {0};
    CHECK(refusal(scene_of({line}), {}) == "atlas: scene: no surfaces: expected a triangle that has an area");
    CHECK_THAT(refusal(scene_of({quad(2e6f, 2e6f)}), {}),
               Catch::Contains("4e+12 m2 of surfaces with 80 receivers a m2: expected what fits"));
    AtlasParams low;
    low.max_size = 8;
    CHECK_THAT(refusal(one, low), Catch::Contains("8 x 8 texels"));
    low.max_size = 9;
    CHECK(refusal(one, low).empty());
    // Six charts of one texel and the gaps between them take 9 x 5 texels at least.
    CHECK(refusal(scene_of({box({1, 1, 1})}), side(8)) ==
          "atlas: size = 8: expected room for 6 charts and 3 texels between any two");
    CHECK(refusal(scene_of({box({1, 1, 1})}), side(9)).empty());

    for (double bad : {0.0, -1.0, HUGE_VAL, double(std::nanf(""))})
        CHECK_THAT(refusal(one, density(bad)), Catch::Contains("receivers_per_m2 = "));
    AtlasParams p;
    p.gap = -1;
    CHECK_THAT(refusal(one, p), Catch::Contains("gap = -1: expected 0 to 64"));
    p = {}, p.size = -1;
    CHECK_THAT(refusal(one, p), Catch::Contains("size = -1: expected 0 to 16384"));
    p = {}, p.max_size = 16385;
    CHECK_THAT(refusal(one, p), Catch::Contains("max_size = 16385: expected 1 to 16384"));
    for (double bad : {0.0, 81.0, double(std::nanf(""))}) {
        p = {}, p.chart_angle_deg = bad;
        CHECK_THAT(refusal(one, p), Catch::Contains("chart_angle_deg = "));
    }
}

TEST_CASE("atlas: twice the same, and a mesh's charts do not depend on its neighbours", "[probes][bits]") {
    Mesh ball;
    test::add_ball(ball, {0, 0, 0}, 1, 12, 0);
    const Scene scene = scene_of({without_uv(ball), box({1, 2, 3}), quad(2, 2), without_uv(ball)});
    const Atlas a = atlas_of(scene), b = atlas_of(scene);
    CHECK(a.uv == b.uv);
    CHECK(a.chart == b.chart);
    // The first and the last mesh are equal, so are their charts.
    const std::size_t n = ball.triangles.size(), last = a.chart.size() - n;
    std::int32_t offset = 0;
    for (std::size_t t = 0; t < n; ++t)
        if (a.chart[t] == 0) offset = a.chart[last + t];
    int differ = 0;
    for (std::size_t t = 0; t < n; ++t) differ += a.chart[last + t] != (a.chart[t] < 0 ? -1 : a.chart[t] + offset);
    CHECK(offset > 0);
    CHECK(differ == 0);
}

TEST_CASE("atlas: the same bits from every compiler", "[probes][bits]") {
    // Written by GCC 12 without optimisation; with -O2, with -O3 for AVX2 and FMA, and by clang they are the same.
    Mesh ball;
    test::add_ball(ball, {0.1f, 0.2f, 0.3f}, 1, 24, 0);
    const Scene scene = scene_of({without_uv(ball), box({1, 2, 3}), quad(2, 1.7f), ball});
    for (const auto& [params, expected] :
         {std::pair(density(80), "578739ef58b05961"), std::pair(side(200), "72f11dea64ec9bc1")}) {
        const Atlas a = atlas_of(scene, params);
        std::uint64_t hash = content_hash(a.uv.data(), a.uv.size() * sizeof(glm::vec2));
        hash = content_hash(a.chart.data(), a.chart.size() * sizeof(std::int32_t), hash);
        CHECK(hash_text(hash) == expected);
    }
}
