// A point light's six faces: nothing between them is left out, nothing is seen twice.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/host_math.h"
#include "drawing.h"
#include "raster/light_view.h"
#include "raster/rsm.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

Light point_light(glm::vec3 position, int size) {
    Light light;
    light.name = "lamp";
    light.type = LightType::point;
    light.position = position;
    light.intensity = {3, 2, 1};
    light.rsm_size = size;
    return light;
}

// The inside of a box: twelve triangles.
Geometry box(glm::vec3 low, glm::vec3 high) {
    Geometry g;
    auto corner = [&](int i) { return at({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}); };
    const int sides[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
    for (const auto& s : sides) {
        add_triangle(g, corner(s[0]), corner(s[1]), corner(s[2]));
        add_triangle(g, corner(s[0]), corner(s[2]), corner(s[3]));
    }
    return g;
}

const glm::vec3 rho(0.25f, 0.5f, 0.75f), low(-1, -2, -3), high(2, 1, 1.5f);

std::vector<Rsm> draw_faces(const Geometry& g, const Light& light, RunOptions options = {},
                            Layout layout = Layout::fp32) {
    Scene scene;
    scene.materials.push_back({"wall", rho, glm::vec3(0), -1});
    const Surfaces surfaces = prepare(scene, g);
    glm::vec3 from, to;
    bounds(g, from, to);
    std::vector<Rsm> maps(light_faces);
    const std::vector<View> views = light_views(light, from, to);
    for (int m = 0; m < light_faces; ++m) draw_rsm(g, surfaces, light, views[m], layout, options, maps[m]);
    return maps;
}

}  // namespace

// The solid angle of a face is 4 pi / 6, the integral of f = (1 + x^2 + y^2)^(-3/2) over [-1, 1]^2. The midpoint rule of
// step h = 2/R exceeds it by -h^2/24 times the integral of f_xx + f_yy, which is the flow of grad f through the border,
// -4 * 3 * integral of (2 + y^2)^(-5/2) = -16 / (3 sqrt 3). Six faces: 4 pi + 16 / (3 sqrt 3) / R^2, and R^-4 behind it.
TEST_CASE("point light: six faces carry 4 pi I, with the midpoint rule's error", "[raster][rsm][point][analytic]") {
    const Geometry g = box(low, high);
    for (int size : {1, 2, 7, 8, 33, 64, 101}) {
        const Light light = point_light({0.3f, -0.6f, 0.2f}, size);
        const std::vector<Rsm> maps = draw_faces(g, light);
        glm::dvec3 sum(0);
        for (const Rsm& map : maps) {
            REQUIRE(map.texel_scale == 2.0 / size);
            for (const glm::vec4& n : map.normal.texels) REQUIRE(n.w == 1);  // closed: every texel sees a wall
            for (const glm::vec4& flux : map.flux.texels) sum += glm::dvec3(flux);
        }
        const double r2 = double(size) * size, predicted = 16 / (3 * std::sqrt(3.0)) / r2;
        for (int c = 0; c < 3; ++c) {
            const double angle = sum[c] / (double(light.intensity[c]) * rho[c]);
            CAPTURE(size, angle - 4 * host::pi, predicted);
            if (size == 1) REQUIRE(angle == 24);  // six texels of 2 x 2 at distance 1
            if (size >= 7) REQUIRE(std::abs(angle - 4 * host::pi - predicted) <= 3 / (r2 * r2) + 2e-6);
        }
    }
}

