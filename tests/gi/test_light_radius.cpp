// Lights that end at their radius, ISR (16): irradiance by hand, the flux of their maps, and the path tracer against
// both.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/direct/direct.h"
#include "gi/reference/closed_form_scenes.h"
#include "raster/light_view.h"
#include "raster/rsm.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

Light lamp_at(glm::vec3 position, float radius, float intensity = 3) {
    Light light;
    light.name = "lamp";
    light.type = LightType::point;
    light.position = position;
    light.intensity = glm::vec3(intensity);
    light.radius = radius;
    return light;
}

Light spot_at(glm::vec3 position, float radius) {
    Light light = lamp_at(position, radius);
    light.type = LightType::spot;
    light.cone_inner_deg = 20, light.cone_outer_deg = 50;
    return light;
}

double irradiance_at(const Light& light, glm::vec3 x, glm::vec3 n) {
    const Points point(x, n);
    const std::vector<Light> lights{light};
    const Buffer<float> visible{1.0f};
    Image4 e;
    direct::run(direct::DirectParams{}, direct::DirectInputs{&point.position, &point.normal, &lights, &visible}, {}, e);
    return e(0, 0).x;
}

// Power that a spot at height h sends to the floor below it, by quadrature over the radius r of rings:
// integral of 2 pi r I falloff(h / d) max(0, 1 - d^2 / R^2) h / d, d^2 = h^2 + r^2.
double power_on_floor(const Light& light, double h) {
    const double inner = std::cos(light.cone_inner_deg * host::pi / 180),
                 outer = std::cos(light.cone_outer_deg * host::pi / 180);
    const double R2 = double(light.radius) * light.radius, end = std::sqrt(std::max(R2 - h * h, 0.0));
    const int rings = 200000;
    double sum = 0;
    for (int i = 0; i < rings; ++i) {
        const double r = (i + 0.5) / rings * end, d2 = h * h + r * r, cosine = h / std::sqrt(d2);
        const double t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
        sum += 2 * host::pi * r * (end / rings) * t * t * (3 - 2 * t) * (1 - d2 / R2) * cosine;
    }
    return light.intensity.x * sum;
}

Scene floor_below(const Light& light) {
    Scene scene;
    reference::add_rectangle(scene, reference::grey(0.5), {-8, 0, -8}, {8, 0, 8});
    scene.lights = {light};
    return scene;
}

double flux_of(const Light& light) {
    const Scene scene = floor_below(light);
    const Geometry g = flatten(scene);
    glm::vec3 low, high;
    REQUIRE(bounds(g, low, high));
    double sum = 0;
    for (const View& view : raster::light_views(light, low, high)) {
        raster::Rsm map;
        raster::draw_rsm(g, raster::prepare(scene, g), light, view, raster::Layout::fp32, {}, map);
        for (const glm::vec4& flux : map.flux.texels) sum += flux.x;
    }
    return sum;
}

}  // namespace

TEST_CASE("light radius: irradiance is I (1 - (d/r)^2) cos theta, and nothing from the radius on",
          "[direct][ISR (16)][analytic]") {
    const Light lamp = lamp_at({0, 0, 0}, 2);
    // Straight below: 3 (1 - d^2 / 4).
    CHECK(irradiance_at(lamp, {0, -1, 0}, {0, 1, 0}) == Approx(2.25).epsilon(1e-6));
    CHECK(irradiance_at(lamp, {0, -0.5f, 0}, {0, 1, 0}) == Approx(2.8125).epsilon(1e-6));
    // It does not grow without bound towards the lamp: I at its place, where no direction leads to it.
    CHECK(irradiance_at(lamp, {0, -1e-6f, 0}, {0, 1, 0}) == Approx(3).epsilon(1e-6));
    CHECK(irradiance_at(lamp, {0, 0, 0}, {0, 1, 0}) == 0);
    CHECK(irradiance_at(lamp, {0, -2, 0}, {0, 1, 0}) == 0);
    CHECK(irradiance_at(lamp, {0, -2.5f, 0}, {0, 1, 0}) == 0);
    CHECK(irradiance_at(lamp, {0, -1e30f, 0}, {0, 1, 0}) == 0);  // whose square is no finite float
    // Beside the foot: d^2 = 1 + 1, cos theta = 1 / sqrt 2.
    CHECK(irradiance_at(lamp, {1, -1, 0}, {0, 1, 0}) == Approx(3 * 0.5 * std::sqrt(0.5)).epsilon(1e-6));
    // A spot's falloff stays: half way between its cosines 1/2 of it is left.
    const Light spot = spot_at({0, 0, 0}, 2);
    const double middle = (std::cos(20 * host::pi / 180) + std::cos(50 * host::pi / 180)) / 2;
    const float across = float(std::sqrt(1 - middle * middle));
    CHECK(irradiance_at(spot, {across, -float(middle), 0}, {0, 1, 0}) == Approx(3 * 0.5 * 0.75 * middle).epsilon(1e-5));
    CHECK(irradiance_at(lamp_at({0, 0, 0}, 1e9f), {0, -1000, 0}, {0, 1, 0}) == Approx(3).epsilon(1e-6));
    CHECK(irradiance_at(lamp_at({0, 0, 0}, 1e-6f), {0, -5e-7f, 0}, {0, 1, 0}) == Approx(2.25).epsilon(1e-5));
}

