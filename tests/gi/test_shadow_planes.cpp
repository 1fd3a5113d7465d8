// The shadow test by planes: what a light sees is made of patches of planes, hit in double precision, so that it is known who hides whom.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "core/formats.h"
#include "core/host_math.h"
#include "gi/direct/direct.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;
using direct::ShadowMode;
using direct::ShadowParams;
using direct::ShadowTest;

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(dot(v, v)); }

struct Patch {
    glm::dvec3 p, n;  // a point of it; unit
    std::function<bool(const glm::dvec3&)> covers = [](const glm::dvec3&) { return true; };
};

constexpr glm::vec3 low{-2, -2, -2}, high{2, 2, 2};

Light sun(const glm::vec3& direction) {
    Light light;
    light.type = LightType::directional;
    light.direction = direction;
    return light;
}
Light spot(const glm::vec3& position, const glm::vec3& direction) {
    Light light;
    light.position = position, light.direction = direction;
    light.cone_inner_deg = 30, light.cone_outer_deg = 45;
    return light;
}

struct Seen {
    glm::dvec3 x, n;
    double depth = 0;  // 0: nothing
};

// What a light sees at a place of its map, in texels.
class LightOf {
  public:
    LightOf(Light light, int size, std::vector<Patch> patches) : patches_(std::move(patches)) {
        light.rsm_size = size;
        map = raster::unseen_rsm(light, raster::light_view(light, low, high));
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const Seen s = at(x + 0.5, y + 0.5);
                map.position(x, y) = glm::vec4(glm::vec3(s.x), float(s.depth)), map.normal(x, y) = glm::vec4(glm::vec3(s.n), s.depth > 0);
            }
    }
    Seen at(double u, double v) const {
        const View& view = map.view;
        const glm::dmat4& m = view.world_to_view;
        const glm::dvec3 right(m[0][0], m[1][0], m[2][0]), up(m[0][1], m[1][1], m[2][1]);
        const glm::dvec3 across = right * ((2 * u / map.size - 1) / view.view_to_clip[0][0]) + up * ((2 * v / map.size - 1) / view.view_to_clip[1][1]);
        const glm::dvec3 origin = view.orthographic ? view.eye + across : view.eye;
        const glm::dvec3 ray = view.orthographic ? view.forward : view.forward + across;
        Seen nearest{glm::dvec3(0), glm::dvec3(0), 0};
        for (const Patch& patch : patches_) {
            const double slope = dot(patch.n, ray), t = dot(patch.n, patch.p - origin) / slope;
            if (!(slope != 0 && t > 1e-3 && (nearest.depth == 0 || t < nearest.depth))) continue;
            const glm::dvec3 x = origin + ray * t;
            if (patch.covers(x)) nearest = {x, slope < 0 ? patch.n : -patch.n, t};
        }
        return nearest;
    }
    // A place of the map where a point falls.
    glm::dvec2 place(const glm::dvec3& x) const { return raster::project_to_texels(map.view, map.size, x); }

    raster::Rsm map;

  private:
    std::vector<Patch> patches_;
};

ShadowParams params_of(ShadowMode mode, int kernel, ShadowTest test = ShadowTest::planes) {
    ShadowParams params;
    params.mode = mode, params.kernel = params.pcf_kernel = kernel, params.test = test;
    params.bias = 1e-5f, params.least_sine = 0;
    return params;
}

// `rows` > 0: the points are a picture of so many rows.
std::vector<float> visibility_of(const ShadowParams& params, const raster::Rsm& map, const std::vector<Seen>& points, float rounding = 0x1p-22f,
                                 int rows = 0) {
    Points p(int(points.size()) / std::max(rows, 1), std::max(rows, 1));
    for (std::size_t i = 0; i < points.size(); ++i)
        p.position.texels[i] = glm::vec4(glm::vec3(points[i].x), 0), p.normal.texels[i] = glm::vec4(glm::vec3(points[i].n), 1);
    std::vector<float> visibility(points.size(), -1);
    direct::run(params, {&p.position, &p.normal, {&map, 1}, nullptr, {}, rounding, rows > 0}, {}, visibility.data());
    return visibility;
}

