// The rasterizer of a device's profile, without a device: values by hand, numbers that lavapipe gave, and what holds
// for any rasterizer. tests/parity holds it against the driver itself.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "drawing.h"
#include "raster/device_raster.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

DeviceProfile planes(bool fused, int subpixel_bits = 8) {
    DeviceProfile p;
    p.interpolation = Interpolation::plane_equation;
    p.fused_raster = fused;
    p.subpixel_bits = subpixel_bits;
    return p;
}

// SwiftShader's.
DeviceProfile snapped_planes() {
    DeviceProfile p = planes(false, 4);
    p.interpolation = Interpolation::snapped_planes;
    return p;
}

struct Soup {
    Geometry geometry;
    Buffer<glm::vec4> clip;

    void add(const glm::vec4& a, const glm::vec4& b, const glm::vec4& c, int material = 0) {
        add_triangle(geometry, at(glm::vec3(a)), at(glm::vec3(b)), at(glm::vec3(c)), material);
        clip.insert(clip.end(), {a, b, c});
    }
    VisibilityBuffer draw(glm::ivec2 size, const DeviceProfile& profile, bool reversed = false,
                          const Surfaces* surfaces = nullptr, int threads = 1) const {
        RunOptions options;
        options.threads = threads;
        VisibilityBuffer out;
        draw_device_visibility(geometry, surfaces, clip, reversed, size, profile, options, out);
        return out;
    }
};

// A window position in a frame whose sides are powers of two: no arithmetic from here to the grid rounds.
glm::vec4 window(glm::ivec2 size, double x, double y, double z) {
    return {float(2 * x / size.x - 1), float(2 * y / size.y - 1), float(z), 1};
}

template <class T>
bool same(const Image<T>& a, const Image<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}
bool same(const VisibilityBuffer& a, const VisibilityBuffer& b) {
    return same(a.triangle, b.triangle) && same(a.depth, b.depth) && same(a.barycentrics, b.barycentrics);
}

// A left edge on a centre covers it. In units of the grid, 1/256 or 1/16 pixel, from the centre of pixel 10: -0.5 ties to
// 0, 0.5 to 0, 1.5 to 2, -1.5 to -2; 0.5 + 2^-6 is beyond the tie.
TEST_CASE("device raster: corners snap to the grid's nearest place, ties to even", "[raster][device]") {
    constexpr glm::ivec2 size{64, 64};
    for (int bits : {8, 4}) {
        const double grid = double(1 << bits);
        const std::pair<double, bool> places[] = {{-1.5, true}, {-0.5, true}, {0, true},     {0.5, true},
                                                  {0.515625, false}, {1.5, false}, {1, false}};
        for (const auto& [place, covered] : places) {
            Soup soup;
            const double x = 10.5 + place / grid;
            soup.add(window(size, x, 4, 0.5), window(size, 40, 4, 0.5), window(size, x, 40, 0.5));
            CAPTURE(bits, place);
            CHECK((soup.draw(size, planes(true, bits)).triangle(10, 20) == 0) == covered);
            CHECK(soup.draw(size, planes(true, bits)).triangle(11, 20) == 0);
        }
    }
}

// Without rounding before the edge functions, coverage is exact either way, and so is a depth that is one number.
TEST_CASE("device raster: sees what exact arithmetic sees where positions are exact", "[raster][device]") {
    constexpr glm::ivec2 size{256, 128};
    Random random(1);
    for (bool reversed : {false, true}) {
        Soup soup;
        for (int i = 0; i < 1000; ++i) {
            const int extent = 256 * (1 + random.below(60)), x = random.below(256 * (256 - 61)), y = random.below(256 * 67);
            const double z = random.below(64) / 64.0;  // ties in depth: the first in order wins
            auto corner = [&] { return window(size, (x + random.below(extent)) / 256.0, (y + random.below(extent)) / 256.0, z); };
            const glm::vec4 a = corner(), b = corner(), c = corner();
            soup.add(a, b, c);
        }
        VisibilityBuffer exact;
        draw_visibility(soup.geometry, nullptr, soup.clip, reversed, size, {}, exact);
        for (bool fused : {false, true}) {
            const VisibilityBuffer out = soup.draw(size, planes(fused), reversed);
            CHECK(same(out.triangle, exact.triangle));
            CHECK(same(out.depth, exact.depth));
            float farthest = 0;
            for (std::size_t i = 0; i < out.barycentrics.size(); ++i)
                for (int k : {0, 1})
                    farthest = std::max(farthest, std::abs(out.barycentrics.texels[i][k] - exact.barycentrics.texels[i][k]));
            CHECK(farthest < 2e-3f);  // planes are taken to the frame's corner and back: raster/README.md, "Devices"
        }
        CHECK(std::count(exact.triangle.texels.begin(), exact.triangle.texels.end(), -1) < size.x * size.y / 2);
    }
}

