// Maps from uniform numbers to directions and triangles, against core/sequences.h and core/host_math.h.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/sequences.h"
#include "gi/reference/environment.h"
#include "shade_probe.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

constexpr float below_one = 1 - 0x1p-24f;
const float corners[] = {0, 0x1p-24f, 0.25f, 0.5f, 0.75f, below_one};

double distance(const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b); }

}  // namespace

TEST_CASE("warp: sines and cosines are good to 1.5e-7, exact at quarter turns", "[reference]") {
    double worst = 0, worst_length = 0;
    for (int i = 0; i <= 1 << 18; ++i) {
        const float turn = float(i) * 0x1p-18f;
        const vec2<float> p = on_circle(turn);
        const double angle = 2 * host::pi * double(turn);
        worst = std::max({worst, std::abs(p.x - host::cos(angle)), std::abs(p.y - host::sin(angle))});
        worst_length = std::max(worst_length, std::abs(double(p.x) * p.x + double(p.y) * p.y - 1));
    }
    REQUIRE(worst <= 1.5e-7);
    REQUIRE(worst_length <= 2.5e-7);
    REQUIRE(on_circle(0.0f) == vec2<float>(1, 0));
    REQUIRE(on_circle(0.25f) == vec2<float>(0, 1));
    REQUIRE(on_circle(0.5f) == vec2<float>(-1, 0));
    REQUIRE(on_circle(0.75f) == vec2<float>(0, -1));
    // The polynomial's own error, without the rounding of floats.
    double worst_polynomial = 0;
    for (int i = -1000; i <= 1000; ++i) {
        const vec2<double> p = eighth_turn(i / 1000.0);
        const double angle = host::pi / 4 * (i / 1000.0);
        const double error = std::max(std::abs(p.x - host::cos(angle)), std::abs(p.y - host::sin(angle)));
        worst_polynomial = std::max(worst_polynomial, error);
    }
    REQUIRE(worst_polynomial <= 2.8e-8);
}

TEST_CASE("warp: a basis is orthonormal and right-handed, whichever way the normal looks", "[reference]") {
    std::vector<glm::vec3> normals{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int i = 0; i < 10000; ++i) {
        glm::dvec3 n = hashed_direction(i, 0);
        if (i % 2) n = glm::normalize(glm::dvec3(n.x * 1e-4, n.y * 1e-4, n.z));
        normals.push_back(n);
    }
    for (const glm::vec3& n : normals) {
        const Basis<float> b = basis_of(n);
        CAPTURE(n.x, n.y, n.z);
        const glm::dvec3 t = b.tangent, s = b.bitangent, m = n;
        REQUIRE(std::abs(glm::dot(t, t) - 1) <= 6e-7);
        REQUIRE(std::abs(glm::dot(s, s) - 1) <= 6e-7);
        REQUIRE(std::abs(glm::dot(t, s)) <= 3e-7);
        REQUIRE(std::abs(glm::dot(t, m)) <= 3e-7);
        REQUIRE(std::abs(glm::dot(s, m)) <= 3e-7);
        REQUIRE(distance(glm::cross(t, s), m) <= 6e-7);
        REQUIRE(to_world(b, vec3<float>(0, 0, 1)) == n);
    }
}

TEST_CASE("warp: the cosine hemisphere is Shirley's disc, raised", "[reference]") {
    auto check = [](float u1, float u2) {
        const vec3<float> d = cosine_hemisphere(u1, u2);
        const glm::dvec2 p = sample_disc_concentric({u1, u2});
        CAPTURE(u1, u2, d.x, d.y, d.z);
        REQUIRE(std::abs(d.x - p.x) <= 1.5e-7);
        REQUIRE(std::abs(d.y - p.y) <= 1.5e-7);
        REQUIRE(std::abs(double(d.z) * d.z - (1 - p.x * p.x - p.y * p.y)) <= 1.5e-7);
        REQUIRE(d.z >= 0);
        // And back.
        const glm::dvec2 back = inverse_disc_concentric({d.x, d.y});
        const double radius = std::sqrt(p.x * p.x + p.y * p.y);
        if (radius > 1e-6 && radius < 1 - 1e-6) REQUIRE(glm::length(back - glm::dvec2(u1, u2)) <= 1e-6);
    };
    for (const float u1 : corners)
        for (const float u2 : corners) check(u1, u2);
    for (int i = 0; i < 5000; ++i) check(hashed(i, 0), hashed(i, 1));
    REQUIRE(cosine_hemisphere(0.5f, 0.5f) == vec3<float>(0, 0, 1));
}

TEST_CASE("warp: a power of the cosine keeps its shape in floats, up to exponents of 1e6", "[reference]") {
    for (const float exponent : {0.0f, 0.5f, 1.0f, 2.0f, 50.0f, 1e3f, 1e6f}) {
        auto check = [&](float u1, float u2) {
            const vec3<float> d = cosine_power(u1, u2, exponent);
            // 1 - cos(theta) = 1 - e^v; near 0 by its series, since the difference would cancel.
            const double v = host::log(1 - double(u1)) / (exponent + 1.0);
            const double versine = v > -1e-3 ? -v * (1 + v / 2 * (1 + v / 3 * (1 + v / 4))) : 1 - host::exp(v);
            const double sine = std::sqrt(versine * (2 - versine)), angle = 2 * host::pi * double(u2);
            CAPTURE(exponent, u1, u2, d.x, d.y, d.z, versine);
            // Relative to the sine, which is 1e-3 in the narrowest lobe.
            REQUIRE(std::abs(d.x - sine * host::cos(angle)) <= 4e-7 * sine);
            REQUIRE(std::abs(d.y - sine * host::sin(angle)) <= 4e-7 * sine);
            REQUIRE(std::abs(d.z - (1 - versine)) <= 2e-6 * (1 - versine));
            REQUIRE(distance(d, sample_cosine_power({u1, u2}, exponent)) <= 5e-7);
        };
        for (const float u1 : corners)
            for (const float u2 : corners) check(u1, u2);
        for (int i = 0; i < 1000; ++i) check(hashed(i, 0), hashed(i, 1));
        const vec3<double> d = cosine_power(0.3, 0.7, double(exponent));
        REQUIRE(distance(d, sample_cosine_power({0.3, 0.7}, exponent)) <= 1e-7);
    }
}