// Points that the light sees, beside the centres of texels.
std::vector<Seen> lit_points(const LightOf& light, int margin) {
    std::vector<Seen> all;
    for (double v = margin + 0.13; v < light.map.size - margin; v += 0.737)
        for (double u = margin + 0.31; u < light.map.size - margin; u += 0.691)
            if (const Seen s = light.at(u, v); s.depth > 0) all.push_back(s);
    return all;
}

std::size_t below_one(const std::vector<float>& visibility) {
    return std::size_t(std::count_if(visibility.begin(), visibility.end(), [](float v) { return !(v == 1); }));
}

std::vector<ShadowParams> filters(ShadowTest test, int widest = 16) {
    std::vector<ShadowParams> all = {params_of(ShadowMode::hard, 1, test)};
    for (const int k : {1, 2, 3, 4, 5, 9, 16})
        for (const ShadowMode mode : {ShadowMode::density, ShadowMode::pcf})
            if (k <= widest) all.push_back(params_of(mode, k, test));
    return all;
}

}  // namespace

// n.(m - x) = 0 for all m of the plane: what is left is the rounding of positions, far below the bias of 1e-5 m.
TEST_CASE("shadow by planes: a plane never shadows itself, at any angle, with any number of taps", "[shadow][acne][analytic]") {
    std::size_t seen = 0;
    const auto in_the_room = [](const glm::dvec3& x) { return std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}) <= 2; };
    for (const double degrees : {0.0, 30.0, 60.0, 80.0, 87.0, 89.0, 89.9}) {
        const double a = degrees * host::pi / 180;
        const glm::dvec3 n = unit({0.3 * host::sin(a), host::cos(a), host::sin(a)});
        for (const Light& light : {sun({0, -1, 0}), sun({0.3f, -0.8f, 0.1f}), spot({0, 1.5f, 0}, {0, -1, 0})}) {
            const LightOf of(light, 64, {{{0, -0.5, 0}, n, in_the_room}});
            const std::vector<Seen> points = lit_points(of, 0);
            seen += points.size();
            for (const ShadowTest test : {ShadowTest::plane, ShadowTest::planes})
                for (const ShadowParams& params : filters(test)) {
                    CAPTURE(degrees, int(light.type), int(params.mode), params.kernel, int(test));
                    CHECK(below_one(visibility_of(params, of.map, points)) == 0);
                }
        }
    }
    CHECK(seen > 20000);
    // By depth a slope of more than max_slope is in its own shadow.
    const LightOf of(sun({0, -1, 0}), 64, {{{0, -0.5, 0}, unit({0, 0.2, 1}), in_the_room}});
    ShadowParams by_depth = params_of(ShadowMode::hard, 1, ShadowTest::depth);
    CHECK(below_one(visibility_of(by_depth, of.map, lit_points(of, 0))) == 0);
    by_depth.max_slope = 2;
    CHECK(below_one(visibility_of(by_depth, of.map, lit_points(of, 0))) > 20);
}

// A patch h above a plane, seen along its normal and aslant: its edge is the border between two columns of texels. A point of the plane
// that falls on place t of the map has the squares' share beyond the edge; with one texel a step at the edge itself.
TEST_CASE("shadow by planes: what stands any height above a plane shadows up to its own edge", "[shadow][leak][analytic]") {
    for (const glm::dvec3& n : {glm::dvec3(0, 1, 0), unit({0.4, 1, 0.5}), unit({-0.9, 0.4, 0})}) {
        for (const double h : {3e-5, 1e-3, 0.01, 0.3}) {
            const Light light = sun({0, -1, 0});
            const LightOf plane(light, 64, {{{0, -0.5, 0}, n}});
            // Places grow along one axis of the world: the edge is where the middle of the map lies.
            const LightOf of(light, 64, {{{0, -0.5, 0}, n}, {glm::dvec3(0, -0.5, 0) + n * h, n, [&](const glm::dvec3& x) { return plane.place(x).x < 32; }}});
            std::vector<Seen> points;
            std::vector<double> places;
            for (double t = 24.1; t < 40; t += 0.23) {
                Seen s = plane.at(t, 30.4);
                points.push_back(s), places.push_back(t);
            }
            const std::vector<float> hard = visibility_of(params_of(ShadowMode::hard, 1), of.map, points);
            const std::vector<float> four = visibility_of(params_of(ShadowMode::density, 4), of.map, points);
            for (std::size_t i = 0; i < points.size(); ++i) {
                CAPTURE(n.x, h, places[i]);
                CHECK(hard[i] == (places[i] < 32 ? 0 : 1));
                CHECK(four[i] == Approx(std::clamp((std::floor(places[i]) + 2 - 32) / 4, 0.0, 1.0)).margin(1e-6));
            }
            for (const int k : {1, 2, 3, 4, 9}) {
                const std::vector<float> square = visibility_of(params_of(ShadowMode::pcf, k), of.map, points);
                for (std::size_t i = 0; i < points.size(); ++i) {
                    CAPTURE(n.x, h, k, places[i]);
                    CHECK(square[i] == Approx(std::clamp((places[i] - 32) / k + 0.5, 0.0, 1.0)).margin(2e-4));
                }
            }
        }
    }
}

