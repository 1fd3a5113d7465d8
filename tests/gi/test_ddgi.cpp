// DDGI's stages in closed form: octahedral tiles, rays into texels, gutters, the eight probes of a cell.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "gi/lend.h"
#include "gi/probes/directions.h"

namespace {

using namespace plumb;
using namespace plumb::ddgi;

float draw(int i, int seed) { return float(std::uint32_t(pixel_hash<std::int32_t>(i, seed, 0, 7).x) >> 8) * 0x1p-24f; }
glm::vec3 random_direction(int i, int seed) {
    const glm::vec3 v(draw(i, seed) - 0.5f, draw(i, seed + 1) - 0.5f, draw(i, seed + 2) - 0.5f);
    return glm::normalize(v + glm::vec3(0, 0, 1e-3f));
}

// The atlas of one probe with gutter, of what its rays bring.
Image4 blended(int side, const Buffer<glm::vec4>& directions, const Image4& hits, const std::function<void(BlendInputs&)>& set = {},
               const RunOptions& options = {}) {
    const Image4 before(side + 2, side + 2, glm::vec4(-7));
    BlendInputs in;
    in.side = side, in.scale = float(host::pi), in.directions = &directions, in.hits = &hits, in.previous = &before;
    if (set) set(in);
    Image4 out, bordered;
    run(stage<BlendKernel>(), data_of(in), options, out);
    run(stage<BorderKernel>(), data_of(BorderInputs{side, &out}), options, bordered);
    return bordered;
}

// E(n) of an atlas of one probe: the bilinear lookup alone.
std::vector<glm::vec3> looked_up(const Image4& atlas, int side, const std::vector<glm::vec3>& normals) {
    Image4 position(int(normals.size()), 1), normal = position, view = position;
    for (std::size_t i = 0; i < normals.size(); ++i) normal.texels[i] = glm::vec4(normals[i], 0);
    SampleInputs in;
    in.side = side, in.weighing.visibility = in.weighing.wrapped = false;
    in.position = &position, in.normal = &normal, in.view = &view, in.irradiance = &atlas;
    Image4 out;
    run(stage<SampleKernel>(), data_of(in), {}, out);
    std::vector<glm::vec3> e;
    for (const glm::vec4& t : out.texels) e.push_back(glm::vec3(t));
    return e;
}

glm::dvec3 texel_direction(int x, int y, int side) {
    return direction_of<double>({centre_of_texel<double>(x, side), centre_of_texel<double>(y, side)});
}

}  // namespace

TEST_CASE("ddgi: directions to the octahedron and back", "[ddgi][analytic]") {
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 d = random_direction(i, 1);
        const vec2<float> e = octahedral_of<float>(d);
        CHECK((std::fabs(e.x) <= 1 && std::fabs(e.y) <= 1));
        const glm::vec3 back = direction_of<float>(e);
        CHECK(glm::length(back - d) < 1e-6f);
    }
    // The six axes (Meyer et al. 2010, figure 1): +z in the middle, -z in a corner, the others on the edges' middles.
    const auto at = [](glm::vec3 d) { return octahedral_of<float>(d); };
    CHECK((at({0, 0, 1}).x == 0 && at({0, 0, 1}).y == 0));
    CHECK((at({3, 0, 0}).x == 1 && at({3, 0, 0}).y == 0));
    CHECK((at({0, -2, 0}).x == 0 && at({0, -2, 0}).y == -1));
    CHECK((std::fabs(at({0, 0, -1}).x) == 1 && std::fabs(at({0, 0, -1}).y) == 1));
    // A tile of n texels: its square spans 1/2 .. n + 1/2, and centres lie at whole numbers.
    CHECK((place_in_tile(-1.0f, 8) == 0.5f && place_in_tile(1.0f, 8) == 8.5f && place_in_tile(0.0f, 6) == 3.5f));
    for (int k = 1; k <= 8; ++k) CHECK(place_in_tile(centre_of_texel<float>(k, 8), 8) == Approx(k));
    // x / n of whole numbers, beyond all that an atlas or a list of probes holds.
    for (const int n : {3, 8, 10, 18, 66, 255, 4096})
        for (int x = 0; x < 1 << 22; x += 1 + x / 97) REQUIRE(divided<float>(x, n) == x / n);
}