// Triangles of a bent grid, w different at every corner, that hangs over every side of the frame: each drawn alone.
TEST_CASE("device raster: a mesh covers every pixel once", "[raster][device]") {
    constexpr glm::ivec2 size{50, 37};
    constexpr int cells = 9;
    Random random(2);
    std::vector<glm::vec4> grid;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            const double w = random.between(0.5, 4);
            const double x = 2.6 * (i + random.between(-0.3, 0.3)) / cells - 1.3;
            const double y = 2.6 * (j + random.between(-0.3, 0.3)) / cells - 1.3;
            grid.push_back({float(x * w), float(y * w), float(0.5 * w), float(w)});
        }
    for (const DeviceProfile& profile : {planes(false), planes(true), snapped_planes()}) {
        Image<int> count(size.x, size.y, 0);
        auto draw_alone = [&](int a, int b, int c) {
            Soup soup;
            soup.add(grid[std::size_t(a)], grid[std::size_t(b)], grid[std::size_t(c)]);
            const VisibilityBuffer out = soup.draw(size, profile);
            for (std::size_t i = 0; i < count.size(); ++i) count.texels[i] += out.triangle.texels[i] == 0;
        };
        for (int j = 0; j < cells; ++j)
            for (int i = 0; i < cells; ++i) {
                const int at = j * (cells + 1) + i;
                draw_alone(at, at + 1, at + cells + 1);
                draw_alone(at + 1, at + cells + 1, at + cells + 2);
            }
        CHECK(std::count(count.texels.begin(), count.texels.end(), 1) == size.x * size.y);
    }
}

