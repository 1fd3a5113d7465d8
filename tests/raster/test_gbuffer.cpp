#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/formats.h"
#include "drawing.h"
#include "raster/gbuffer.h"
#include "raster/visibility.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

Scene plain_scene() {
    Scene scene;
    scene.materials.push_back({"grey", glm::vec3(0.25f, 0.5f, 0.75f), glm::vec3(1, 2, 3), -1});
    return scene;
}

GBuffer draw(const Scene& scene, const Geometry& g, const View& view, glm::ivec2 size, RunOptions options = {},
             Layout layout = Layout::fp32) {
    GBuffer out;
    draw_gbuffer(g, prepare(scene, g), view, size, layout, options, out);
    return out;
}

// A quad in clip space that fills the frame, with texture coordinates (0, 0) top left to (u, v) bottom right.
Geometry frame_quad(float u = 1, float v = 1, float u0 = 0, float v0 = 0) {
    const glm::vec3 n(0, 0, -1);
    const Vertex a = at({-1, -1, 0.5f}, n, u0, v0), b = at({1, -1, 0.5f}, n, u0 + u, v0);
    const Vertex c = at({1, 1, 0.5f}, n, u0 + u, v0 + v), d = at({-1, 1, 0.5f}, n, u0, v0 + v);
    Geometry g;
    add_triangle(g, a, b, c);
    add_triangle(g, a, c, d);
    return g;
}

Scene textured(const Image<std::uint32_t>& texels, Filter filter, bool srgb) {
    Scene scene = plain_scene();
    scene.materials[0].reflectance = glm::vec3(1);
    scene.materials[0].texture = 0;
    scene.textures.push_back({"texture", texels, srgb, filter});
    return scene;
}

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0);
}

// Triangles of all sizes in front of, around and behind the viewer.
Geometry soup(int n, std::uint64_t seed) {
    Random random(seed);
    Geometry g;
    for (int i = 0; i < n; ++i) {
        const glm::vec3 centre = random.vector(-6, 6) - glm::vec3(0, 0, 5);
        const double r = i % 50 == 0 ? 20 : random.between(0.01, 1.5);
        Vertex v[3];
        for (Vertex& x : v) {
            x.position = centre + random.vector(-r, r);
            x.normal = random.vector(-1, 1);
            x.u = float(random.between(-3, 3)), x.v = float(random.between(-3, 3));
        }
        add_triangle(g, v[0], v[1], v[2], i % 3, i % 7);
    }
    return g;
}

Scene soup_scene() {
    Scene scene = plain_scene();
    scene.materials[0].emission = {0.1f, 2.3f, 3000.7f};
    scene.materials.push_back({"bilinear", glm::vec3(0.5f), glm::vec3(0), 0});
    scene.materials.push_back({"nearest", glm::vec3(0.9f, 0.8f, 0.7f), glm::vec3(0), 1});
    Random random(5);
    for (int t = 0; t < 2; ++t) {
        Image<std::uint32_t> texels(t ? 5 : 16, t ? 3 : 8);
        for (std::uint32_t& x : texels.texels) x = random.next();
        scene.textures.push_back({"noise", texels, t == 0, t ? Filter::nearest : Filter::bilinear});
    }
    return scene;
}

View soup_view() {
    Camera camera;
    camera.position = {0, 0, 1};
    camera.look_at = {0.2, 0.1, -1};
    camera.fov_y_deg = 70;
    return make_view(camera, 211.0 / 133);
}

}  // namespace