// A square of k x k texels about the projection, of which one texel is in the way.
TEST_CASE("pcf: a texel counts by the area that the square has of it", "[shadow][pcf][analytic]") {
    const Patch floor{{0, -0.5, 0}, {0, 1, 0}};
    const Light light = sun({0, -1, 0});
    const LightOf plane(light, 64, {floor});
    const LightOf of(light, 64, {floor, {{0, 0, 0}, {0, 1, 0}, [&](const glm::dvec3& x) {
                                             const glm::dvec2 at = plane.place(x);
                                             return std::floor(at.x) == 30 && std::floor(at.y) == 33;
                                         }}});
    auto overlap = [](double middle, int k, double texel) { return std::max(0.0, std::min(middle + k / 2.0, texel + 1) - std::max(middle - k / 2.0, texel)); };
    for (const int k : {1, 2, 3, 4, 5, 8})
        for (double v = 27; v < 40; v += 0.71)
            for (double u = 24; u < 36; u += 0.63) {
                const double exact = 1 - overlap(u, k, 30) * overlap(v, k, 33) / (k * k);
                CAPTURE(k, u, v);
                CHECK(visibility_of(params_of(ShadowMode::pcf, k), of.map, {plane.at(u, v)})[0] == Approx(exact).margin(2e-4));
            }
}

// A floor and a wall that stands on it, both lit: texels of the wall lie over the plane of the floor.
TEST_CASE("shadow by planes: of two planes that meet in a corner neither shadows the other", "[shadow][seam][analytic]") {
    std::size_t by_one = 0;
    for (const double lean : {0.0, 0.5, -0.3}) {
        const glm::dvec3 n_wall = unit({1, lean, 0});
        const Patch floor{{0, -0.5, 0}, {0, 1, 0}, [&](const glm::dvec3& x) { return dot(n_wall, x - glm::dvec3(-0.2, -0.5, 0)) >= 0; }};
        const Patch wall{{-0.2, -0.5, 0}, n_wall, [](const glm::dvec3& x) { return x.y >= -0.5; }};
        for (const Light& light : {sun({-0.5f, -0.8f, 0.1f}), spot({1, 1.5f, 0.2f}, {-0.5f, -1, 0})}) {
            const LightOf of(light, 64, {floor, wall});
            const std::vector<Seen> points = lit_points(of, 10);
            for (const ShadowParams& params : filters(ShadowTest::planes)) {
                CAPTURE(lean, int(light.type), int(params.mode), params.kernel);
                CHECK(below_one(visibility_of(params, of.map, points)) == 0);
            }
            by_one += below_one(visibility_of(params_of(ShadowMode::density, 4, ShadowTest::plane), of.map, points));
        }
    }
    CHECK(by_one > 100);  // the second plane is what prevents it
}