TEST_CASE("light radius: the flux of a map is what the floor receives, times its reflectance", "[rsm][ISR (16)][analytic]") {
    for (float radius : {1.7f, 3.0f, 40.0f}) {
        Light spot = spot_at({0, 1.5f, 0}, radius);
        const double want = 0.5 * power_on_floor(spot, 1.5);
        double last = 0;
        for (int size : {64, 128, 256}) {
            spot.rsm_size = size;
            const double got = flux_of(spot), error = std::abs(got / want - 1);
            CAPTURE(radius, size, got, want, last);
            // The midpoint rule on a function with a bend at the border: no worse than first order.
            CHECK(error < 1.0 / size);
            last = error;
        }
        CHECK(last < 5e-4);
        Light sphere = spot;
        sphere.type = LightType::point;
        // Without a cone: 2 pi I integral of r (1 - d^2/R^2) h / d = 2 pi I h [(d - d^3 / (3 R^2))] from h to R, where the
        // floor reaches so far.
        if (radius > 8) continue;
        const double h = 1.5, R = radius;
        const double all = 2 * host::pi * 3 * h * ((R - R / 3) - (h - h * h * h / (3 * R * R)));
        CHECK(flux_of(sphere) == Approx(0.5 * all).epsilon(2e-3));
    }
}

TEST_CASE("light radius: the path tracer's direct light is the direct stage's", "[reference][ISR (16)]") {
    for (const bool spot : {false, true}) {
        const Light light = spot ? spot_at({0.2f, 1.5f, 0.1f}, 2.5f) : lamp_at({0.2f, 1.5f, 0.1f}, 2.5f);
        Light other = lamp_at({-1, 1, 0}, 0);  // of 1/d^2: two kinds of lamps in one table
        Scene scene = floor_below(light);
        scene.lights.push_back(other);
        for (const glm::vec3 x : {glm::vec3(0, 0, 0), glm::vec3(1, 0, 0.5f), glm::vec3(1.9f, 0, 1.4f)}) {
            const double want = irradiance_at(light, x, {0, 1, 0}) + irradiance_at(other, x, {0, 1, 0});
            const reference::ReceiverPoints p = reference::repeated(glm::dvec3(x), {0, 1, 0}, 4096);
            reference::PathParams params;
            params.mode = reference::Mode::direct, params.samples = 1024;
            const auto e = reference::trace_irradiance(params, *reference::prepare(scene, Rays::native), {&p.position, &p.normal}, 5,
                                            {});
            double mean = 0, error2 = 0;
            for (std::size_t i = 0; i < e.mean.size(); ++i)
                mean += e.mean.texels[i].x, error2 += double(e.error.texels[i].x) * e.error.texels[i].x;
            mean /= double(e.mean.size());
            const double error = std::sqrt(error2) / double(e.mean.size());
            CAPTURE(spot, x.x, mean, want, error);
            CHECK(error < 0.002 * want);
            CHECK(std::abs(mean - want) < 4 * error + 1e-5 * want);
        }
    }
}

TEST_CASE("light radius: 0 leaves every bit; what cannot be is refused by name", "[direct][ISR (16)]") {
    const raster::LightArgs plain = raster::light_args(lamp_at({0, 0, 0}, 0));
    CHECK((plain.radius2 == 0 && plain.inverse_radius2 == 0));
    for (float d2 : {0.0f, 1.0f, 1e30f, std::numeric_limits<float>::infinity()})
        CHECK(raster::light_intensity(plain, 0.5f, d2) == glm::vec3(3));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (float radius : {-1.0f, 1e-7f, 1e10f, nan, std::numeric_limits<float>::infinity()})
        CHECK_THROWS_WITH(raster::light_args(lamp_at({0, 0, 0}, radius)), Catch::Contains("light \"lamp\": radius = "));
    Light sun = lamp_at({0, 0, 0}, 2);
    sun.type = LightType::directional;
    CHECK_THROWS_WITH(raster::light_args(sun), Catch::Contains("a directional light has no distance"));
}
