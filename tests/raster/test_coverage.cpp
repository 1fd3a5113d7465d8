#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "drawing.h"
#include "raster/visibility.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

struct Point {
    std::int64_t x, y;  // 1/256 pixel; the centre of pixel (0, 0) is (0, 0)
};
std::int64_t cross(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Of c from the line through a and b, positive on its inner side.
double distance(Point a, Point b, Point c) {
    return double(cross(a, b, c)) / std::hypot(double(b.x - a.x), double(b.y - a.y));
}

// A triangulation in window coordinates: points and triangles of positive area.
struct Triangulation {
    std::vector<Point> points;
    std::vector<glm::ivec3> triangles;
};

// Cuts a rectangle around the frame by random points within triangles and by flips of shared edges. Half of the points
// lie on pixel centres or on the lines between them, where ties are.
Triangulation random_triangulation(glm::ivec2 size, int cuts, Random& random) {
    const std::int64_t margin = 256 * (1 + random.below(40)) + random.below(256);
    const std::int64_t right = 256 * size.x + margin, bottom = 256 * size.y + margin;
    Triangulation t{{{-margin, -margin}, {right, -margin}, {right, bottom}, {-margin, bottom}}, {{0, 1, 2}, {0, 2, 3}}};
    for (int i = 0; i < cuts; ++i) {
        const int chosen = random.below(int(t.triangles.size()));
        const glm::ivec3 corners = t.triangles[chosen];
        const Point a = t.points[corners.x], b = t.points[corners.y], c = t.points[corners.z];
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        Point p{a.x + std::int64_t(u * double(b.x - a.x) + v * double(c.x - a.x)),
                a.y + std::int64_t(u * double(b.y - a.y) + v * double(c.y - a.y))};
        const int grid = random.below(4);
        if (grid == 1 || grid == 3) p.x &= ~std::int64_t(255);
        if (grid == 2 || grid == 3) p.y &= ~std::int64_t(255);
        if (cross(a, b, p) > 0 && cross(b, c, p) > 0 && cross(c, a, p) > 0) {
            const int n = int(t.points.size());
            t.points.push_back(p);
            t.triangles[chosen] = {corners.x, corners.y, n};
            t.triangles.push_back({corners.y, corners.z, n});
            t.triangles.push_back({corners.z, corners.x, n});
        }
        // Flip the edge that two random neighbours share, where their union is strictly convex.
        const int first = random.below(int(t.triangles.size())), e = random.below(3);
        const int from = t.triangles[first][e], to = t.triangles[first][(e + 1) % 3];
        const int apex = t.triangles[first][(e + 2) % 3];
        for (std::size_t second = 0; second < t.triangles.size(); ++second)
            for (int k = 0; k < 3; ++k) {
                if (t.triangles[second][k] != to || t.triangles[second][(k + 1) % 3] != from) continue;
                const int opposite = t.triangles[second][(k + 2) % 3];
                const glm::ivec3 one{apex, from, opposite}, two{apex, opposite, to};
                auto area = [&](glm::ivec3 x) { return cross(t.points[x.x], t.points[x.y], t.points[x.z]); };
                if (area(one) > 0 && area(two) > 0) t.triangles[first] = one, t.triangles[second] = two;
                second = t.triangles.size() - 1;
                break;
            }
    }
    return t;
}

// The clip position that snaps to p: window X = (x + 1) side / 2.
glm::vec2 ndc(Point p, glm::ivec2 size) {
    return {float((p.x / 256.0 + 0.5) * 2 / size.x - 1), float((p.y / 256.0 + 0.5) * 2 / size.y - 1)};
}

Geometry geometry_of(const Triangulation& t, glm::ivec2 size, Random& random) {
    Geometry g;
    for (const Point& p : t.points) g.vertices.push_back(at(glm::vec3(ndc(p, size), float(random.uniform()))));
    for (const glm::ivec3& c : t.triangles) {
        const bool turned = random.below(2) != 0;
        g.triangles.push_back(turned ? glm::uvec3(c.x, c.z, c.y) : glm::uvec3(c));
        g.material.push_back(0);
        g.object.push_back(0);
    }
    return g;
}

Geometry one_triangle(const Point (&corners)[3], glm::ivec2 size, float z = 0.5f) {
    Geometry g;
    add_triangle(g, at({ndc(corners[0], size), z}), at({ndc(corners[1], size), z}), at({ndc(corners[2], size), z}));
    return g;
}

std::vector<glm::ivec2> covered(const Geometry& g, glm::ivec2 size) {
    std::vector<glm::ivec2> pixels;
    const Image<int> count = coverage(g, clip_space_view(), size);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            if (count(x, y)) pixels.push_back({x, y});
    return pixels;
}

int sum(const Image<int>& image) {
    int total = 0;
    for (int v : image.texels) total += v;
    return total;
}

}  // namespace