// Snapping moves each corner by at most 1/512 pixel along x and y, and window-space interpolation is affine in 1/w and
// in attributes over w: what is drawn at a pixel's centre is exact for a point within 1/512 pixel of it. The extremes
// over that box are taken at its corners (the intersection is a projective map, monotone along both axes).
TEST_CASE("gbuffer: depth and position are the analytic intersection with a plane", "[raster][gbuffer][analytic]") {
    const glm::ivec2 size{160, 100};
    Camera camera;
    camera.position = {3, 1.5, 2};
    camera.look_at = {3.3, 1.2, 0};
    camera.near = 0.05, camera.far = 1000;
    camera.fov_y_deg = 75;
    for (float reach : {30.0f, 3e4f})
        for (bool reversed : {false, true}) {
            camera.reversed_z = reversed;
            const View view = make_view(camera, 1.6);
            // The ground y = 0: at 30 m its corners are clipped by the near plane, at 30 km by the guard band too.
            const glm::vec3 up(0, 1, 0);
            const Vertex a = at({-reach, 0, -reach}, up), b = at({reach, 0, -reach}, up);
            const Vertex c = at({reach, 0, reach}, up), d = at({-reach, 0, reach}, up);
            Geometry g;
            add_triangle(g, a, b, c);
            add_triangle(g, a, c, d);
            const GBuffer out = draw(plain_scene(), g, view, size);
            int checked = 0;
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    if (out.id(x, y).y < 0) continue;
                    glm::dvec3 low(1e30), high(-1e30);
                    double near_z = 1e30, far_z = -1e30;
                    for (int k = 0; k < 4; ++k) {
                        const glm::dvec2 p(x + 0.5 + (k & 1 ? 1 : -1) / 512.0, y + 0.5 + (k & 2 ? 1 : -1) / 512.0);
                        const Ray ray = ray_through(camera, size, p);
                        const glm::dvec3 hit = ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
                        low = glm::min(low, hit), high = glm::max(high, hit);
                        const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(hit, 1);
                        near_z = std::min(near_z, clip.z / clip.w), far_z = std::max(far_z, clip.z / clip.w);
                    }
                    // Clip positions, barycentrics and edges are rounded to float: 4 eps of the triangle's extent.
                    const double eps = 4 * 0x1p-24 * 2 * reach;
                    const glm::vec4 got = out.position(x, y);
                    CAPTURE(reach, reversed, x, y, got.x, got.z, low.x, high.x);
                    if (low.x < -reach || high.x > reach || low.z < -reach || high.z > reach) continue;
                    REQUIRE((got.x >= low.x - eps && got.x <= high.x + eps));
                    REQUIRE((got.z >= low.z - eps && got.z <= high.z + eps));
                    REQUIRE(got.y == 0);
                    REQUIRE(std::abs(got.w - linear_depth(camera, glm::dvec3(got))) <= 4 * 0x1p-24 * (reach + 5));
                    // A clip position's rounding, 2^-24 of its size, reaches depth divided by the pixel's own w.
                    const double z_eps = 0x1p-23 + 2 * 0x1p-24 * reach / got.w;
                    CAPTURE(out.depth(x, y), near_z, far_z);
                    REQUIRE((out.depth(x, y) >= near_z - z_eps && out.depth(x, y) <= far_z + z_eps));
                    REQUIRE(out.normal(x, y) == glm::vec4(0, 1, 0, 1));
                    ++checked;
                }
            REQUIRE(checked > 5000);
        }
}

TEST_CASE("gbuffer: barycentrics of small triangles are exact where the frame is their grid", "[raster][gbuffer]") {
    // 4 x 4 pixels, the quad's corners are the frame's: l1, l2 are multiples of 1/8.
    const Geometry g = frame_quad();
    const VisibilityBuffer v = draw_visibility(g, clip_space_view(), {4, 4}, {});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            const float s = (float(x) + 0.5f) / 4, t = (float(y) + 0.5f) / 4;
            // The diagonal is a left edge of the upper triangle, whose inside lies to its right.
            const bool upper = v.triangle(x, y) == 0;
            REQUIRE(upper == (x >= y));
            const glm::vec2 l = upper ? glm::vec2(s - t, t) : glm::vec2(s, t - s);
            REQUIRE(v.barycentrics(x, y) == l);
        }
}

TEST_CASE("gbuffer: reversed z and an infinite far plane show the same triangles", "[raster][gbuffer][depth]") {
    // Triangles across the view at 300 different depths, so that no float depth is in doubt.
    Random random(11);
    Geometry g;
    for (int i = 0; i < 300; ++i) {
        const float z = -float(0.2 + 0.15 * ((i * 97) % 300));
        auto corner = [&] { return at({float(random.between(-1, 1)) * -z, float(random.between(-1, 1)) * -z, z}); };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(g, a, b, c);
    }
    Camera camera;
    camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1};
    camera.fov_y_deg = 60;
    std::vector<VisibilityBuffer> drawn;
    for (double far : {100.0, double(INFINITY)})
        for (bool reversed : {false, true}) {
            camera.far = far, camera.reversed_z = reversed;
            drawn.push_back(draw_visibility(g, make_view(camera, 1), {200, 200}, {}));
        }
    for (const VisibilityBuffer& v : drawn) {
        REQUIRE(v.triangle.texels == drawn[0].triangle.texels);
        REQUIRE(v.barycentrics.texels == drawn[0].barycentrics.texels);
    }
    REQUIRE(std::count(drawn[0].triangle.texels.begin(), drawn[0].triangle.texels.end(), -1) < 20000);
}