TEST_CASE("ddgi.blend: a constant radiance L gives irradiance pi L, to rounding, with any rays", "[ddgi][analytic]") {
    for (const int rays : {7, 64, 512}) {
        const Buffer<glm::vec4> directions = probes::relight_directions(rays);
        const Image4 hits(rays, 1, glm::vec4(0.25f, 2, 1e4f, 3));
        const Image4 atlas = blended(8, directions, hits);
        for (const glm::vec4& t : atlas.texels) {
            CHECK(t.x == Approx(0.25 * host::pi).epsilon(1e-5));
            CHECK(t.y == Approx(2 * host::pi).epsilon(1e-5));
            CHECK(t.z == Approx(1e4 * host::pi).epsilon(1e-5));
        }
    }
}

TEST_CASE("ddgi.blend: under a half space of radiance L irradiance is pi L (1 + cos) / 2", "[ddgi][analytic]") {
    // Of a hemisphere tilted by theta against the lit one: Lambert 1760; 32767 rays leave 0.2 % of pi L.
    const int rays = 32767, side = 8;
    const Buffer<glm::vec4> directions = probes::relight_directions(rays);
    Image4 hits(rays, 1);
    for (int r = 0; r < rays; ++r)
        if (directions[std::size_t(r)].z > 0) hits(r, 0) = glm::vec4(5, 5, 5, 1);
    const Image4 atlas = blended(side, directions, hits);
    for (int y = 1; y <= side; ++y)
        for (int x = 1; x <= side; ++x)
            CHECK(atlas(x, y).x == Approx(5 * host::pi * (1 + texel_direction(x, y, side).z) / 2).margin(0.002 * 5 * host::pi));
}

TEST_CASE("ddgi.blend: moments of a sphere's distance, and of a plane's", "[ddgi][analytic]") {
    const int rays = 32767;
    const Buffer<glm::vec4> directions = probes::relight_directions(rays);
    const auto moments = [](BlendInputs& in) { in.moments = true, in.sharpness = 50, in.scale = 1; };
    // From the centre of a sphere of radius R: R and R^2, so that no variance is left.
    const Image4 sphere = blended(16, directions, Image4(rays, 1, glm::vec4(0, 0, 0, 2.5f)), moments);
    for (const glm::vec4& t : sphere.texels) {
        CHECK(t.x == Approx(2.5).epsilon(1e-5));
        CHECK(t.y == Approx(6.25).epsilon(1e-5));
    }
    // A plane at height h: distances h / cos; over the lobe cos^n around its normal their mean is (n + 1) / n h, that of
    // their squares (n + 1) / (n - 1) h^2. The middle texel of an odd tile looks along it.
    Image4 plane(rays, 1);
    for (int r = 0; r < rays; ++r)
        plane(r, 0).w = directions[std::size_t(r)].z > 1e-6f ? 3 / directions[std::size_t(r)].z : 1e15f;
    const Image4 seen = blended(15, directions, plane, [&](BlendInputs& in) { moments(in), in.farthest = 1e5f; });
    CHECK(seen(8, 8).x == Approx(51.0 / 50 * 3).epsilon(1e-3));
    CHECK(seen(8, 8).y == Approx(51.0 / 49 * 9).epsilon(1e-3));
    // Distances are cut.
    const Image4 cut = blended(15, directions, plane, [&](BlendInputs& in) { moments(in), in.farthest = 2; });
    CHECK(cut(8, 8).x == Approx(2).epsilon(1e-5));
    CHECK(cut(8, 8).y == Approx(4).epsilon(1e-5));
}