TEST_CASE("coverage: every triangulation of the screen covers each pixel exactly once", "[raster][coverage]") {
    const struct {
        glm::ivec2 size;
        int seeds, cuts;
    } cases[] = {{{1, 1}, 200, 30}, {{7, 5}, 200, 60}, {{1000, 562}, 6, 1500}, {{333, 1}, 20, 200}};
    for (const auto& c : cases)
        for (int seed = 0; seed < c.seeds; ++seed) {
            Random random(std::uint64_t(1000 * c.size.x + seed));
            const Geometry g = geometry_of(random_triangulation(c.size, c.cuts, random), c.size, random);
            const Image<int> count = coverage(g, clip_space_view(), c.size);
            int wrong = 0;
            for (int v : count.texels) wrong += v != 1;
            CAPTURE(c.size.x, c.size.y, seed, g.triangles.size());
            REQUIRE(wrong == 0);
        }
}

TEST_CASE("coverage: drawing leaves no pixel of a triangulation empty", "[raster][coverage]") {
    Random random(7);
    const glm::ivec2 size{1000, 562};
    const Geometry g = geometry_of(random_triangulation(size, 3000, random), size, random);
    const VisibilityBuffer v = draw_visibility(g, clip_space_view(), size, {});
    REQUIRE(std::count(v.triangle.texels.begin(), v.triangle.texels.end(), -1) == 0);
    for (const glm::vec2& l : v.barycentrics.texels) {
        REQUIRE((l.x >= 0 && l.y >= 0));
        REQUIRE(l.x + l.y <= 1 + 0x1p-22f);
    }
}

// Corners on pixel centres, in pixels; the sets follow from "top and left edges belong to the triangle".
TEST_CASE("coverage: a centre on a top or left edge is in, on a right or bottom edge out", "[raster][coverage]") {
    const glm::ivec2 size{4, 4};
    using Pixels = std::vector<glm::ivec2>;
    CHECK(covered(one_triangle({{0, 0}, {512, 0}, {0, 512}}, size), size) == Pixels{{0, 0}, {1, 0}, {0, 1}});
    CHECK(covered(one_triangle({{512, 0}, {512, 512}, {0, 512}}, size), size) == Pixels{{1, 1}});
    CHECK(covered(one_triangle({{0, 0}, {512, 512}, {0, 512}}, size), size) == Pixels{{0, 1}});
    CHECK(covered(one_triangle({{0, 0}, {512, 0}, {512, 512}}, size), size) == Pixels{{0, 0}, {1, 0}, {1, 1}});
    // The same, wound the other way.
    CHECK(covered(one_triangle({{0, 0}, {0, 512}, {512, 0}}, size), size) == Pixels{{0, 0}, {1, 0}, {0, 1}});
    CHECK(covered(one_triangle({{512, 0}, {0, 512}, {512, 512}}, size), size) == Pixels{{1, 1}});
}

TEST_CASE("coverage: window coordinates are rounded to 1/256 pixel, ties to even", "[raster][coverage]") {
    // side 2: (X - 1/2) 256 = 256 x + 128.
    CHECK(snap(0.5 / 256, 1, 2) == 128);
    CHECK(snap(1.5 / 256, 1, 2) == 130);
    CHECK(snap(-0.5 / 256, 1, 2) == 128);
    CHECK(snap(-1.5 / 256, 1, 2) == 126);
    CHECK(snap(2.5 / 256, 1, 2) == 130);
    // side 3, w = 3: 128 x + 256; x / w itself has no exact double.
    CHECK(snap(0.5 / 128, 3, 3) == 256);
    CHECK(snap(1.5 / 128, 3, 3) == 258);
    CHECK(snap(-1.5 / 128, 3, 3) == 254);
}

