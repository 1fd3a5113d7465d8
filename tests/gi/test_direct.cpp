// Direct light and hard shadows against closed forms.
#include <array>
#include <catch2/catch.hpp>

#include "core/host_math.h"
#include "gi/direct/direct.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

glm::vec4 irradiance_at(const Light& light, glm::vec3 x, glm::vec3 n, float visibility = 1) {
    const Points point(x, n);
    const std::vector<Light> lights{light};
    const Buffer<float> visible{visibility};
    Image4 e;
    direct::run(direct::DirectParams{}, direct::DirectInputs{&point.position, &point.normal, &lights, &visible}, {}, e);
    return e(0, 0);
}

Light isotropic(glm::vec3 position, float intensity) {
    Light light;
    light.type = LightType::point;
    light.position = position;
    light.intensity = glm::vec3(intensity);
    return light;
}

// A spot at the origin that looks along -z at an occluder of depth 1 covering x < 0, before a wall at depth 2.
raster::Rsm half_occluded(int size) {
    raster::Rsm map = empty_map(size);
    map.view.forward = {0, 0, -1};
    map.view.view_to_clip = glm::dmat4(0);
    map.view.view_to_clip[0][0] = 1;
    map.view.view_to_clip[1][1] = -1;
    map.view.view_to_clip[3][2] = 1;
    map.view.view_to_clip[2][3] = -1;
    map.texel_scale = 2.0 / size;
    map.position = Image4(size, size, glm::vec4(0, 0, 0, 2));
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size / 2; ++x) map.position(x, y).w = 1;
    return map;
}

// One comparison of depths, whatever the default is.
const direct::ShadowParams by_depth{.mode = direct::ShadowMode::hard, .test = direct::ShadowTest::depth};

float visibility_at(const raster::Rsm& map, glm::vec3 x, glm::vec3 n, direct::ShadowParams params = by_depth) {
    const Points point(x, n);
    float visibility = -1;
    direct::run(params, {&point.position, &point.normal, {&map, 1}}, {}, &visibility);
    return visibility;
}

}  // namespace

TEST_CASE("direct: isotropic lamp over a floor, E = P / (4 pi) h / (h^2 + r^2)^(3/2)", "[direct][analytic]") {
    const double power = 10, h = 1.5;
    const Light lamp = isotropic({0, float(h), 0}, float(power / (4 * host::pi)));
    for (double r : {0.0, 0.5, 1.0, 3.0, 20.0}) {
        const double d2 = h * h + r * r;
        const double exact = power / (4 * host::pi) * h / (d2 * std::sqrt(d2));
        CHECK(irradiance_at(lamp, {float(r), 0, 0}, {0, 1, 0}).x == Approx(exact).epsilon(1e-6).margin(0));
    }
}

TEST_CASE("direct: a spot is full inside its inner cone, nothing outside the outer, half in between", "[direct][analytic]") {
    Light spot;
    spot.position = {0, 1, 0};
    spot.cone_inner_deg = 30, spot.cone_outer_deg = 50;
    spot.intensity = {4, 2, 1};
    // smoothstep is 1/2 where the cosine is half way between the two.
    const double cosine = (host::cos(30 * host::pi / 180) + host::cos(50 * host::pi / 180)) / 2;
    const double r = std::sqrt(1 / (cosine * cosine) - 1);
    const glm::vec4 half = irradiance_at(spot, {float(r), 0, 0}, {0, 1, 0});
    CHECK(half.x == Approx(4 * 0.5 * cosine * cosine * cosine).epsilon(1e-5));
    CHECK(half.y == Approx(half.x / 2).epsilon(1e-6));
    CHECK(irradiance_at(spot, {0, 0, 0}, {0, 1, 0}).x == Approx(4).epsilon(1e-6));
    CHECK(irradiance_at(spot, {2, 0, 0}, {0, 1, 0}).x == 0);
    CHECK(irradiance_at(spot, {0, 2, 0}, {0, -1, 0}).x == 0);
}

TEST_CASE("direct: a directional light gives E_perp cos theta; shadow and horizon give nothing", "[direct][analytic]") {
    Light sun;
    sun.type = LightType::directional;
    sun.direction = {0.6f, -0.8f, 0};
    sun.intensity = {100, 50, 25};
    CHECK(irradiance_at(sun, {5, 5, 5}, {0, 1, 0}).x == Approx(80).epsilon(1e-6));
    CHECK(irradiance_at(sun, {5, 5, 5}, {0, 1, 0}, 0).x == 0);
    CHECK(irradiance_at(sun, {5, 5, 5}, {0, -1, 0}).x == 0);
}