TEST_CASE("gbuffer: the normal is on the side that is seen, whatever the winding and the vertices say",
          "[raster][gbuffer]") {
    Camera camera;
    camera.position = {0, 0, 3}, camera.look_at = {0, 0, 0};
    for (bool turned : {false, true})
        for (float given : {-1.0f, 0.0f, 1.0f}) {
            const Vertex a = at({-1, -1, 0}, {0, 0, given}), b = at({1, -1, 0}, {0, 0, given}),
                         c = at({0, 1, 0}, {0, 0, given});
            Geometry g;
            add_triangle(g, a, turned ? c : b, turned ? b : c);
            CAPTURE(turned, given);
            CHECK(draw(plain_scene(), g, make_view(camera, 1), {9, 9}).normal(4, 4) == glm::vec4(0, 0, 1, 1));
        }
    // A curved surface's normal that bends away from the viewer, on a face that is seen, is kept.
    Geometry g;
    const glm::vec3 n(0.8f, 0, -0.6f);
    add_triangle(g, at({-1, -1, 0}, n), at({1, -1, 0}, n), at({0, 1, 0.9f}, n));
    const glm::vec4 got = draw(plain_scene(), g, make_view(camera, 1), {9, 9}).normal(4, 4);
    CHECK(got.z == Approx(0.6f));
}

// By the face: a smooth surface's normals stay smooth over its silhouette. The normal (-0.8, 0, 0.6) of a face towards
// +z is kept as seen from (5, 0, 1), from where the normal itself points away, and turned as seen from below the face.
TEST_CASE("gbuffer: the face decides the side of the normal, not the normal's own direction", "[raster][gbuffer]") {
    const glm::vec3 n(-0.8f, 0, 0.6f);
    Geometry g;
    add_triangle(g, at({-1, -1, 0}, n), at({1, -1, 0}, n), at({0, 2, 0}, n));
    for (float side : {1.0f, -1.0f}) {
        Camera camera;
        camera.position = {5, 0, side}, camera.look_at = {0, 0, 0};
        const glm::vec4 got = draw(plain_scene(), g, make_view(camera, 1), {33, 33}).normal(16, 16);
        CAPTURE(side);
        CHECK(got.x == Approx(-0.8f * side));
        CHECK(got.z == Approx(0.6f * side));
    }
}

TEST_CASE("gbuffer: materials, ids and background", "[raster][gbuffer]") {
    Geometry g;
    add_triangle(g, at({-1, -1, 0.5f}), at({1, -1, 0.5f}), at({-1, 1, 0.5f}), 0, 4);
    const GBuffer out = draw(plain_scene(), g, clip_space_view(), {8, 8});
    CHECK(out.albedo(1, 1) == glm::vec4(0.25f, 0.5f, 0.75f, 0));
    CHECK(out.emission(1, 1) == glm::vec4(1, 2, 3, 0));
    CHECK(out.id(1, 1) == glm::ivec2(4, 0));
    CHECK(out.depth(1, 1) == 0.5f);
    CHECK(out.position(1, 1).w == 0.5f);
    for (const Image4* image : {&out.position, &out.normal, &out.albedo, &out.emission})
        CHECK((*image)(7, 7) == glm::vec4(0));
    CHECK(out.id(7, 7) == glm::ivec2(-1));
    CHECK(out.depth(7, 7) == 1.0f);
}

// For t = table[c], x = (c / 255 + 0.055) / 1.055: t is the float nearest to x^2.4 when x^12 lies between the fifth
// powers of the midpoints to t's neighbours. Those carry 64 bits here; the closest case is farther away than that.
TEST_CASE("texture: the sRGB table is IEC 61966-2-1, rounded to nearest", "[raster][texture]") {
    const Buffer<float> table = decode_table();
    CHECK(table[256] == 0.0f);
    CHECK(table[256 + 255] == 1.0f);
    for (int c = 0; c < 256; ++c) CHECK(table[std::size_t(c)] == float(c) / 255.0f);
    for (int c = 0; c <= 10; ++c) CHECK(table[std::size_t(256 + c)] == float((long double)(c) / 255 / 12.92L));
    for (int c = 11; c < 255; ++c) {
        const long double x = ((long double)(c) / 255 + 0.055L) / 1.055L;
        const float t = table[std::size_t(256 + c)];
        auto fifth = [](long double v) { return v * v * v * v * v; };
        const long double x12 = x * x * x * x * x * x * x * x * x * x * x * x;
        const long double below = ((long double)(t) + std::nextafterf(t, 0)) / 2;
        const long double above = ((long double)(t) + std::nextafterf(t, 2)) / 2;
        CAPTURE(c);
        REQUIRE((fifth(below) * (1 + 1e-17L) < x12 && x12 < fifth(above) * (1 - 1e-17L)));
    }
}