TEST_CASE("coverage: snapping is that of exact arithmetic", "[raster][coverage]") {
    // x = k / 2^f and w = m / 2^23 are floats: x 128 side / w = k 128 side 2^(23 - f) / m, rounded in 128-bit integers.
    Random random(3);
    int ties = 0;
    for (int i = 0; i < 200000; ++i) {
        const int side = 1 + random.below(4096), f = 8 + random.below(24);
        __extension__ typedef __int128 Wide128;
        const std::int64_t few_bits = (1 + random.below(255)) * std::int64_t(1 << 15);
        const std::int64_t m = i % 4 == 0 ? few_bits : (1 << 23) + random.below(1 << 23);
        const std::int64_t k = random.below(1 << (1 + random.below(24))) - (1 << 10);
        const Wide128 numerator = Wide128(k) * 128 * side * (std::int64_t(1) << 23), denominator = Wide128(m) << f;
        Wide128 quotient = numerator / denominator, rest = numerator % denominator;
        if (rest < 0) rest += denominator, quotient -= 1;
        if (2 * rest == denominator) ++ties;
        if (2 * rest > denominator || (2 * rest == denominator && (quotient & 1))) ++quotient;
        if (quotient > (1 << 24) || quotient < -(1 << 24)) continue;
        const double x = double(k) / double(std::int64_t(1) << f), w = double(m) / (1 << 23);
        REQUIRE(float(x) == x);
        REQUIRE(float(w) == w);
        CAPTURE(side, f, m, k);
        REQUIRE(snap(x, w, side) == std::int64_t(quotient) + 128 * (side - 1));
    }
    REQUIRE(ties > 100);
}

TEST_CASE("coverage: zero area, points, slivers between centres and far outside draw nothing", "[raster][coverage]") {
    const glm::ivec2 size{16, 16};
    CHECK(covered(one_triangle({{0, 0}, {1024, 1024}, {2048, 2048}}, size), size).empty());
    CHECK(covered(one_triangle({{512, 512}, {512, 512}, {512, 512}}, size), size).empty());
    CHECK(covered(one_triangle({{-256, 100}, {4096, 101}, {4096, 102}}, size), size).empty());
    CHECK(covered(one_triangle({{5000, 0}, {9000, 0}, {5000, 4000}}, size), size).empty());
    // A sliver of 1/256 pixel that contains a row of centres has them all: x = 0..15 lie on its top edge.
    CHECK(covered(one_triangle({{-256, 512}, {8192, 512}, {8192, 513}}, size), size).size() == 16);
}

TEST_CASE("coverage: a triangle a million pixels wide covers what it should", "[raster][coverage]") {
    // Its edge x + y = 0 in clip space runs from corner to corner of the frame, half of which is covered.
    const glm::ivec2 size{64, 64};
    for (float scale : {1.0f, 100.0f, 16384.0f, 1e6f, 1e10f}) {
        Geometry g;
        add_triangle(g, at({-scale, scale, 0.5f}), at({scale, -scale, 0.5f}), at({-scale, -scale, 0.5f}));
        const Image<int> count = coverage(g, clip_space_view(), size);
        CAPTURE(scale);
        // Clipping may move the edge by half of 1/256 pixel, so that the diagonal's own centres may go either way.
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                if (x + y != 63) REQUIRE(count(x, y) == (x + y < 63 ? 1 : 0));
    }
    Geometry g;
    add_triangle(g, at({-3e7f, -1e7f, 0.5f}), at({3e7f, -1e7f, 0.5f}), at({0, 3e7f, 0.5f}));
    CHECK(sum(coverage(g, clip_space_view(), {1000, 562})) == 562000);
}