TEST_CASE("ddgi.blend: what a texel keeps", "[ddgi]") {
    const Buffer<glm::vec4> directions = probes::relight_directions(64);
    const Image4 hits(64, 1, glm::vec4(1));
    // 0.8 of pi and 0.2 of what was there, -7.
    CHECK(blended(6, directions, hits, [](BlendInputs& in) { in.hysteresis = 0.2f; })(3, 3).y == Approx(0.8 * host::pi - 1.4));
    // A texel that no ray counts for keeps all of it: one ray along +z and the lobe cos^256.
    const Buffer<glm::vec4> up(1, glm::vec4(0, 0, 1, 0));
    const Image4 one = blended(5, up, Image4(1, 1, glm::vec4(1)), [](BlendInputs& in) { in.sharpness = 256; });
    CHECK(one(3, 3).x == Approx(host::pi));
    CHECK(one(1, 1).x == -7);
    // A weight below the least does not count: cos^50 at 45 degrees is 3e-8.
    Buffer<glm::vec4> two = {{0, 0, 1, 0}, {0, float(std::sqrt(0.5)), float(std::sqrt(0.5)), 0}};
    Image4 bright(2, 1, glm::vec4(1));
    bright(1, 0) = glm::vec4(1e9f);
    CHECK(blended(5, two, bright, [](BlendInputs& in) { in.sharpness = 50; })(3, 3).x == Approx(host::pi));
    CHECK(blended(5, two, bright, [](BlendInputs& in) { in.sharpness = 50, in.least_weight = 1e-20f; })(3, 3).x > 30);
    // Whole powers against those of the host.
    for (const int n : {1, 2, 3, 5, 50, 255}) CHECK(whole_power(0.97f, n) == Approx(host::pow(double(0.97f), n)).epsilon(1e-5));
}

TEST_CASE("ddgi.border: lookups are continuous wherever the octahedron is folded", "[ddgi][analytic]") {
    // Random texels. Two directions a hair apart on both sides of a fold (x = 0 or y = 0 below the horizon) lie at two edges
    // of the tile, and still give the same; without the gutter they are texels apart.
    const int side = 6;
    Image4 atlas(side + 2, side + 2, glm::vec4(0)), bordered;
    for (int y = 1; y <= side; ++y)
        for (int x = 1; x <= side; ++x) atlas(x, y) = glm::vec4(draw(x, y), draw(x, y + 50), draw(x, y + 90), 0);
    run(stage<BorderKernel>(), data_of(BorderInputs{side, &atlas}), {}, bordered);
    std::vector<glm::vec3> normals;
    for (int i = 0; i < 200; ++i) {
        const double a = 1e-3 + (host::pi - 2e-3) * draw(i, 3);  // along the half circle, from one horizon to the other
        const float eps = 1e-6f, c = float(host::cos(a)), s = float(-host::sin(a));
        const bool along_x = i % 2 != 0;
        for (const float e : {eps, -eps}) normals.push_back(along_x ? glm::vec3(c, e, s) : glm::vec3(e, c, s));
    }
    const std::vector<glm::vec3> with = looked_up(bordered, side, normals), without = looked_up(atlas, side, normals);
    double jump = 0;
    for (std::size_t i = 0; i < normals.size(); i += 2) {
        CHECK(glm::length(with[i] - with[i + 1]) < 1e-4f);
        jump = std::max(jump, double(glm::length(without[i] - without[i + 1])));
    }
    CHECK(jump > 0.1);
    // -z is the middle of the four corner texels, and a texel's own direction gives the texel.
    const glm::vec4 corners = (atlas(1, 1) + atlas(side, 1) + atlas(1, side) + atlas(side, side)) / 4.0f;
    CHECK(glm::length(looked_up(bordered, side, {{0, 0, -1}})[0] - glm::vec3(corners)) < 1e-6f);
    for (int y = 1; y <= side; ++y)
        for (int x = 1; x <= side; ++x) {
            const glm::vec3 d(texel_direction(x, y, side));
            CHECK(glm::length(looked_up(bordered, side, {d})[0] - glm::vec3(atlas(x, y))) < 1e-5f);
        }
}

namespace {

// A grid whose probes are constant in all directions.
struct Constant {
    Grid grid;
    Image4 irradiance, moments;