// Of a surface that bends towards the light as well as away from it: a wave of narrow strips with the normals of a smooth one.
TEST_CASE("shadow by planes: a surface that bends does not shadow itself, its normals bent or not", "[shadow][acne]") {
    std::vector<Patch> strips;
    const double width = 0.05, amplitude = 0.15, wave = 2.5;
    for (int i = -40; i < 40; ++i) {
        const double from = i * width, to = from + width;
        const glm::dvec3 a(from, amplitude * host::cos(wave * from), 0), b(to, amplitude * host::cos(wave * to), 0);
        strips.push_back({a, unit({a.y - b.y, b.x - a.x, 0}), [=](const glm::dvec3& x) { return x.x >= from && x.x < to; }});
    }
    LightOf of(sun({0.2f, -1, 0.1f}), 64, strips);
    auto smooth = [&](Seen s) {
        s.n = unit({amplitude * wave * host::sin(wave * s.x.x), 1, 0});
        return s;
    };
    std::vector<Seen> flat = lit_points(of, 1), bent;
    for (const Seen& s : flat) bent.push_back(smooth(s));
    // Half a strip's turn is 0.5 amplitude wave^2 width = 0.0234: normals are off by no more. And where the wave turns from one way to the
    // other two points d apart lie over each other's planes by amplitude wave^3 d^3 / 12: three texels of 0.108 m by a sine of
    // 0.021, on slopes up to 0.4 by a third more.
    constexpr float sine = 0.06f;
    for (ShadowParams params : filters(ShadowTest::planes, 4)) {
        params.least_sine = sine;
        CAPTURE(int(params.mode), params.kernel);
        CHECK(below_one(visibility_of(params, of.map, flat)) == 0);
    }
    for (glm::vec4& n : of.map.normal.texels) {
        const std::size_t i = std::size_t(&n - of.map.normal.data());
        if (of.map.position.texels[i].w > 0) n = glm::vec4(glm::vec3(smooth({glm::dvec3(of.map.position.texels[i]), {}, 1}).n), 1);
    }
    std::size_t without = 0;
    for (ShadowParams params : filters(ShadowTest::planes, 4)) {
        without += below_one(visibility_of(params, of.map, bent));
        params.least_sine = sine;
        CAPTURE(int(params.mode), params.kernel);
        CHECK(below_one(visibility_of(params, of.map, bent)) == 0);
    }
    CHECK(without > 50);
}

// A normal map turns the normals of a plane by 37 degrees, each another way; the plane of the pixels stays what it is.
TEST_CASE("shadow by planes: a normal map puts no part of a plane in its own shadow", "[shadow][acne][analytic]") {
    const double tilt = std::sqrt(0.36);
    for (const glm::dvec3& n : {glm::dvec3(0, 1, 0), unit({0.4, 1, 0.5}), unit({-0.9, 0.4, 0})}) {
        const glm::dvec3 a = unit({n.y, -n.x, 0}), b(a.y * n.z - a.z * n.y, a.z * n.x - a.x * n.z, a.x * n.y - a.y * n.x);
        for (const Light& light : {sun({0.1f, -1, 0}), spot({0, 1.5f, 0}, {0, -1, 0})}) {
            LightOf of(light, 64, {{{0, -0.5, 0}, n}});
            std::vector<Seen> points;
            for (int y = 0; y < 24; ++y)
                for (int x = 0; x < 24; ++x) {
                    Seen s = of.at(20.3 + x, 20.7 + y);
                    REQUIRE(s.depth > 0);
                    const double turn = 0.7 * x + 2.1 * y;
                    s.n = n * 0.8 + (a * host::cos(turn) + b * host::sin(turn)) * tilt;
                    points.push_back(s);
                }
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 64; ++x) {
                    const double turn = 1.3 * x + 0.4 * y;
                    of.map.normal(x, y) = glm::vec4(glm::vec3(n * 0.8 + (a * host::cos(turn) + b * host::sin(turn)) * tilt), 1);
                }
            std::size_t of_normals_alone = 0;
            for (const ShadowTest test : {ShadowTest::plane, ShadowTest::planes})
                for (const ShadowParams& params : filters(test, 5)) {
                    CAPTURE(n.x, int(light.type), int(params.mode), params.kernel, int(test));
                    CHECK(below_one(visibility_of(params, of.map, points, 0x1p-22f, 24)) == 0);
                    of_normals_alone += below_one(visibility_of(params, of.map, points));
                }
            CHECK(of_normals_alone > 1000);
        }
    }
}

// Two sides of a roof that meet between two pixels.
TEST_CASE("shadow by planes: what stands over an edge shadows both sides of it", "[shadow][leak][analytic]") {
    const glm::dvec3 left = unit({-0.5, 1, 0}), right = unit({0.5, 1, 0});
    const Patch roof_l{{0, -0.5, 0}, left, [](const glm::dvec3& x) { return x.x < 0; }}, roof_r{{0, -0.5, 0}, right, [](const glm::dvec3& x) { return x.x >= 0; }};
    for (const Light& light : {sun({0, -1, 0}), spot({0, 1.5f, 0}, {0, -1, 0})}) {
        const LightOf roof(light, 64, {roof_l, roof_r}), of(light, 64, {roof_l, roof_r, {{0, 0, 0}, {0, 1, 0}}});
        std::vector<Seen> points;
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x) points.push_back(roof.at(24.3 + x, 24.7 + y));
        for (const ShadowParams& params : filters(ShadowTest::planes, 5)) {
            CAPTURE(int(light.type), int(params.mode), params.kernel);
            for (const float v : visibility_of(params, of.map, points, 0x1p-22f, 16)) CHECK(v == 0);
            CHECK(below_one(visibility_of(params, roof.map, points, 0x1p-22f, 16)) == 0);
        }
    }
}