TEST_CASE("coverage: a ground that passes below and behind the viewer is covered exactly once", "[raster][coverage]") {
    Camera camera;
    camera.position = {0, 1, 0};
    camera.look_at = {0.1, 0.9, -1};
    camera.fov_y_deg = 80;
    camera.near = 0.01, camera.far = 1e7;
    const glm::ivec2 size{320, 200};
    for (bool reversed : {false, true})
        for (int seed = 0; seed < 20; ++seed) {
            camera.reversed_z = reversed;
            // Cut a square of +-10^6 m at random points near the viewer, of which many lie at w <= 0. They keep 0.5 m
            // from the edges: clip positions of the far corners are rounded to 0.06 m.
            Random random(std::uint64_t(100 + seed));
            Triangulation t{{{-1000000, -1000000}, {1000000, -1000000}, {1000000, 1000000}, {-1000000, 1000000}},
                            {{0, 1, 2}, {0, 2, 3}}};
            for (int i = 0; i < 60; ++i) {
                const Point p{random.below(41) - 20, random.below(41) - 20};
                for (std::size_t k = 0; k < t.triangles.size(); ++k) {
                    const glm::ivec3 c = t.triangles[k];
                    if (!(distance(t.points[c.x], t.points[c.y], p) > 0.5 &&
                          distance(t.points[c.y], t.points[c.z], p) > 0.5 &&
                          distance(t.points[c.z], t.points[c.x], p) > 0.5))
                        continue;
                    const int n = int(t.points.size());
                    t.points.push_back(p);
                    t.triangles[k] = {c.x, c.y, n};
                    t.triangles.push_back({c.y, c.z, n});
                    t.triangles.push_back({c.z, c.x, n});
                    break;
                }
            }
            Geometry g;
            for (const Point& p : t.points) g.vertices.push_back(at({float(p.x), 0, float(p.y)}));
            for (const glm::ivec3& c : t.triangles) g.triangles.push_back(glm::uvec3(c));
            const Image<int> count = coverage(g, make_view(camera, 1.6), size);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    // Below the horizon by 1/100, so nearer than 100 m; above it, nothing.
                    const double slope = ray_through_pixel(camera, size, {x, y}).direction.y;
                    CAPTURE(seed, x, y, slope);
                    if (slope < -0.01) REQUIRE(count(x, y) == 1);
                    if (slope > 1e-3) REQUIRE(count(x, y) == 0);
                }
        }
}

TEST_CASE("coverage: what is nearer than the near plane or beyond the far one is cut", "[raster][coverage][clip]") {
    Camera camera;
    camera.position = {0, 1, 0};
    camera.look_at = {0.3, 0.6, -1};
    camera.fov_y_deg = 90;
    camera.near = 2, camera.far = 5;
    Geometry g;
    add_triangle(g, at({-500, 0, 400}), at({500, 0, 400}), at({0, 0, -900}));
    const glm::ivec2 size{120, 90};
    for (bool reversed : {false, true}) {
        camera.reversed_z = reversed;
        const Image<int> count = coverage(g, make_view(camera, 120.0 / 90), size);
        int seen = 0, cut_near = 0, cut_far = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                // Eye depth where the ray meets the ground y = 0; infinite above the horizon.
                const Ray ray = ray_through_pixel(camera, size, {x, y});
                const double t = ray.direction.y < 0 ? -1 / ray.direction.y : 1e9;
                const double depth = linear_depth(camera, ray.origin + ray.direction * t);
                CAPTURE(reversed, x, y, depth);
                // 1/512 pixel is less than 1e-3 of the depth here.
                const bool within = depth > 2.002 && depth < 4.995, nearer = depth < 1.998, farther = depth > 5.005;
                if (within) REQUIRE(count(x, y) == 1);
                if (nearer || farther) REQUIRE(count(x, y) == 0);
                seen += within, cut_near += nearer, cut_far += farther;
            }
        REQUIRE((seen > 500 && cut_near > 500 && cut_far > 500));
    }
}

// Slivers that cross the near plane: their clipped polygons are narrower than what snapping moves a corner.
TEST_CASE("coverage: no piece of a clipped triangle turns against the whole", "[raster][coverage][clip]") {
    const glm::ivec2 size{64, 48};
    const ClipVolume volume = clip_volume(size);
    Random random(31);
    int bent = 0;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec4 a(random.vector(-1, 1), 1.5f), b(random.vector(-1, 1), 2);
        const float along = float(random.uniform()), width = 4e-3f;
        glm::vec4 corners[3] = {a, b, a + along * (b - a) + glm::vec4(random.vector(-width, width), 0)};
        corners[i % 3].z = -0.7f;
        std::int64_t whole = 0;
        bool clockwise = false, counter = false;
        const ClipPolygon polygon = clip(volume, corners);
        for (int k = 0; k + 2 < polygon.count; ++k) {
            ScreenTriangle piece{};
            for (int c = 0; c < 3; ++c) {
                const glm::dvec4 p = polygon.vertices[c ? k + c : 0].position;
                piece.x[c] = snap(p.x, p.w, size.x), piece.y[c] = snap(p.y, p.w, size.y);
            }
            const std::int64_t area = area2(piece);
            whole += area, clockwise |= area > 0, counter |= area < 0;
        }
        bent += clockwise && counter;
        ScreenTriangles out;
        append_triangle(out, corners, 0, size, volume);
        for (const ScreenTriangle& t : out.triangles) REQUIRE((area2(t) > 0) == (whole > 0));
    }
    REQUIRE(bent > 50);
}