// Expected: what lavapipe of Mesa 22.3.6 gave with and without fma (GALLIUM_OVERRIDE_CPU_CAPS=sse4.1), and SwiftShader,
// which snaps to 1/16 pixel. The second
// triangle's first corner is behind the near plane and beyond two sides.
TEST_CASE("device raster: numbers that lavapipe and SwiftShader gave", "[raster][device]") {
    const glm::vec4 b{1.9f, -0.2f, 1.3f, 2.3f}, c{-0.1f, 0.6f, 0.4f, 0.7f};
    Soup whole, clipped;
    whole.add({-0.7f, -0.9f, 0.3f, 1.1f}, b, c);
    clipped.add({-0.7f, -0.9f, -0.3f, 0.1f}, b, c);
    constexpr glm::ivec2 small{100, 75}, large{1000, 562};
    const DeviceProfile fma = planes(true), no_fma = planes(false), snapped = snapped_planes();
    struct Expected {
        const Soup& soup;
        glm::ivec2 size;
        const DeviceProfile& profile;
        int x, y;
        float depth, l1, l2;
    };
    const Expected expected[] = {
        {whole, small, fma, 40, 30, 0x1.ad3a08p-2f, 0x1.83d986p-4f, 0x1.b435e4p-2f},
        {whole, small, fma, 47, 59, 0x1.175d42p-1f, 0x1.8af166p-5f, 0x1.c82c8p-1f},
        {whole, small, fma, 64, 33, 0x1.f897d4p-2f, 0x1.601a02p-2f, 0x1.5de498p-2f},
        {whole, small, no_fma, 40, 30, 0x1.ad3a08p-2f, 0x1.83d986p-4f, 0x1.b435e6p-2f},
        {whole, small, no_fma, 47, 59, 0x1.175d42p-1f, 0x1.8af15ep-5f, 0x1.c82c7ep-1f},
        {whole, small, no_fma, 64, 33, 0x1.f897d4p-2f, 0x1.601a04p-2f, 0x1.5de498p-2f},
        {whole, large, fma, 400, 225, 0x1.aa7966p-2f, 0x1.7b3d02p-4f, 0x1.ad7aaap-2f},
        {whole, large, fma, 470, 442, 0x1.15e8eap-1f, 0x1.7e93b4p-5f, 0x1.c558fap-1f},
        {whole, large, fma, 640, 247, 0x1.f5988p-2f, 0x1.5def56p-2f, 0x1.52f98cp-2f},
        {whole, large, no_fma, 400, 225, 0x1.aa7966p-2f, 0x1.7b3d06p-4f, 0x1.ad7aa6p-2f},
        {whole, large, no_fma, 470, 442, 0x1.15e8e8p-1f, 0x1.7e93b8p-5f, 0x1.c558f4p-1f},
        {whole, large, no_fma, 640, 247, 0x1.f5988p-2f, 0x1.5def58p-2f, 0x1.52f98cp-2f},
        {clipped, small, fma, 40, 30, 0x1.55830cp-2f, 0x1.d742dep-4f, 0x1.deaep-2f},
        {clipped, small, fma, 47, 59, 0x1.101ebcp-1f, 0x1.c8068cp-5f, 0x1.ba3926p-1f},
        {clipped, small, fma, 64, 33, 0x1.ccf672p-2f, 0x1.23ee32p-2f, 0x1.97d024p-2f},
        {clipped, small, fma, 70, 20, 0x1.98bf22p-2f, 0x1.adb6d6p-2f, 0x1.492496p-4f},
        {clipped, small, no_fma, 40, 30, 0x1.55830cp-2f, 0x1.d742dep-4f, 0x1.deaep-2f},
        {clipped, small, no_fma, 47, 59, 0x1.101ebcp-1f, 0x1.c8068cp-5f, 0x1.ba3924p-1f},
        {clipped, small, no_fma, 64, 33, 0x1.ccf672p-2f, 0x1.23ee32p-2f, 0x1.97d022p-2f},
        {clipped, small, no_fma, 70, 20, 0x1.98bf22p-2f, 0x1.adb6d6p-2f, 0x1.492494p-4f},
        {whole, small, snapped, 40, 30, 0x1.ad3908p-2f, 0x1.836bd6p-4f, 0x1.b464e8p-2f},
        {whole, small, snapped, 47, 59, 0x1.175e46p-1f, 0x1.89e51ap-5f, 0x1.c84138p-1f},
        {whole, small, snapped, 64, 33, 0x1.f88fdcp-2f, 0x1.5ffa5cp-2f, 0x1.5deb46p-2f},
        {clipped, small, snapped, 40, 30, 0x1.557c8cp-2f, 0x1.d6f1ecp-4f, 0x1.dec8d6p-2f},
        {clipped, small, snapped, 47, 59, 0x1.101fcap-1f, 0x1.c703c6p-5f, 0x1.ba4d7ap-1f},
        {clipped, small, snapped, 64, 33, 0x1.cce78p-2f, 0x1.23d0e8p-2f, 0x1.97d81p-2f},
    };
    for (const Expected& e : expected) {
        const VisibilityBuffer out = e.soup.draw(e.size, e.profile);
        CAPTURE(&e - expected, e.x, e.y);
        CHECK(out.triangle(e.x, e.y) == 0);
        CHECK(out.depth(e.x, e.y) == e.depth);
        CHECK(out.barycentrics(e.x, e.y).x == e.l1);
        CHECK(out.barycentrics(e.x, e.y).y == e.l2);
    }
    CHECK(whole.draw(small, planes(true)).triangle(70, 20) == -1);
}

// A float below 2^-126 is a denormal; every one is 0 on the device, so the second triangle is not nearer.
TEST_CASE("device raster: a denormal depth is 0", "[raster][device]") {
    constexpr glm::ivec2 size{16, 16};
    Soup soup;
    for (float z : {0x1p-127f, 0x1p-130f}) soup.add({-1, -1, z, 1}, {3, -1, z, 1}, {-1, 3, z, 1});
    const VisibilityBuffer out = soup.draw(size, planes(true));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            CHECK(out.triangle(x, y) == 0);
            CHECK(out.depth(x, y) == 0.0f);
            CHECK(!std::signbit(out.depth(x, y)));
        }
    CHECK(0x1p-127f / 2 > 0);  // outside denormals are kept
}

// Depth on the triangle's near edge, by its plane: -0x1.04p-24 and, without fma, -0x1.5p-24; lavapipe's buffer has 0.
TEST_CASE("device raster: a depth below 0 is 0", "[raster][device]") {
    Soup soup;
    soup.add({-0.4f, 0, 0, 1}, {-0.3f, -0.8f, 0, 1}, {0, -0.5f, 0.4f, 1});
    for (bool fused : {false, true}) {
        const VisibilityBuffer out = soup.draw({100, 75}, planes(fused));
        CHECK(out.triangle(34, 10) == 0);
        CHECK(out.depth(34, 10) == 0.0f);
    }
}