// A floor under a normal map, seen up to the foot of a wall: the floor's last column has the wall beside it, whose planes with it
// may lie nearer to the bent normal than the floor's own.
TEST_CASE("shadow by planes: under a normal map no corner is in its own shadow", "[shadow][acne][analytic]") {
    const Patch floor{{0, -0.5, 0}, {0, 1, 0}, [](const glm::dvec3& x) { return x.x >= -0.2; }};
    const Patch wall{{-0.2, -0.5, 0}, {1, 0, 0}, [](const glm::dvec3& x) { return x.y >= -0.5; }};
    for (const double degrees : {10.0, 30.0, 37.0, 45.0, 60.0})
        for (const double towards : {-1.0, 1.0}) {
            const double a = degrees * host::pi / 180;
            const glm::dvec3 bent(towards * host::sin(a), host::cos(a), 0);
            LightOf of(sun({-0.5f, -0.8f, 0.1f}), 64, {floor, wall});
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 64; ++x)
                    if (of.map.normal(x, y).y > 0.9f) of.map.normal(x, y) = glm::vec4(glm::vec3(bent), 1);
            std::vector<Seen> points;
            for (int y = 0; y < 12; ++y)
                for (int x = 0; x < 12; ++x) {
                    const double across = (x - 6 + 0.5) * 0.03, along = (y - 6 + 0.5) * 0.03;
                    Seen s;
                    s.depth = 1;
                    if (across >= 0) s.x = {-0.2 + across, -0.5, along}, s.n = bent;
                    else s.x = {-0.2, -0.5 - across, along}, s.n = {1, 0, 0};
                    points.push_back(s);
                }
            for (const ShadowParams& params : {params_of(ShadowMode::hard, 1), params_of(ShadowMode::pcf, 1), params_of(ShadowMode::density, 4)}) {
                CAPTURE(degrees, towards, int(params.mode));
                const std::vector<float> seen = visibility_of(params, of.map, points, 0x1p-22f, 12);
                for (std::size_t i = 0; i < points.size(); ++i)
                    if (points[i].n.x != 1) {
                        CAPTURE(i % 12);
                        CHECK(seen[i] == 1);
                    }
            }
        }
}

// A thing one pixel wide before a wall far away, or before nothing: no two pixels go on as it does.
TEST_CASE("shadow by planes: what is one pixel wide is shadowed as its normal has it", "[shadow][leak][analytic]") {
    const glm::dvec3 n = unit({1, 1, 0});
    const Light light = sun({0, -1, 0});
    const LightOf of(light, 64, {{{0, 0.2, 0}, {0, 1, 0}}});
    for (const bool nothing : {false, true})
        for (const double at : {0.0, 0.02, 0.05}) {
            std::vector<Seen> points;
            for (int y = 0; y < 20; ++y)
                for (int x = 0; x < 9; ++x) {
                    Seen s;
                    if (x == 4) s = {{at, -0.3 + 0.01 * y, 0}, n, 1};
                    else if (!nothing) s = {{at + 0.2 * (x - 4), -0.3 + 0.1 * y, -1.5}, {0, 0, 1}, 1};
                    points.push_back(s);
                }
            for (const ShadowParams& params : {params_of(ShadowMode::hard, 1), params_of(ShadowMode::pcf, 1)}) {
                const std::vector<float> seen = visibility_of(params, of.map, points, 0x1p-22f, 20);
                for (int y = 0; y < 20; ++y) {
                    CAPTURE(nothing, at, y, int(params.mode));
                    CHECK(seen[std::size_t(y) * 9 + 4] == 0);
                }
            }
        }
}