// A ceiling that meets the near plane at a row of centres. Its corners are so far off that the clipped w, which is the
// near distance, is a small difference of large products: z / w exceeds 1 by more than a float's rounding.
TEST_CASE("depth test: no depth exceeds 1, however far off the corners are", "[raster][depth][clip]") {
    Camera camera;
    camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1};
    camera.fov_y_deg = 90;
    camera.near = 1.0 / 128, camera.far = INFINITY, camera.reversed_z = true;
    const View view = make_view(camera, 1);
    Random random(17);
    int ones = 0;
    for (int i = 0; i < 300; ++i) {
        const float y = 0.75f / 128, far = float(random.between(1e8, 1e10)), behind = float(random.between(1e8, 1e10));
        Geometry g;
        add_triangle(g, at({0, y, -far}), at({-behind, y, behind}), at({behind, y, behind}));
        for (float depth : draw_visibility(g, view, {4, 4}, {}).depth.texels) {
            REQUIRE((depth >= 0 && depth <= 1));
            ones += depth == 1;
        }
    }
    REQUIRE(ones > 50);
}

TEST_CASE("depth test: of equal depths the earlier triangle stays", "[raster][depth]") {
    const glm::ivec2 size{8, 8};
    const Point corners[3] = {{-300, -300}, {5000, -300}, {-300, 5000}};
    Geometry g = one_triangle(corners, size);
    for (int i = 0; i < 2; ++i) {
        const Geometry again = one_triangle(corners, size);
        add_triangle(g, again.vertices[0], again.vertices[1], again.vertices[2]);
    }
    View view = clip_space_view();
    for (bool reversed : {false, true}) {
        view.reversed_z = reversed;
        const VisibilityBuffer v = draw_visibility(g, view, size, {});
        REQUIRE(std::count(v.triangle.texels.begin(), v.triangle.texels.end(), 0) == 64);
    }
    // A nearer one drawn later wins, a farther one does not.
    for (Vertex* v = &g.vertices[3]; v != &g.vertices[6]; ++v) v->position.z = 0.4f;
    for (Vertex* v = &g.vertices[6]; v != &g.vertices[9]; ++v) v->position.z = 0.6f;
    for (bool reversed : {false, true}) {
        view.reversed_z = reversed;
        const VisibilityBuffer v = draw_visibility(g, view, size, {});
        REQUIRE(std::count(v.triangle.texels.begin(), v.triangle.texels.end(), reversed ? 2 : 1) == 64);
        REQUIRE(v.depth(3, 3) == (reversed ? 0.6f : 0.4f));
    }
}

TEST_CASE("visibility: sizes and vertices out of range are refused by name", "[raster]") {
    Geometry g = one_triangle({{0, 0}, {512, 0}, {0, 512}}, {4, 4});
    CHECK_THROWS_AS(draw_visibility(g, clip_space_view(), {0, 4}, {}), InputError);
    CHECK_THROWS_AS(draw_visibility(g, clip_space_view(), {4, 40000}, {}), InputError);
    g.vertices[1].position.y = std::nanf("");
    CHECK_THROWS_WITH(draw_visibility(g, clip_space_view(), {4, 4}, {}), Catch::Contains("vertex 1"));
}

TEST_CASE("visibility: frames of 1 x 1 and 16384 x 1, and no triangle at all", "[raster]") {
    Geometry g;
    CHECK(draw_visibility(g, clip_space_view(), {3, 2}, {}).triangle(2, 1) == -1);
    add_triangle(g, at({-1, -1, 0.25f}), at({3, -1, 0.25f}), at({-1, 3, 0.25f}));
    CHECK(draw_visibility(g, clip_space_view(), {1, 1}, {}).triangle(0, 0) == 0);
    const VisibilityBuffer wide = draw_visibility(g, clip_space_view(), {16384, 1}, {});
    CHECK(std::count(wide.triangle.texels.begin(), wide.triangle.texels.end(), 0) == 16384);
    CHECK(wide.depth(16383, 0) == 0.25f);
}