TEST_CASE("point light: the axes of each face are those of the drawing in light_view.h", "[raster][light][point]") {
    const Light light = point_light({1, 2, 3}, 10);
    const std::vector<View> views = light_views(light, low, high);
    REQUIRE(views.size() == 6);
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), eye(1, 2, 3);
    const glm::dvec3 forward[] = {x, -x, y, -y, z, -z}, right[] = {z, -z, -x, -x, -x, x}, up[] = {y, y, -z, z, y, y};
    for (int f = 0; f < 6; ++f) {
        CAPTURE(f);
        CHECK(views[f].forward == forward[f]);
        const glm::dvec2 middle = project_to_texels(views[f], 10, eye + forward[f]);
        const glm::dvec2 corner = project_to_texels(views[f], 10, eye + forward[f] + right[f] + up[f]);
        CHECK((middle.x == 5 && middle.y == 5));
        CHECK((corner.x == 10 && corner.y == 0));  // the top right corner, exactly: faces share their borders
    }
}

TEST_CASE("point light: every direction has one face, and falls on its map", "[raster][light][point]") {
    const std::vector<View> views = light_views(point_light({0, 0, 0}, 33), low, high);
    Random random(3);
    for (int i = 0; i < 20000; ++i) {
        glm::vec3 v = random.vector(-1, 1);
        if (i % 3 == 0) v[i % 2] = (i & 4 ? 1.0f : -1.0f) * v[(i % 2) + 1];  // on a border
        const int face = face_of<float>(v);
        const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        REQUIRE(dot(views[face].forward, glm::dvec3(v)) == largest);
        const glm::dvec2 texel = project_to_texels(views[face], 33, glm::dvec3(v));
        REQUIRE((texel.x >= 0 && texel.x <= 33 && texel.y >= 0 && texel.y <= 33));
    }
    // Ties go to x, then y, then z; 0 to the positive face.
    CHECK(face_of<float>(glm::vec3(1, 1, 1)) == 0);
    CHECK(face_of<float>(glm::vec3(-1, 1, -1)) == 1);
    CHECK(face_of<float>(glm::vec3(0, -1, 1)) == 3);
    CHECK(face_of<float>(glm::vec3(0, 0, 0)) == 0);
    CHECK(face_of<float>(glm::vec3(0.5f, 0.25f, -1)) == 5);
}

TEST_CASE("point light: what may_see() leaves out holds nothing, and a hit is never left out", "[raster][light][point]") {
    Random random(5);
    int left_out = 0, kept = 0;
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 from = random.vector(-3, 2), to = from + random.vector(0.1, 2);
        const Geometry g = box(from, to);
        const Light light = point_light(random.vector(-3, 3), 24);
        const std::vector<View> views = light_views(light, from, to);
        const std::vector<Rsm> maps = draw_faces(g, light);
        for (int f = 0; f < 6; ++f) {
            int covered = 0;
            for (const glm::vec4& n : maps[f].normal.texels) covered += n.w != 0;
            const bool seen = may_see(views[f], from, to);
            if (!seen) REQUIRE(covered == 0);
            left_out += !seen;
            kept += covered > 0;
        }
    }
    CHECK(left_out > 60);
    CHECK(kept > 60);
}

TEST_CASE("point light: the same bits for every instruction set and 1, 2, 3 threads", "[raster][rsm][point][bits]") {
    const Geometry g = box(low, high);
    const Light light = point_light({0.3f, -0.6f, 0.2f}, 37);
    RunOptions options;
    options.isa = Isa::scalar, options.threads = 1;
    for (const Layout& layout : {Layout::fp32, Layout::rgba16f}) {
        const std::vector<Rsm> truth = draw_faces(g, light, options, layout);
        for (Isa isa : supported_isas())
            for (int threads : {1, 2, 3}) {
                RunOptions other;
                other.isa = isa, other.threads = threads;
                const std::vector<Rsm> maps = draw_faces(g, light, other, layout);
                CAPTURE(isa_name(isa), threads, layout.name);
                for (int f = 0; f < 6; ++f) {
                    auto equal = [](const auto& a, const auto& b) {
                        return a.size() == b.size() &&
                               (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
                    };
                    REQUIRE(equal(maps[f].records, truth[f].records));
                    REQUIRE(equal(maps[f].half_records, truth[f].half_records));
                    REQUIRE(equal(maps[f].flux.texels, truth[f].flux.texels));
                }
            }
    }
}