// Light along a surface: what stands 1 m before it in the light lies 3 cm over its plane, less than a tenth of the texels' reach on it.
TEST_CASE("shadow by planes: what is farther away than a surface's own texels shadows it at any angle", "[shadow][leak][analytic]") {
    const Light light = sun({0, -1, 0});
    const glm::dvec3 n = unit({1, 0.03, 0});
    const Patch wall{{0, -0.5, 0}, n};  // cosine 0.03
    const LightOf plane(light, 1024, {wall}), of(light, 1024, {wall, {{0, 1, 0}, {0, 1, 0}}});
    std::vector<Seen> points;
    for (double t = 511.2; t < 513; t += 0.1) points.push_back(plane.at(t, 500.4)), points.push_back(plane.at(500.4, t));
    std::erase_if(points, [](const Seen& s) { return std::abs(s.x.y) > 0.6; });
    REQUIRE(points.size() > 3);
    for (ShadowParams params : {params_of(ShadowMode::hard, 1), params_of(ShadowMode::pcf, 1)}) {
        params.least_sine = 0.1f;
        for (const float v : visibility_of(params, of.map, points)) CHECK(v == 0);
        CHECK(below_one(visibility_of(params, plane.map, points)) == 0);
    }
}

// The limit of the slope ends the reach, too: of a surface at a cosine of 0.03 it is 16 texels of k', and not 33.
TEST_CASE("shadow by planes: what hangs before a grazed surface beyond its limited reach shadows it", "[shadow][leak][analytic]") {
    const Light light = sun({0, -1, 0});
    const glm::dvec3 n = unit({1, 0.03, 0});
    const Patch wall{{0, -0.5, 0}, n};
    const LightOf plane(light, 1024, {wall});
    const double texel = plane.map.texel_scale;
    // At the texels' centres: beside them the texel's own place lies up to 16 texels along the surface.
    std::vector<Seen> points;
    for (int column = 508; column < 516; ++column)
        for (const double beside : {-0.04, 0.0, 0.03}) points.push_back(plane.at(column + 0.5 + beside, 500.5));
    const LightOf of(light, 1024, {wall, {{0, -0.5 + 24 * texel, 0}, n}});
    ShadowParams params = params_of(ShadowMode::hard, 1);
    params.least_sine = 0.1f;
    for (const float v : visibility_of(params, of.map, points)) CHECK(v == 0);
    CHECK(below_one(visibility_of(params, plane.map, points)) == 0);
}

// Half a bias behind the plane of a wall is on it.
TEST_CASE("shadow by planes: a point on the plane of what the light sees is not under it", "[shadow][seam][analytic]") {
    const Patch floor{{0, -0.5, 0}, {0, 1, 0}, [](const glm::dvec3& x) { return x.x >= -0.2; }};
    const Patch wall{{-0.2, -0.5, 0}, {1, 0, 0}, [](const glm::dvec3& x) { return x.y >= -0.5; }};
    const LightOf of(sun({-0.5f, -0.8f, 0.1f}), 64, {floor, wall});
    ShadowParams params = params_of(ShadowMode::density, 4);
    params.bias = 1e-3f;
    for (const auto& [behind, lit] : {std::pair{0.5e-3, true}, std::pair{5e-3, false}}) {
        std::vector<Seen> points;
        for (int k = 0; k < 16; ++k) points.push_back({{-0.2 - behind, -0.5, 0.05 * (k - 8)}, {0, 1, 0}, 1});
        CAPTURE(behind);
        CHECK((below_one(visibility_of(params, of.map, points)) == 0) == lit);
    }
}

// Halves of coordinates up to 2 m are 2^-10 m apart: far more than the bias.
TEST_CASE("shadow by planes: positions that are stored as halves take the rounding of the layout", "[shadow][acne]") {
    CHECK(direct::rounding_of(raster::Layout::fp32) == 0x1p-22f);
    CHECK(direct::rounding_of(raster::Layout::vrsm) == 0x1p-10f);
    LightOf of(spot({0.1f, 1.5f, 0.2f}, {0, -1, 0.1f}), 64, {{{0, -0.7, 0}, unit({0.5, 1, 0.3})}});
    std::vector<Seen> points = lit_points(of, 1);
    auto half = [](double x) { return double(half_to_float(float_to_half(float(x)))); };
    for (Seen& s : points) s.x = {half(s.x.x), half(s.x.y), half(s.x.z)};
    for (glm::vec4& p : of.map.position.texels) p = glm::vec4(float(half(p.x)), float(half(p.y)), float(half(p.z)), p.w);
    for (const ShadowParams& params : filters(ShadowTest::planes)) {
        CAPTURE(int(params.mode), params.kernel);
        CHECK(below_one(visibility_of(params, of.map, points, 0x1p-10f)) == 0);
        CHECK(below_one(visibility_of(params, of.map, points)) > 20);
    }
}