TEST_CASE("direct: a point on the lamp stays finite", "[direct][extreme]") {
    for (float d : {0.0f, 1e-30f, 1e-20f, 1e20f}) {
        const glm::vec4 e = irradiance_at(isotropic({0, d, 0}, 1), {0, 0, 0}, {0, 1, 0});
        CAPTURE(d, e.x);
        CHECK(std::isfinite(e.x));
    }
    // Far below any scene's scale the law of squares still holds.
    CHECK(irradiance_at(isotropic({0, 1e-10f, 0}, 1), {0, 0, 0}, {0, 1, 0}).x == Approx(1e20).epsilon(1e-5));
}

TEST_CASE("shadow: lit before the occluder, shadowed behind it, lit beside it", "[shadow][VRSM Algorithm 4]") {
    const raster::Rsm map = half_occluded(64);
    CHECK(visibility_at(map, {-0.5f, 0.1f, -1}, {0, 0, 1}) == 1);
    CHECK(visibility_at(map, {-0.5f, 0.1f, -0.5f}, {0, 0, 1}) == 1);
    CHECK(visibility_at(map, {-0.5f, 0.1f, -1.5f}, {0, 0, 1}) == 0);
    CHECK(visibility_at(map, {0.5f, 0.1f, -1.5f}, {0, 0, 1}) == 1);
    CHECK(visibility_at(map, {0.5f, 0.1f, -2}, {0, 0, 1}) == 1);
    CHECK(visibility_at(map, {-9, 0.1f, -1.5f}, {0, 0, 1}) == 1);   // outside the map
    CHECK(visibility_at(map, {-0.5f, 0.1f, 1.5f}, {0, 0, 1}) == 1);  // behind the light
}

TEST_CASE("shadow: bias decides at its value", "[shadow][VRSM Algorithm 4]") {
    const raster::Rsm map = half_occluded(64);
    direct::ShadowParams params = by_depth;
    params.slope_bias = 0;
    params.bias = 0.1f;
    CHECK(visibility_at(map, {-0.5f, 0.1f, -1.09f}, {0, 0, 1}, params) == 1);
    CHECK(visibility_at(map, {-0.5f, 0.1f, -1.11f}, {0, 0, 1}, params) == 0);
}

TEST_CASE("shadow: a plane does not shadow itself, whatever its slope", "[shadow][acne]") {
    // A plane through (0, 0, -2) whose depth changes by `slope` a metre sideways, seen by a map of 64 texels a side.
    const int size = 64;
    for (double slope : {0.0, 0.5, 1.0, 4.0}) {
        raster::Rsm map = half_occluded(size);
        auto depth = [&](double u, double v) { return 2 / (1 + slope * u + 0.3 * v); };  // along the ray (u, v, -1)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const double u = (2 * x + 1.0) / size - 1, v = 1 - (2 * y + 1.0) / size;
                const double d = depth(u, v);
                map.position(x, y).w = d > 0 ? float(d) : 0;
            }
        // Its normal, in the space where the light looks along -z: 2 = -z + slope x + 0.3 y.
        const glm::vec3 n = normalize3<float>(glm::vec3(float(-slope), -0.3f, 1));
        int shadowed_with = 0, shadowed_without = 0, points = 0;
        for (double v = -0.9; v < 0.9; v += 0.0137)
            for (double u = -0.9; u < 0.9; u += 0.0131) {
                const double d = depth(u, v);
                if (d <= 0 || d > 20) continue;
                const glm::vec3 x(float(u * d), float(v * d), float(-d));
                direct::ShadowParams exact = by_depth, none = by_depth;
                exact.bias = none.bias = 1e-6f;
                none.slope_bias = 0;
                exact.max_slope = 1e6f;
                shadowed_with += visibility_at(map, x, n, exact) == 0;
                shadowed_without += visibility_at(map, x, n, none) == 0;
                ++points;
            }
        CAPTURE(slope, points);
        CHECK(shadowed_with == 0);
        CHECK(shadowed_without > points / 10);  // the bias is what prevents it
    }
}

TEST_CASE("shadow: a plane does not shadow itself under a directional light either", "[shadow][acne]") {
    // A map of 64 x 64 texels over [-1, 1]^2, looking along -z at the plane z = -2 - slope x - 0.3 y.
    const int size = 64;
    for (double slope : {0.5, 1.0, 4.0}) {
        raster::Rsm map = plane_map(size, [](double, double) { return 0.0; });
        map.view.forward = {0, 0, -1};
        map.texel_scale = 2.0 / size;
        map.position = Image4(size, size);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const double u = (2 * x + 1.0) / size - 1, v = 1 - (2 * y + 1.0) / size;
                map.position(x, y).w = float(10 + slope * u + 0.3 * v);
            }
        const glm::vec3 n = normalize3<float>(glm::vec3(float(slope), 0.3f, 1));
        direct::ShadowParams with = by_depth, without = by_depth;
        with.bias = without.bias = 1e-5f;
        without.slope_bias = 0;
        int shadowed_with = 0, shadowed_without = 0, points = 0;
        for (double v = -0.9; v < 0.9; v += 0.0137)
            for (double u = -0.9; u < 0.9; u += 0.0131, ++points) {
                const glm::vec3 x(float(u), float(v), float(-10 - slope * u - 0.3 * v));
                shadowed_with += visibility_at(map, x, n, with) == 0;
                shadowed_without += visibility_at(map, x, n, without) == 0;
            }
        CAPTURE(slope, points);
        CHECK(shadowed_with == 0);
        CHECK(shadowed_without > points / 10);
    }
}