TEST_CASE("texture: a pixel on a texel's centre gets the texel", "[raster][texture]") {
    Image<std::uint32_t> texels(8, 4);
    for (int i = 0; i < 32; ++i) texels.texels[std::size_t(i)] = std::uint32_t(i * 8) | (255u - i) << 8 | 17u << 16;
    const Buffer<float> decode = decode_table();
    for (Filter filter : {Filter::bilinear, Filter::nearest})
        for (bool srgb : {false, true})
            for (float shift : {0.0f, 3.0f, -2.0f}) {
                const GBuffer out =
                    draw(textured(texels, filter, srgb), frame_quad(1, 1, shift, -shift), clip_space_view(), {8, 4});
                for (int i = 0; i < 32; ++i) {
                    auto value = [&](int byte) { return decode[std::size_t(byte + (srgb ? 256 : 0))]; };
                    CAPTURE(i, srgb, shift);
                    REQUIRE(out.albedo(i % 8, i / 8) == glm::vec4(value(i * 8), value(255 - i), value(17), 0));
                }
            }
}

TEST_CASE("texture: between two texels lies the mean of their linear values; the border repeats", "[raster][texture]") {
    Image<std::uint32_t> texels(2, 1);
    texels.texels = {0xff00ffc8u, 0xffff0064u};  // red 200, 100; green 255, 0; blue 0, 255
    const Buffer<float> t = decode_table();
    const glm::vec4 mean(t[356 + 100] + 0.5f * (t[356] - t[356 + 100]), 0.5f, 0.5f, 0);
    const Scene bilinear = textured(texels, Filter::bilinear, true), nearest = textured(texels, Filter::nearest, true);
    // One pixel: u = 1/2 lies between the two.
    CHECK(draw(bilinear, frame_quad(), clip_space_view(), {1, 1}).albedo(0, 0) == mean);
    // u = 0 lies between the last texel and the first: the sum runs from the right one.
    const glm::vec4 wrapped(t[356] + 0.5f * (t[356 + 100] - t[356]), 0.5f, 0.5f, 0);
    CHECK(draw(bilinear, frame_quad(1, 1, -0.5f), clip_space_view(), {1, 1}).albedo(0, 0) == wrapped);
    // Nearest takes the texel in which u lies: 1/2 begins the second one.
    CHECK(draw(nearest, frame_quad(), clip_space_view(), {1, 1}).albedo(0, 0) == glm::vec4(t[356], 0, 1, 0));
    // Two pixels across three periods and a half stay inside the image.
    CHECK(draw(nearest, frame_quad(3.5f), clip_space_view(), {2, 1}).albedo(0, 0).x == t[356]);
}

TEST_CASE("texture: faulty indices and empty images are refused by name", "[raster][texture]") {
    const Geometry g = frame_quad();
    Scene scene = textured(Image<std::uint32_t>(1, 1), Filter::nearest, false);
    scene.materials[0].texture = 1;
    CHECK_THROWS_WITH(prepare(scene, g), Catch::Contains("grey"));
    scene = textured(Image<std::uint32_t>(), Filter::nearest, false);
    CHECK_THROWS_WITH(prepare(scene, g), Catch::Contains("\"texture\""));
    Geometry wrong = frame_quad();
    wrong.material[1] = 1;
    CHECK_THROWS_WITH(prepare(plain_scene(), wrong), Catch::Contains("triangle 1"));
}

TEST_CASE("gbuffer: the same bits for every instruction set and 1, 2, 3 threads", "[raster][gbuffer][bits]") {
    const Geometry g = soup(3000, 1);
    const Scene scene = soup_scene();
    // Tiles and blocks that the frame cuts; so many pixels, in whole registers, that they are written past the caches.
    const glm::ivec2 size = GENERATE(glm::ivec2(211, 133), glm::ivec2(520, 505));
    RunOptions options;
    options.isa = Isa::scalar, options.threads = 1;
    const GBuffer truth = draw(scene, g, soup_view(), size, options);
    REQUIRE(std::count(truth.id.texels.begin(), truth.id.texels.end(), glm::ivec2(-1)) < size.x * size.y * 3 / 4);
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            options.isa = isa, options.threads = threads;
            const GBuffer out = draw(scene, g, soup_view(), size, options);
            CAPTURE(isa_name(isa), threads, size.x);
            CHECK(same(out.position, truth.position));
            CHECK(same(out.normal, truth.normal));
            CHECK(same(out.albedo, truth.albedo));
            CHECK(same(out.emission, truth.emission));
            CHECK(out.id.texels == truth.id.texels);
            CHECK(std::memcmp(out.depth.data(), truth.depth.data(), 4 * out.depth.size()) == 0);
        }
}

