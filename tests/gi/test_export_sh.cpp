// Probes in the coefficients of engines: each form is read by the engine's own formula, in the engine's axes.
#include <catch2/catch.hpp>

#include "core/error.h"
#include "core/sh.h"
#include "gi/probes/probe_radiance.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

constexpr double pi = 3.141592653589793;

// Radiance of degree 2 and what a surface gets of it: L(d) = a + b . d + (k . d)^2, E(n) = pi a + 2 pi/3 b . n +
// pi/3 + pi/6 P_2(k . n), since (k . d)^2 = 1/3 + 2/3 P_2(k . d) and clamped cosines scale degree 2 by pi/4.
struct Sky {
    double a = 0;
    glm::dvec3 b{0}, k{0};
    double radiance(const glm::dvec3& d) const { return a + glm::dot(b, d) + glm::dot(k, d) * glm::dot(k, d); }
    double irradiance(const glm::dvec3& n) const {
        const double squared = glm::dot(k, k), kn = glm::dot(k, n);
        return pi * a + 2 * pi / 3 * glm::dot(b, n) + pi / 3 * squared + pi / 6 * (1.5 * kn * kn - 0.5 * squared);
    }
    Radiance9 coefficients() const {
        const auto c = sh::project([&](const glm::dvec3& d) { return glm::dvec3(1, 2, 0.5) * radiance(d); }, 2);
        Radiance9 r;
        for (std::size_t i = 0; i < r.size(); ++i) r[i] = c[i];
        return r;
    }
};

const std::vector<Sky> skies = {{2, {0, 0, 0}, {0, 0, 0}},           // E = 2 pi
                                {1, {0.4, -0.3, 0.7}, {0, 0, 0}},
                                {0, {0, 0, 0}, {0.6, 0, 0.8}},
                                {0.5, {0.2, 0.5, -0.1}, {1, -2, 0.5}}};
const std::vector<glm::dvec3> normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.6, -0.64, 0.48}, {-0.36, 0.48, 0.8}};

// Unity's shaders: unity_SHAr = (c3, c1, c2, c0 - c6), SHBr = (c4, c5, 3 c6, c7), SHC = c8; irradiance / pi.
double by_unity(const std::vector<double>& c, const glm::dvec3& n) {
    return c[3] * n.x + c[1] * n.y + c[2] * n.z + (c[0] - c[6]) + c[4] * n.x * n.y + c[5] * n.y * n.z + 3 * c[6] * n.z * n.z +
           c[7] * n.z * n.x + c[8] * (n.x * n.x - n.y * n.y);
}

// Unreal's SHBasisFunction3 and its factors of a diffuse transfer by band, pi, 2 pi / 3 and pi / 4.
double by_unreal(const std::vector<double>& c, const glm::dvec3& n) {
    return pi * c[0] * 0.282095 + 2 * pi / 3 * 0.488603 * (-c[1] * n.y + c[2] * n.z - c[3] * n.x) +
           pi / 4 * (1.092548 * (c[4] * n.x * n.y - c[5] * n.y * n.z - c[7] * n.x * n.z) +
                     0.315392 * c[6] * (3 * n.z * n.z - 1) + 0.546274 * c[8] * (n.x * n.x - n.y * n.y));
}

// three.js, SphericalHarmonics3.getIrradianceAt.
double by_threejs(const std::vector<double>& c, const glm::dvec3& n) {
    return c[0] * 0.886227 + 2 * 0.511664 * (c[1] * n.y + c[2] * n.z + c[3] * n.x) +
           2 * 0.429043 * (c[4] * n.x * n.y + c[5] * n.y * n.z + c[7] * n.x * n.z) + c[6] * (0.743125 * n.z * n.z - 0.247708) +
           c[8] * 0.429043 * (n.x * n.x - n.y * n.y);
}

double by_l1(const std::vector<double>& c, const glm::dvec3& n) {
    return pi * c[0] * 0.282095 + 2 * pi / 3 * 0.488603 * (c[1] * n.y + c[2] * n.z + c[3] * n.x);
}

// Hazel: I(n) = R0 + 2 R1 . n, of irradiance / pi.
double by_geomerics(const std::vector<double>& c, const glm::dvec3& n) {
    return c[0] + 2 * (c[1] * n.x + c[2] * n.y + c[3] * n.z);
}

// Irradiance of a channel as the engine computes it for a normal of the scene.
double read(ShOrder order, const Radiance9& radiance, const glm::dvec3& normal, int channel) {
    std::vector<double> c;
    for (const glm::dvec3& rgb : exported_sh(order, radiance)) c.push_back(rgb[channel]);
    REQUIRE(int(c.size()) == sh_form(order).coefficients);
    const glm::dvec3 n = sh_form(order).to_engine * normal;
    switch (order) {
        case ShOrder::unity: return pi * by_unity(c, n);
        case ShOrder::unreal: return by_unreal(c, n);
        case ShOrder::threejs: return by_threejs(c, n);
        case ShOrder::l1: return by_l1(c, n);
        case ShOrder::geomerics: return pi * by_geomerics(c, n);
    }
    return 0;
}

}  // namespace

TEST_CASE("export-sh: every engine's formula gives the irradiance of the sky", "[probes][export][analytic]") {
    const double scale[] = {1, 2, 0.5};
    for (const Sky& sky : skies)
        for (int order = 0; order < int(sh_order_names().size()); ++order) {
            const ShForm& form = sh_form(ShOrder(order));
            if (form.coefficients == 4 && sky.k != glm::dvec3(0)) continue;
            for (const glm::dvec3& n : normals)
                for (int c = 0; c < 3; ++c) {
                    CAPTURE(form.name, sky.a, n.x, n.y, n.z, c);
                    // The engines' constants have six digits.
                    CHECK(read(ShOrder(order), sky.coefficients(), n, c) == Approx(scale[c] * sky.irradiance(n)).epsilon(4e-6).margin(4e-6));
                }
        }
}