TEST_CASE("shadow: max_slope ends the bias of surfaces at a grazing angle", "[shadow]") {
    // At (0.5, 0.1, -2.5) before the map's depth of 2 the footprint is 2.5 * 2 / 64 m; a normal across the ray has no
    // bound on its slope, so the bias is max_slope footprints: 0.078 m times 4 or 16.
    raster::Rsm map = half_occluded(64);
    const glm::vec3 x(0.5f, 0.1f, -2.5f), across = normalize3<float>(glm::vec3(2.5f, 0, 0.5f));
    direct::ShadowParams params = by_depth;
    params.bias = 0;
    params.max_slope = 4;
    CHECK(visibility_at(map, x, across, params) == 0);
    params.max_slope = 16;
    CHECK(visibility_at(map, x, across, params) == 1);
}

TEST_CASE("shadow: where the map holds nothing, a point is lit", "[shadow]") {
    raster::Rsm map = half_occluded(8);
    for (glm::vec4& texel : map.position.texels) texel.w = 0;
    CHECK(visibility_at(map, {-0.5f, 0.1f, -1.5f}, {0, 0, 1}) == 1);
}

TEST_CASE("shadow density: behind a straight edge it is the share of the kernel beyond it", "[shadow][VRSM Algorithm 4]") {
    // The occluder covers the columns below 32. A point behind it that projects into column c has the kernel's columns
    // c - k/2 .. c - k/2 + k - 1, of which those from 32 on are lit. Printed, the shadowed ones are counted.
    const raster::Rsm map = half_occluded(64);
    for (int kernel : {1, 2, 3, 4, 5, 16})
        for (int column = 20; column < 44; ++column) {
            const glm::vec3 x(1.5f * (float(2 * column + 1) / 64 - 1), 0.1f, -1.5f);
            direct::ShadowParams params = by_depth;
            params.mode = direct::ShadowMode::density;
            params.kernel = kernel;
            const int beyond = column - kernel / 2 + kernel - 32;
            const float lit = float(std::min(std::max(beyond, 0), kernel)) / float(kernel);
            CAPTURE(kernel, column);
            CHECK(visibility_at(map, x, {0, 0, 1}, params) == lit);
            params.variant = direct::ShadowVariant::published;
            CHECK(visibility_at(map, x, {0, 0, 1}, params) == Approx(1 - lit).margin(1e-6));
            direct::ShadowParams hard = by_depth;
            params.variant = direct::ShadowVariant::corrected;
            if (kernel == 1) CHECK(visibility_at(map, x, {0, 0, 1}, params) == visibility_at(map, x, {0, 0, 1}, hard));
        }
}

// One texel of the map stands in the way: which of the kernel's offsets reach it? VRSM Algorithm 4 has i and j from
// -kernelSize/2 to kernelSize/2 - 1, both included; of an odd size, ours are centred.
TEST_CASE("shadow density: a kernel of 4 looks at -2 to 1, one of 5 at -2 to 2", "[shadow][VRSM Algorithm 4]") {
    const int size = 64, cx = 32, cy = 20;
    const glm::vec3 x(1.5f * (float(2 * cx + 1) / size - 1), 1.5f * (1 - float(2 * cy + 1) / size), -1.5f);
    for (const auto& [kernel, first, last] : {std::array{1, 0, 0}, {2, -1, 0}, {3, -1, 1}, {4, -2, 1}, {5, -2, 2}, {6, -3, 2}})
        for (int j = -4; j <= 4; ++j)
            for (int i = -4; i <= 4; ++i) {
                raster::Rsm map = half_occluded(size);
                for (glm::vec4& texel : map.position.texels) texel.w = 2;
                map.position(cx + i, cy + j).w = 1;
                direct::ShadowParams params = by_depth;
                params.mode = direct::ShadowMode::density;
                params.kernel = kernel;
                const bool reached = i >= first && i <= last && j >= first && j <= last;
                const int n = kernel * kernel;
                CAPTURE(kernel, i, j);
                CHECK(visibility_at(map, x, {0, 0, 1}, params) == float(n - reached) / float(n));
                params.variant = direct::ShadowVariant::published;
                CHECK(visibility_at(map, x, {0, 0, 1}, params) == float(reached) / float(n));
            }
}