// Strips one pixel wide: plain ones with texture coordinates that overflow, textured ones with tame or such ones.
TEST_CASE("gbuffer: wild texture coordinates give the same bits alone and beside others", "[raster][gbuffer][bits]") {
    const glm::ivec2 size{47, 3};
    const Scene scene = soup_scene();
    Geometry g;
    for (int i = 0; i < size.x; ++i) {
        const int material = i % 5 == 4 ? 1 + i % 2 : i % 3;
        const float wild = material == 0 || i % 5 == 4 ? 3e38f : 0.75f;
        const float left = 2 * float(i) / float(size.x) - 1, right = 2 * float(i + 1) / float(size.x) - 1;
        const glm::vec3 n(0, 0, -1);
        const Vertex a = at({left, -1, 0.5f}, n, -wild, wild), b = at({right, -1, 0.5f}, n, wild, wild);
        const Vertex c = at({right, 1, 0.5f}, n, wild, -wild), d = at({left, 1, 0.5f}, n, -wild, -wild);
        add_triangle(g, a, b, c, material);
        add_triangle(g, a, c, d, material);
    }
    RunOptions options;
    options.threads = 1;
    options.isa = Isa::scalar;
    const GBuffer truth = draw(scene, g, clip_space_view(), size, options);
    int plain = 0, wild = 0;
    for (std::size_t i = 0; i < truth.albedo.size(); ++i) {
        const glm::vec4 albedo = truth.albedo.texels[i];
        if (g.material[std::size_t(truth.id.texels[i].y)] != 0) {
            REQUIRE(albedo.x - albedo.x == 0);  // some texel, never NaN
            wild += truth.id.texels[i].y / 2 % 5 == 4;
            continue;
        }
        REQUIRE(albedo == glm::vec4(0.25f, 0.5f, 0.75f, 0));
        ++plain;
    }
    REQUIRE(plain > 30);
    REQUIRE(wild > 10);
    for (Isa isa : supported_isas()) {
        options.isa = isa;
        CAPTURE(isa_name(isa));
        CHECK(same(draw(scene, g, clip_space_view(), size, options).albedo, truth.albedo));
    }
}

TEST_CASE("gbuffer: rgba16f is the fp32 result, rounded", "[raster][gbuffer]") {
    const Geometry g = soup(300, 2);
    const GBuffer exact = draw(soup_scene(), g, soup_view(), {64, 48});
    const GBuffer half = draw(soup_scene(), g, soup_view(), {64, 48}, {}, Layout::rgba16f);
    for (auto image : {&GBuffer::position, &GBuffer::normal, &GBuffer::albedo, &GBuffer::emission}) {
        Image4 rounded = exact.*image;
        for (glm::vec4& v : rounded.texels)
            for (int c = 0; c < 4; ++c) v[c] = half_to_float(float_to_half(v[c]));
        CHECK(same(rounded, half.*image));
        CHECK(!same(exact.*image, half.*image));
    }
    CHECK(std::memcmp(exact.depth.data(), half.depth.data(), 4 * exact.depth.size()) == 0);
}

TEST_CASE("gbuffer: explain names the values of the picture", "[raster][gbuffer][explain]") {
    const Geometry g = soup(300, 2);
    const Scene scene = soup_scene();
    const glm::ivec2 size{64, 48};
    const Surfaces surfaces = prepare(scene, g);
    const GBuffer out = draw(scene, g, soup_view(), size);
    auto value = [](const std::vector<TapValue>& taps, const std::string& name) {
        for (const TapValue& t : taps)
            if (t.name == name) return t.value;
        return std::vector<double>();
    };
    int textured_pixels = 0;
    for (int y = 0; y < size.y; y += 5)
        for (int x = 0; x < size.x; x += 5) {
            const auto taps = explain_gbuffer(g, surfaces, soup_view(), size, {x, y});
            for (const TapValue& t : taps) {
                CAPTURE(t.name);
                CHECK(!t.equation.empty());
            }
            REQUIRE(value(taps, "triangle") == std::vector<double>{double(out.id(x, y).y)});
            if (out.id(x, y).y < 0) continue;
            const glm::vec4 p = out.position(x, y), a = out.albedo(x, y);
            CHECK(value(taps, "position") == std::vector<double>{p.x, p.y, p.z});
            CHECK(value(taps, "depth") == std::vector<double>{p.w});
            CHECK(value(taps, "albedo") == std::vector<double>{a.x, a.y, a.z});
            textured_pixels += !value(taps, "uv").empty();
        }
    CHECK(textured_pixels > 10);
}