TEST_CASE("shadow by planes: a surface that looks away from the light lies behind its own front", "[shadow]") {
    // A slab 0.1 m thick.
    const Patch top{{0, 0, 0}, {0, 1, 0}}, bottom{{0, -0.1, 0}, {0, -1, 0}};
    const LightOf of(spot({0, 1.5f, 0}, {0, -1, 0}), 64, {top, bottom});
    std::vector<Seen> points = lit_points(of, 14);  // whose kernels stay on the map
    for (Seen& s : points) s.x.y = -0.1, s.n = {0, -1, 0};
    for (const ShadowParams& params : filters(ShadowTest::planes))
        for (const float v : visibility_of(params, of.map, points)) CHECK(v == 0);
    // Where nothing is seen there is no normal, and nothing is shadowed.
    const std::vector<Seen> nothing(3, Seen{glm::dvec3(0), glm::dvec3(0), 0});
    for (const float v : visibility_of(params_of(ShadowMode::hard, 1), of.map, nothing)) CHECK(v == 1);
}

TEST_CASE("shadow by planes: maps without normals, and roundings that are none, are refused", "[shadow]") {
    LightOf of(sun({0, -1, 0}), 16, {{{0, 0, 0}, {0, 1, 0}}});
    const std::vector<Seen> points = lit_points(of, 4);
    for (const float rounding : {-1.0f, 1.0f, float(NAN)})
        CHECK_THROWS_AS(visibility_of(params_of(ShadowMode::hard, 1), of.map, points, rounding), InputError);
    of.map.normal = {};
    CHECK_THROWS_AS(visibility_of(params_of(ShadowMode::hard, 1), of.map, points), InputError);
    CHECK(below_one(visibility_of(params_of(ShadowMode::hard, 1, ShadowTest::plane), of.map, points)) == 0);
    CHECK_FALSE(direct::reads_normals(params_of(ShadowMode::esm, 1)));
    CHECK_FALSE(direct::reads_normals(params_of(ShadowMode::density, 4, ShadowTest::plane)));
    CHECK(direct::reads_normals(params_of(ShadowMode::density, 4)));
}

TEST_CASE("shadow by planes: the same bits for every instruction set and thread count", "[shadow][bits]") {
    const Patch screen{{0, 0.3, 0}, unit({0.1, 1, 0}), [](const glm::dvec3& x) { return std::abs(x.x) + std::abs(x.z) < 0.7; }};
    const LightOf of(spot({0.3f, 1.5f, 0.1f}, {0, -1, 0.1f}), 48, {{{0, -0.7, 0}, unit({0.3, 1, 0.2})}, screen});
    const LightOf below(spot({0.3f, 1.5f, 0.1f}, {0, -1, 0.1f}), 48, {{{0, -0.7, 0}, unit({0.3, 1, 0.2})}});
    Points p(61, 47);
    for (int y = 0; y < 47; ++y)
        for (int x = 0; x < 61; ++x)
            if (const Seen s = below.at(0.79 * x, 1.03 * y); s.depth > 0)
                p.position(x, y) = glm::vec4(glm::vec3(s.x), 0), p.normal(x, y) = glm::vec4(glm::vec3(s.n), 1);
    for (const ShadowParams& params : filters(ShadowTest::planes, 5)) {
        std::vector<float> first;
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 3}) {
                RunOptions options;
                options.isa = isa, options.threads = threads;
                std::vector<float> v(p.position.size(), -1);
                direct::run(params, {&p.position, &p.normal, {&of.map, 1}}, options, v.data());
                if (first.empty()) first = v;
                CAPTURE(isa_name(isa), threads, int(params.mode), params.kernel);
                CHECK(v == first);
            }
        CHECK(std::count(first.begin(), first.end(), 0.0f) > 50);
        CHECK(std::count(first.begin(), first.end(), 1.0f) > 500);
    }
}