TEST_CASE("export-sh: L1 is the sky's first two degrees", "[probes][export][analytic]") {
    // Degree 2 of (k . d)^2 is left out, its mean 1/3 stays; antipodal differences of irradiance are all in R1 (Hazel).
    const Sky sky = skies[3];
    for (const ShOrder order : {ShOrder::l1, ShOrder::geomerics})
        for (const glm::dvec3& n : normals) {
            const double mean = pi * (sky.a + glm::dot(sky.k, sky.k) / 3);
            CHECK(read(order, sky.coefficients(), n, 0) == Approx(mean + 2 * pi / 3 * glm::dot(sky.b, n)).epsilon(4e-6));
            const double difference = read(order, sky.coefficients(), n, 0) - read(order, sky.coefficients(), -n, 0);
            CHECK(difference == Approx(sky.irradiance(n) - sky.irradiance(-n)).epsilon(4e-6).margin(4e-6));
        }
}

TEST_CASE("export-sh: axes and lengths", "[probes][export]") {
    // What lies ahead (-z), above and to the right in the scene lies ahead, above and to the right in the engine.
    const auto same = [](const glm::dvec3& a, const glm::dvec3& b) { return a == b; };
    CHECK(same(exported_position(ShOrder::unity, {0, 0, -2}), {0, 0, 2}));
    CHECK(same(exported_position(ShOrder::unity, {3, 1, 0}), {3, 1, 0}));
    CHECK(same(exported_position(ShOrder::unreal, {0, 0, -2}), {200, 0, 0}));
    CHECK(same(exported_position(ShOrder::unreal, {3, 0, 0}), {0, 300, 0}));
    CHECK(same(exported_position(ShOrder::unreal, {0, 1, 0}), {0, 0, 100}));
    for (const ShOrder order : {ShOrder::threejs, ShOrder::l1, ShOrder::geomerics}) CHECK(same(exported_position(order, {1, 2, 3}), {1, 2, 3}));
    CHECK(glm::determinant(sh_form(ShOrder::unity).to_engine) == -1);
    CHECK(glm::determinant(sh_form(ShOrder::unreal).to_engine) == -1);
    CHECK(sh_order_names() == std::vector<std::string>{"unity", "unreal", "threejs", "l1", "geomerics"});
}

TEST_CASE("export-sh: in a furnace every probe sees M / (1 - rho) / pi from everywhere", "[probes][export][analytic][furnace]") {
    Scene scene = test::empty_room();
    for (Material& m : scene.materials) m.emission = glm::vec3(3, 1, 0), m.reflectance = glm::vec3(0.5f);
    BakeParams params = test::small();
    params.receivers_per_m2 = 5;
    BakeGraph graph(scene, params);
    test::run_all(graph);
    const ProbeRadiance seen = probe_radiance(graph.bake(), scene, {});
    REQUIRE(seen.radiance.size() == graph.bake().placement.probes.size());
    CHECK(seen.rounds > 5);
    for (const Radiance9& r : seen.radiance)
        for (int c = 0; c < 3; ++c) {
            const double radiance = (c == 0 ? 6 : c == 1 ? 2 : 0) / pi;
            // A room without furniture is uniform to 1e-5 (test_probes_furnace.cpp), and light rests at 1e-5 of the mean.
            CHECK(r[0][c] == Approx(std::sqrt(4 * pi) * radiance).epsilon(5e-5).margin(1e-12));
            for (std::size_t i = 1; i < r.size(); ++i) CHECK(std::fabs(r[i][c]) <= 5e-5 * 6);
        }
    // And its irradiance, as Unity has it.
    CHECK(read(ShOrder::unity, seen.radiance[0], {0.6, -0.64, 0.48}, 0) == Approx(6).epsilon(2e-4));
}

TEST_CASE("export-sh: light that a lamp sends is seen as what it lights", "[probes][export]") {
    // Reflectance 0 leaves nothing; 0.5 more below the lamp, which shines down, than above.
    Scene scene = test::empty_room();
    Light lamp;
    lamp.position = {0, 1.5f, 0}, lamp.direction = {0, -1, 0}, lamp.intensity = glm::vec3(10);
    scene.lights = {lamp};
    for (Material& m : scene.materials) m.reflectance = glm::vec3(0.5f, 0, 0.25f);
    BakeParams params = test::small();
    params.receivers_per_m2 = 5;
    BakeGraph graph(scene, params);
    test::run_all(graph);
    for (const Radiance9& r : probe_radiance(graph.bake(), scene, {}).radiance) {
        CHECK(r[0].x > 2 * r[0].z);  // the first bounce alone is twice as bright
        CHECK(r[0].z > 0);
        CHECK(r[0].y == 0);
        CHECK(r[1].x < 0);  // Y1-1 is y
    }
}

TEST_CASE("export-sh: a bake of degree 1 and surfaces that give more than they get are refused", "[probes][export][robustness]") {
    Scene scene = test::empty_room();
    for (Material& m : scene.materials) m.emission = glm::vec3(1), m.reflectance = glm::vec3(1);
    BakeParams params = test::small();
    params.receivers_per_m2 = 3;
    BakeGraph graph(scene, params);
    test::run_all(graph);
    CHECK_THROWS_WITH(probe_radiance(graph.bake(), scene, {}), Catch::Contains("light does not come to rest in 300 rounds"));
    params.degree = 1;
    BakeGraph low(scene, params);
    test::run_all(low);
    CHECK_THROWS_WITH(probe_radiance(low.bake(), scene, {}), Catch::Contains("probes.degree = 1: the coefficients of engines are of degree 2"));
}