// The corners lie on a line, so that the planes divide by 0; snapped, they do not. lavapipe: depth 1, which a reversed
// test takes to be near, l1 and l2 NaN.
TEST_CASE("device raster: without area before snapping, depth is 1 and l1, l2 are NaN", "[raster][device]") {
    constexpr glm::ivec2 size{64, 64};
    Soup soup;
    auto on_line = [&](int i) { return window(size, (149425 - i * 38649) / 4096.0, (139623 - i * 21247) / 4096.0, 0.5); };
    soup.add(on_line(0), on_line(1), on_line(2));
    for (bool fused : {false, true}) {
        const VisibilityBuffer out = soup.draw(size, planes(fused), true);
        CHECK(out.triangle(24, 27) == 0);
        CHECK(out.depth(24, 27) == 1.0f);
        CHECK(std::isnan(out.barycentrics(24, 27).x));
        CHECK(std::isnan(out.barycentrics(24, 27).y));
        CHECK(soup.draw(size, planes(fused)).triangle(24, 27) == -1);
    }
}

// The near quad's texture has alpha 0 in its left half and 1 in its right; cutoff 0.5.
TEST_CASE("device raster: what an alpha mask cuts away lets the next triangle be seen", "[raster][device]") {
    Scene scene;
    Texture holes{"holes", Image<std::uint32_t>(2, 1), false, Filter::nearest};
    holes.texels(0, 0) = 0x00ffffff, holes.texels(1, 0) = 0xffffffff;
    scene.textures.push_back(holes);
    scene.materials.resize(2);
    scene.materials[1].texture = 0;
    scene.materials[1].alpha_cutoff = 0.5f;
    Soup soup;
    soup.add({-1, -1, 0.25f, 1}, {1, -1, 0.25f, 1}, {-1, 1, 0.25f, 1}, 1);
    for (int i : {0, 1, 2}) soup.geometry.vertices[std::size_t(i)].u = i == 1 ? 1.0f : 0.0f;
    soup.add({-1, -1, 0.5f, 1}, {3, -1, 0.5f, 1}, {-1, 3, 0.5f, 1}, 0);
    const Surfaces surfaces = prepare(scene, soup.geometry);
    const VisibilityBuffer out = soup.draw({16, 16}, planes(true), false, &surfaces);
    for (int x = 0; x < 16; ++x) {
        CAPTURE(x);
        CHECK(out.triangle(x, 0) == (x < 8 || x == 15 ? 1 : 0));  // (15, 0) lies on the diagonal, no left edge
        CHECK(out.depth(x, 0) == (x < 8 || x == 15 ? 0.5f : 0.25f));
    }
}

TEST_CASE("device raster: threads move no bit; the ideal profile is draw_visibility()", "[raster][device][bits]") {
    constexpr glm::ivec2 size{130, 97};
    Random random(3);
    Soup soup;
    for (int i = 0; i < 9000; ++i) {
        glm::vec4 corners[3];
        for (glm::vec4& c : corners) {
            const double w = random.between(-0.2, 2);
            c = {float(random.between(-1.5, 1.5)), float(random.between(-1.5, 1.5)), float(random.between(-0.1, w + 0.2)),
                 float(w)};
        }
        soup.add(corners[0], corners[1], corners[2]);
    }
    for (const DeviceProfile& profile : {planes(false), planes(true), snapped_planes()})
        for (bool reversed : {false, true}) {
            const VisibilityBuffer one = soup.draw(size, profile, reversed);
            for (int threads : {2, 3}) CHECK(same(soup.draw(size, profile, reversed, nullptr, threads), one));
        }
    VisibilityBuffer exact;
    draw_visibility(soup.geometry, nullptr, soup.clip, false, size, {}, exact);
    CHECK(same(soup.draw(size, DeviceProfile()), exact));
}

TEST_CASE("device raster: names the vertex that is not finite", "[raster][device]") {
    Soup soup;
    soup.add({0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, __builtin_inff()});
    CHECK_THROWS_WITH(soup.draw({8, 8}, planes(true)), Catch::Contains("vertex 2"));
    CHECK_THROWS_AS(soup.draw({0, 8}, planes(true)), InputError);
}

}  // namespace