TEST_CASE("warp: the density of a power of the cosine is that of core/sequences.h", "[reference]") {
    for (const float exponent : {0.0f, 1.0f, 50.0f, 1e3f}) {
        for (const float cosine : {1.0f, 0.999f, 0.9f, 0.5f, 1e-3f, 0.0f, -0.0f, -0.5f, -1.0f}) {
            CAPTURE(exponent, cosine);
            const double expected = cosine > 0 ? pdf_cosine_power({0, 0, cosine}, exponent) : 0;
            const double got = plumb::reference::pdf_cosine_power(cosine, exponent);
            REQUIRE(got == Approx(expected).epsilon(1e-6).margin(1e-37));
        }
    }
}

TEST_CASE("warp: barycentrics are uniform in area", "[reference]") {
    for (const float u1 : corners) {
        for (const float u2 : corners) {
            const vec2<float> l = uniform_triangle(u1, u2);
            CAPTURE(u1, u2, l.x, l.y);
            REQUIRE((l.x >= 0 && l.y >= 0 && l.x + l.y <= 1));
        }
    }
    // The determinant of the derivative is the triangle's area, 1/2, everywhere; both halves are linear.
    const double h = 0x1p-10;
    for (const glm::dvec2 u : {glm::dvec2(0.75, 0.25), glm::dvec2(0.25, 0.75), glm::dvec2(0.5, 0.125)}) {
        const vec2<double> l = uniform_triangle(u.x, u.y);
        const vec2<double> a = uniform_triangle(u.x + h, u.y) - l, b = uniform_triangle(u.x, u.y + h) - l;
        REQUIRE(std::abs((a.x * b.y - a.y * b.x) / (h * h)) == 0.5);
    }
    // Moments of the uniform density 2: l1 -> 1/3, l1^2 -> 1/6, l1 l2 -> 1/12.
    const int n = 512;
    double sum = 0, square = 0, product = 0;
    for (int i = 0; i < n * n; ++i) {
        const vec2<double> l = uniform_triangle((i % n + 0.5) / n, (i / n + 0.5) / n);
        sum += l.x, square += l.x * l.x, product += l.x * l.y;
    }
    REQUIRE(sum / (n * n) == Approx(1 / 3.0).epsilon(1e-5));
    REQUIRE(square / (n * n) == Approx(1 / 6.0).epsilon(1e-4));
    REQUIRE(product / (n * n) == Approx(1 / 12.0).epsilon(1e-4));
}

TEST_CASE("shading: every instruction set computes the same bits", "[reference][isa]") {
    // Draws inputs of all kinds: any directions, extreme numbers, lobes that are missing in whole packets.
    const int count = 8192;
    std::vector<float> in(count * shade_inputs);
    for (int i = 0; i < count; ++i) {
        float* row = &in[i * shade_inputs];
        for (int k = 0; k < shade_inputs; ++k) row[k] = hashed(i, k);
        for (int k = 0; k < 3; ++k)
            if (row[k] < 0.2f) row[k] = corners[int(row[k] * 30)];
        row[3] = i % 5 == 0 ? 1e6f : i % 7 == 0 ? 0 : float(host::exp2(10 * double(row[3])));
        for (int k = 4; k < 13; k += 3) {
            const glm::vec3 d = hashed_direction(i, 30 + k);
            row[k] = d.x, row[k + 1] = d.y, row[k + 2] = d.z;
        }
        if (i % 3 == 0) row[4] = row[5] = 0, row[6] = -1;
        for (int lobe = 0; lobe < 3; ++lobe)
            if (((i / 16) >> lobe) % 2) row[13 + 3 * lobe] = row[14 + 3 * lobe] = row[15 + 3 * lobe] = 0;
    }
    Environment environment;
    environment.radiance = {1, 2, 3};
    environment.map = Image4(13, 7);
    for (int i = 0; i < 91; ++i) environment.map.texels[i] = glm::vec4(i % 4 ? hashed(i, 0) : 0);
    const EnvironmentTable t = environment_table(environment);

    auto run = [&](Isa isa, const EnvironmentTable& table) {
        std::vector<float> out(count * shade_outputs, -1);
        const ShadeProbe probe{environment_args(table), count, in.data(), out.data()};
        dispatch(isa, [&](auto set) { probe_shading<set()>(probe); });
        return out;
    };
    environment.filter = Filter::bilinear;
    const EnvironmentTable interpolated = environment_table(environment);
    for (const EnvironmentTable* table : {&t, &interpolated}) {
        const std::vector<float> expected = run(Isa::scalar, *table);
        for (const Isa isa : supported_isas()) {
            const std::vector<float> got = run(isa, *table);
            for (std::size_t i = 0; i < got.size(); ++i) {
                if (std::memcmp(&got[i], &expected[i], 4) == 0) continue;
                CAPTURE(i / shade_outputs, i % shade_outputs, got[i], expected[i]);
                REQUIRE(std::memcmp(&got[i], &expected[i], 4) == 0);
            }
            REQUIRE(got.back() != -1);
        }
    }
}
