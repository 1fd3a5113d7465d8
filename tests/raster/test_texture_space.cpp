#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "raster/texture_space.h"
#include "tests/raster/drawing.h"

namespace plumb::raster {
namespace {

using test::add_triangle;
using test::at;

// A rectangle in space whose chart is [low, high] of the unit square; corners counter-clockwise from its front.
void add_chart(Geometry& g, const glm::vec3 corners[4], glm::vec2 low, glm::vec2 high, int material, int object) {
    const glm::vec2 uv[4] = {low, {high.x, low.y}, high, {low.x, high.y}};
    for (const auto& t : {glm::ivec3(0, 1, 2), glm::ivec3(0, 2, 3)})
        add_triangle(g, at(corners[t.x], {}, uv[t.x].x, uv[t.x].y), at(corners[t.y], {}, uv[t.y].x, uv[t.y].y),
                     at(corners[t.z], {}, uv[t.z].x, uv[t.z].y), material, object);
}

Scene materials(int count) {
    Scene scene;
    for (int i = 0; i < count; ++i) {
        Material m;
        m.reflectance = glm::vec3(0.25f * float(i + 1));
        m.emission = glm::vec3(float(i));
        scene.materials.push_back(m);
    }
    return scene;
}

TextureSpace draw(const Geometry& g, glm::ivec2 size, int count = 2, RunOptions options = {}) {
    TextureSpace out;
    draw_texture_space(g, prepare(materials(count), g), texture_coordinates(g), size, options, out);
    return out;
}

// A floor seen from above, and a wall whose chart runs the other way round: both fronts are kept.
Geometry room() {
    Geometry g;
    const glm::vec3 floor[4] = {{0, 0, 2}, {2, 0, 2}, {2, 0, 0}, {0, 0, 0}};
    const glm::vec3 wall[4] = {{2, 0, 0}, {0, 0, 0}, {0, 1, 0}, {2, 1, 0}};  // its front looks along -z
    add_chart(g, floor, {0, 0}, {0.5f, 1}, 0, 3);
    add_chart(g, wall, {0.5f, 0.25f}, {1, 0.75f}, 1, 4);
    return g;
}

}  // namespace

TEST_CASE("texture space: a texel holds the point of its centre", "[raster][IPR 3.2.1.2]") {
    const TextureSpace t = draw(room(), {32, 32});
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            INFO(x << ", " << y);
            const float u = (float(x) + 0.5f) / 32, v = (float(y) + 0.5f) / 32;
            if (x < 16) {
                CHECK(t.id(x, y) == glm::ivec3(3, t.id(x, y).y, 0));
                CHECK(t.position(x, y).x == Approx(2 * (u / 0.5f)).margin(1e-6));
                CHECK(t.position(x, y).y == 0);
                CHECK(t.position(x, y).z == Approx(2 - 2 * v).margin(1e-6));
                CHECK(t.normal(x, y) == glm::vec4(0, 1, 0, 1));
                CHECK(t.albedo(x, y).x == 0.25f);
            } else if (y >= 8 && y < 24) {
                CHECK(t.id(x, y) == glm::ivec3(4, t.id(x, y).y, 1));
                CHECK(t.position(x, y).x == Approx(2 - 2 * (u - 0.5f) / 0.5f).margin(1e-6));
                CHECK(t.position(x, y).y == Approx((v - 0.25f) / 0.5f).margin(1e-6));
                CHECK(t.normal(x, y) == glm::vec4(0, 0, -1, 1));
                CHECK(t.emission(x, y).x == 1);
            } else {
                CHECK(t.id(x, y) == glm::ivec3(-1));
                CHECK(t.normal(x, y) == glm::vec4(0));
                CHECK(t.position(x, y) == glm::vec4(0));
            }
        }
}

TEST_CASE("texture space: receivers add up to the area of their charts", "[raster][IPR 3.2.1.2]") {
    // The floor has 4 m2 on half of the texels, the wall 2 m2 on a quarter.
    for (int size : {64, 100, 333}) {
        const TextureSpace t = draw(room(), {size, size});
        int floor = 0, wall = 0;
        for (const glm::ivec3& id : t.id.texels) floor += id.x == 3, wall += id.x == 4;
        CHECK(floor / double(size) / size == Approx(0.5).margin(1.0 / size));
        CHECK(wall / double(size) / size == Approx(0.25).margin(1.5 / size));
    }
}

TEST_CASE("texture space: of triangles that overlap the first stays, and what is outside is cut off", "[raster]") {
    Geometry g;
    const glm::vec3 square[4] = {{0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0}};
    add_chart(g, square, {0, 0}, {1, 1}, 0, 0);
    add_chart(g, square, {-3, -3}, {5, 5}, 1, 1);
    const TextureSpace t = draw(g, {40, 24});
    for (const glm::ivec3& id : t.id.texels) REQUIRE(id.x == 0);

    Geometry outside;
    add_chart(outside, square, {-3, -3}, {5, 5}, 1, 1);
    const TextureSpace all = draw(outside, {40, 24});
    CHECK(all.id(0, 0).x == 1);
    CHECK(all.position(39, 23).x == Approx((39.5f / 40 + 3) / 8).epsilon(1e-6));
}

TEST_CASE("texture space: the same bits for every instruction set and thread count", "[raster][bits]") {
    const Geometry g = room();
    RunOptions one;
    one.isa = Isa::scalar, one.threads = 1;
    const TextureSpace expected = draw(g, {77, 53}, 2, one);
    for (Isa isa : supported_isas())
        for (int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            const TextureSpace t = draw(g, {77, 53}, 2, options);
            CHECK(t.position.texels == expected.position.texels);
            CHECK(t.normal.texels == expected.normal.texels);
            CHECK(t.id.texels == expected.id.texels);
            CHECK(t.barycentrics.texels == expected.barycentrics.texels);
        }
}

TEST_CASE("texture space: what is refused", "[raster][bad input]") {
    Geometry g = room();
    TextureSpace out;
    const Surfaces surfaces = prepare(materials(2), g);
    std::vector<glm::vec2> uv = texture_coordinates(g);
    uv.pop_back();
    CHECK_THROWS_WITH(draw_texture_space(g, surfaces, uv, {8, 8}, {}, out),
                      Catch::Contains("11 texture coordinates") && Catch::Contains("12 vertices"));
    uv.push_back({std::numeric_limits<float>::infinity(), 0});
    CHECK_THROWS_WITH(draw_texture_space(g, surfaces, uv, {8, 8}, {}, out), Catch::Contains("vertex 11"));
    CHECK_THROWS_AS(draw_texture_space(g, surfaces, texture_coordinates(g), {0, 8}, {}, out), InputError);
}

}  // namespace plumb::raster