// z_map - zBias >= z_p with z = -depth: a point counts from the bias behind the map's depth of 1 on.
TEST_CASE("shadow: printed, the bias decides at its value too", "[shadow][VRSM Algorithm 4]") {
    const raster::Rsm map = half_occluded(64);
    direct::ShadowParams params = by_depth;
    params.variant = direct::ShadowVariant::published;
    params.bias = 0.1f;
    for (auto mode : {direct::ShadowMode::hard, direct::ShadowMode::density}) {
        params.mode = mode;
        CHECK(visibility_at(map, {-0.5f, 0.1f, -0.95f}, {0, 0, 1}, params) == 0);
        CHECK(visibility_at(map, {-0.5f, 0.1f, -1.05f}, {0, 0, 1}, params) == 0);
        CHECK(visibility_at(map, {-0.5f, 0.1f, -1.09f}, {0, 0, 1}, params) == 0);
        CHECK(visibility_at(map, {-0.5f, 0.1f, -1.11f}, {0, 0, 1}, params) == 1);
    }
}

TEST_CASE("shadow density: beyond the map nothing blocks; printed, nothing is counted", "[shadow][VRSM Algorithm 4]") {
    // All of the map is occluded; in its corner texel a kernel of four reaches two rows and columns beyond it, so that 4
    // of 16 texels lie inside.
    raster::Rsm map = half_occluded(64);
    for (glm::vec4& texel : map.position.texels) texel.w = 1;
    const float edge = 1.5f * (1.0f / 64 - 1);
    direct::ShadowParams params = by_depth;
    params.mode = direct::ShadowMode::density;
    CHECK(visibility_at(map, {0, 0.1f, -1.5f}, {0, 0, 1}, params) == 0);
    CHECK(visibility_at(map, {edge, -edge, -1.5f}, {0, 0, 1}, params) == 12 / 16.0f);
    params.variant = direct::ShadowVariant::published;
    CHECK(visibility_at(map, {0, 0.1f, -1.5f}, {0, 0, 1}, params) == 1);
    CHECK(visibility_at(map, {edge, -edge, -1.5f}, {0, 0, 1}, params) == 4 / 16.0f);
    for (glm::vec4& texel : map.position.texels) texel.w = 0;
    params.variant = direct::ShadowVariant::corrected;
    CHECK(visibility_at(map, {0, 0.1f, -1.5f}, {0, 0, 1}, params) == 1);
}

TEST_CASE("shadow density: the bias grows with the kernel, so that a tilted plane stays lit", "[shadow][acne]") {
    const int size = 64;
    const double slope = 1;
    raster::Rsm map = half_occluded(size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) map.position(x, y).w = float(2 / (1 + slope * ((2 * x + 1.0) / size - 1)));
    const glm::vec3 n = normalize3<float>(glm::vec3(float(-slope), 0, 1));
    for (int kernel : {2, 4, 7}) {
        direct::ShadowParams params = by_depth;
        params.mode = direct::ShadowMode::density;
        params.kernel = kernel;
        int partial = 0;
        for (double u = -0.2; u < 0.8; u += 0.0131) {
            const double d = 2 / (1 + slope * u);
            const glm::vec3 x(float(u * d), 0.01f, float(-d));
            CAPTURE(kernel, u);
            CHECK(visibility_at(map, x, n, params) == 1);
            direct::ShadowParams constant = params;
            constant.slope_bias = 0;
            partial += visibility_at(map, x, n, constant) < 1;
        }
        CHECK(partial > 30);  // the bias is what prevents it
    }
}

TEST_CASE("shadow density: its parameters have ranges, and its texels are explained", "[shadow][explain]") {
    const raster::Rsm map = half_occluded(64);
    const Points point({-0.02f, 0.1f, -1.5f}, {0, 0, 1});
    direct::ShadowParams params = by_depth;
    params.kernel = 0;
    float v;
    CHECK_THROWS_WITH(direct::run(params, {&point.position, &point.normal, {&map, 1}}, {}, &v), Catch::Contains("kernel"));
    params.kernel = 3;
    params.mode = direct::ShadowMode::density;
    const auto taps = direct::explain(params, {&point.position, &point.normal, {&map, 1}}, {0, 0});
    int texels = 0;
    for (const TapValue& t : taps) texels += t.name == "texel";
    CHECK(texels == 9);
    direct::run(params, {&point.position, &point.normal, {&map, 1}}, {}, &v);
    CHECK(taps.back().value.at(0) == v);
}