    Constant(glm::ivec3 count, const std::function<glm::vec3(glm::vec3)>& e, const std::function<glm::vec2(glm::vec3)>& m) {
        grid.count = count, grid.origin = {-1, 2, 0.5f}, grid.spacing = {1, 0.5f, 2};
        const glm::ivec2 a = grid.atlas_size(8), b = grid.atlas_size(16);
        irradiance = Image4(a.x, a.y), moments = Image4(b.x, b.y);
        const auto fill = [&](Image4& image, int side, const auto& value) {
            for (int y = 0; y < image.height; ++y)
                for (int x = 0; x < image.width; ++x) {
                    const int tx = x / (side + 2), z = y / (side + 2);
                    image(x, y) = value(grid.origin + glm::vec3(tx % count.x, tx / count.x, z) * grid.spacing);
                }
        };
        fill(irradiance, 8, [&](glm::vec3 p) { return glm::vec4(e(p), 0); });
        fill(moments, 16, [&](glm::vec3 p) { return glm::vec4(m(p), 0, 0); });
    }
    glm::vec4 at(glm::vec3 x, glm::vec3 n, const std::function<void(Weighing&)>& set = {}) const {
        const Image4 position(1, 1, glm::vec4(x, 0)), normal(1, 1, glm::vec4(n, 0));
        SampleInputs in;
        in.grid = grid, in.position = &position, in.normal = &normal, in.view = &normal;
        in.irradiance = &irradiance, in.moments = &moments;
        if (set) set(in.weighing);
        Image4 out;
        run(stage<SampleKernel>(), data_of(in), {}, out);
        return out(0, 0);
    }
};

constexpr auto unhidden = [](Weighing& w) { w.visibility = w.wrapped = false; };

}  // namespace

TEST_CASE("ddgi.sample: equal probes give what they hold, whatever their weights; far apart, between, outside", "[ddgi][analytic]") {
    const Constant same({3, 2, 2}, [](glm::vec3) { return glm::vec3(0.5f, 3, 70); }, [](glm::vec3) { return glm::vec2(0.3f, 0.1f); });
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 x(6 * draw(i, 1) - 3, 4 * draw(i, 2), 6 * draw(i, 3) - 2), n = random_direction(i, 4);
        for (const bool root : {false, true}) {
            const glm::vec4 e = same.at(x, n, [&](Weighing& w) { w.root = root, w.normal_bias = 0.1f, w.scale = 2; });
            CHECK(e.x == Approx(1).epsilon(1e-5));
            CHECK(e.y == Approx(6).epsilon(1e-5));
            CHECK(e.z == Approx(140).epsilon(1e-5));
        }
    }
    CHECK(same.at({0, 2, 1}, {0, 0, 0}) == glm::vec4(0));
}

TEST_CASE("ddgi.sample: between equally weighed probes irradiance is trilinear, and constant beyond the grid", "[ddgi][analytic]") {
    const auto linear = [](glm::vec3 p) { return glm::vec3(10 + p.x, 10 + 3 * p.y, 10 - p.z + 0.5f * p.x); };
    const Constant grid({3, 2, 2}, linear, [](glm::vec3) { return glm::vec2(1e3f, 1e6f); });
    const glm::vec3 low = grid.grid.origin, high = low + glm::vec3(2, 1, 1) * grid.grid.spacing;
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 x(8 * draw(i, 1) - 4, 4 * draw(i, 2), 8 * draw(i, 3) - 3);
        const glm::vec3 e(grid.at(x, {0, 1, 0}, unhidden)), expected = linear(glm::clamp(x, low, high));
        CHECK(glm::length(e - expected) < 2e-5f);
        // Probes that see to a kilometre hide nothing either.
        CHECK(glm::length(glm::vec3(grid.at(x, {0, 1, 0}, [](Weighing& w) { w.wrapped = false; })) - expected) < 2e-5f);
    }
}

TEST_CASE("ddgi.sample: the weights as they are written", "[ddgi][analytic]") {
    // Two probes at x = -1 and 0 that hold 1 and 0: irradiance is the share of the first one's weight.
    const glm::vec2 moments(0.2f, 0.05f);
    const auto first = [](glm::vec3 p) { return glm::vec3(p.x < -0.5f ? 1.0f : 0.0f); };
    const Constant pair({2, 1, 1}, first, [&](glm::vec3) { return moments; });
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 x(-1 + draw(i, 1), 2 + 0.2f * draw(i, 2), 0.5f + 0.2f * draw(i, 3)), n = random_direction(i, 4);
        const double nb = 0.05, crush = 0.2;
        double weights[2];
        for (int k = 0; k < 2; ++k) {
            const glm::dvec3 p(k - 1.0, 2, 0.5), d = p - glm::dvec3(x);
            const double wrapped = (1 + glm::dot(glm::dvec3(n), glm::normalize(d))) / 2;
            const double r = glm::length(glm::dvec3(x) + nb * glm::dvec3(n) - p);
            const double variance = std::fabs(double(moments.x) * double(moments.x) - double(moments.y)), behind = r - double(moments.x);
            const double cheb = variance / (variance + behind * behind);
            double w = (wrapped * wrapped + 0.2) * (behind <= 0 ? 1 : cheb * cheb * cheb);
            if (w < crush) w = w * w * w / (crush * crush);
            weights[k] = w * (k == 0 ? 1 - (double(x.x) + 1) : double(x.x) + 1);
        }
        const glm::vec4 e = pair.at(x, n, [&](Weighing& w) { w.normal_bias = float(nb); });
        CHECK(e.x == Approx(weights[0] / (weights[0] + weights[1])).epsilon(2e-4).margin(1e-6));
        CHECK(e.w == Approx(weights[0] + weights[1]).epsilon(2e-4).margin(1e-9));
    }
}

TEST_CASE("ddgi.sample: a viewer's eye, or the direction to it", "[ddgi]") {
    const auto first = [](glm::vec3 p) { return glm::vec3(p.x < -0.5f ? 1.0f : 0.0f); };
    const Constant pair({2, 1, 1}, first, [](glm::vec3) { return glm::vec2(0.45f, 0.25f); });
    const glm::vec3 x(-0.4f, 2.1f, 0.6f), eye(1, 2, 3);
    const Image4 position(1, 1, glm::vec4(x, 0)), normal(1, 1, glm::vec4(0, 1, 0, 0)), view(1, 1, glm::vec4(glm::normalize(eye - x), 0));
    SampleInputs in;
    in.grid = pair.grid, in.position = &position, in.normal = &normal, in.eye = eye;
    in.irradiance = &pair.irradiance, in.moments = &pair.moments;
    in.weighing.view_bias = 0.2f;
    Image4 by_eye, by_view, unbiased;
    run(stage<SampleKernel>(), data_of(in), {}, by_eye);
    in.view = &view;
    run(stage<SampleKernel>(), data_of(in), {}, by_view);
    in.weighing.view_bias = 0;
    run(stage<SampleKernel>(), data_of(in), {}, unbiased);
    CHECK(by_eye(0, 0).x == Approx(by_view(0, 0).x).epsilon(1e-6));
    CHECK(std::fabs(by_eye(0, 0).x - unbiased(0, 0).x) > 1e-3f);
}

TEST_CASE("ddgi: stages refuse what they cannot serve", "[ddgi][refusals]") {
    using Catch::Matchers::Contains;
    const Buffer<glm::vec4> directions = probes::relight_directions(8);
    const Image4 hits(8, 2), other(7, 2), atlas(20, 10);
    BlendInputs in;
    in.directions = &directions, in.hits = &other, in.previous = &atlas, in.columns = 2;
    CHECK_THROWS_WITH(data_of(in), Contains("7 rays for 8 directions"));
    in.hits = &hits, in.sharpness = 0;
    CHECK_THROWS_WITH(stage<BlendKernel>().bind(data_of(in)), Contains("sharpness"));
    in.sharpness = 1, in.hysteresis = std::nanf("");
    CHECK_THROWS_WITH(stage<BlendKernel>().bind(data_of(in)), Contains("hysteresis"));
    const Constant one({1, 1, 1}, [](glm::vec3) { return glm::vec3(1); }, [](glm::vec3) { return glm::vec2(1); });
    const Image4 point(1, 1);
    SampleInputs sample;
    sample.grid = one.grid, sample.position = &point, sample.normal = &point, sample.irradiance = &one.moments, sample.moments = &one.moments;
    CHECK_THROWS_WITH(stage<SampleKernel>().bind(data_of(sample)), Contains("\"irradiance\" is 18 x 18: expected 10 x 10"));
    sample.irradiance = &one.irradiance, sample.grid.spacing.y = 0;
    CHECK_THROWS_WITH(stage<SampleKernel>().bind(data_of(sample)), Contains("spacing"));
}
