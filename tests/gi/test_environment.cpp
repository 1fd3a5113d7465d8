// Light from infinity: its tables, its radiance in a direction and directions by its luminance.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "gi/reference/environment.h"
#include "shade_probe.h"

using namespace plumb;
using namespace plumb::reference;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = host::pi;
constexpr float below_one = 1 - 0x1p-24f;

EnvironmentArgs args_of(const EnvironmentTable& t) { return environment_args(t); }

// The direction of map coordinates (u, v), core/scene.h: u = 1/2 + atan2(x, -z)/(2 pi), v = acos(y)/pi.
glm::dvec3 direction_of(double u, double v) {
    const double angle = 2 * pi * (u - 0.5), sine = host::sin(pi * v);
    return {sine * host::sin(angle), host::cos(pi * v), -sine * host::cos(angle)};
}
glm::dvec2 coordinates_of(const glm::dvec3& d) {
    const double u = 0.5 + host::atan2(d.x, -d.z) / (2 * pi);
    return {u, host::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y) / pi};
}
double solid_angle(const EnvironmentTable& t, int row) {
    return 2 * pi / t.width * (host::cos(pi * row / t.height) - host::cos(pi * (row + 1) / t.height));
}

Environment mapped(int width, int height) {
    Environment e;
    e.radiance = {0.5f, 1, 2};
    e.map = Image4(width, height);
    return e;
}
// Any colours; some patches and a whole row are black.
Environment speckled(int width, int height) {
    Environment e = mapped(width, height);
    for (int i = 0; i < width * height; ++i)
        if (i % 5 != 2 && i / width != height / 2)
            e.map.texels[i] = {hashed(i, 0), 2 * hashed(i, 1), 3 * hashed(i, 2), 1};
    return e;
}
// A dim sky with a sun of one texel that is ten thousand times as bright.
Environment sunny(int width, int height) {
    Environment e = mapped(width, height);
    std::fill(e.map.texels.begin(), e.map.texels.end(), glm::vec4(0.1f));
    e.map(width / 3, height / 4) = glm::vec4(1e3f);
    return e;
}
Environment uniform(float radiance) {
    Environment e;
    e.radiance = glm::vec3(radiance);
    return e;
}

struct Case {
    const char* name;
    Environment environment;
};
std::vector<Case> cases() {
    return {{"uniform", uniform(3)},          {"column", speckled(1, 4)}, {"row", speckled(6, 2)},
            {"odd", speckled(7, 5)},          {"sun", sunny(64, 32)},     {"large", speckled(300, 150)},
            {"power of two", speckled(16, 8)}};
}

}  // namespace

TEST_CASE("environment: turns are those of atan2 to 1e-7", "[reference]") {
    double worst = 0;
    auto check = [&](double y, double x) {
        const double expected = host::atan2(float(y), float(x)) / (2 * pi);
        worst = std::max(worst, std::abs(turn_of(float(y), float(x)) - expected));
    };
    for (int i = 0; i < 100000; ++i) {
        const double angle = (i + 0.5) / 100000 * 2 * pi, length = host::exp2(20.0 * hashed(i, 0) - 10);
        check(length * host::sin(angle), length * host::cos(angle));
    }
    for (const double x : {-1.0, 0.0, 1.0})
        for (const double y : {-1.0, 0.0, 1.0})
            if (x != 0 || y != 0) check(y, x);
    REQUIRE(worst <= 1e-7);
    REQUIRE(turn_of(0.0f, 1.0f) == 0);
    REQUIRE(turn_of(1.0f, 0.0f) == 0.25f);
    REQUIRE(turn_of(0.0f, -1.0f) == 0.5f);
    REQUIRE(turn_of(-1.0f, 0.0f) == -0.25f);
}

TEST_CASE("environment: without a map, one radiance from everywhere", "[reference]") {
    const EnvironmentTable t = environment_table(uniform(3));
    REQUIRE(t.width == 1);
    REQUIRE(t.height == 1);
    REQUIRE(t.mean_radiance == Approx(3).epsilon(1e-14));
    REQUIRE(t.pdf[0] == float(1 / (4 * pi)));
    const EnvironmentArgs in = args_of(t);
    for (int i = 0; i < 100; ++i) {
        const vec3<float> d = hashed_direction(i, 0);
        REQUIRE(environment_radiance(in, d) == vec3<float>(3));
        REQUIRE(environment_pdf(in, d) == float(1 / (4 * pi)));
    }
}

TEST_CASE("environment: black is no environment", "[reference]") {
    Environment times_zero = speckled(4, 2), black = mapped(4, 2);
    times_zero.radiance = glm::vec3(0);
    for (const Environment& e : {uniform(0), times_zero, black}) {
        const EnvironmentTable t = environment_table(e);
        REQUIRE(t.width == 0);
        REQUIRE(t.height == 0);
        REQUIRE(t.mean_radiance == 0);
        const EnvironmentArgs in = args_of(t);
        const EnvironmentSample<float> s = sample_environment(in, 0.3f, 0.6f);
        REQUIRE(environment_radiance(in, vec3<float>(0, 1, 0)) == vec3<float>(0));
        REQUIRE(environment_pdf(in, vec3<float>(0, 1, 0)) == 0);
        REQUIRE(s.radiance == vec3<float>(0));
        REQUIRE(s.pdf == 0);
    }
}

TEST_CASE("environment: the density of the patches sums to 1 over the sphere", "[reference]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        double probability = 0, mean = 0;
        int unseen = 0, seen_in_vain = 0, off_step = 0;
        for (int i = 0; i < t.width * t.height; ++i) {
            probability += t.pdf[i] * solid_angle(t, i / t.width);
            const float* l = &t.radiance[4 * i];
            mean += (double(l[0]) + l[1] + l[2]) / 3 * solid_angle(t, i / t.width) / (4 * pi);
            unseen += l[0] + l[1] + l[2] > 0 && !(t.pdf[i] > 0);
            seen_in_vain += l[0] + l[1] + l[2] == 0 && t.pdf[i] != 0;
        }
        for (const float x : t.row_cdf) off_step += x * 0x1p24f != std::floor(x * 0x1p24f);
        for (const float x : t.column_cdf) off_step += x * 0x1p24f != std::floor(x * 0x1p24f);
        REQUIRE(probability == Approx(1).epsilon(1e-6));
        REQUIRE(t.mean_radiance == Approx(mean).epsilon(1e-10));
        REQUIRE(unseen == 0);
        REQUIRE(seen_in_vain == 0);
        REQUIRE(off_step == 0);
    }
}

TEST_CASE("environment: what shines is seen, however bright the sun", "[reference]") {
    // Shares of 1e-12, where the tables' steps are 6e-8.
    Environment e = mapped(4, 3);
    std::fill(e.map.texels.begin(), e.map.texels.end(), glm::vec4(1e-6f));
    e.map(2, 1) = glm::vec4(1e6f);
    const EnvironmentTable t = environment_table(e);
    REQUIRE(*std::min_element(t.pdf.begin(), t.pdf.end()) > 0);
}

TEST_CASE("environment: patches are chosen by luminance and solid angle", "[reference]") {
    // The density is proportional to the sum of the channels, but for the steps of the tables.
    const EnvironmentTable t = environment_table(speckled(16, 8));
    for (int i = 0; i < t.width * t.height; ++i) {
        const float* l = &t.radiance[4 * i];
        const double expected = (double(l[0]) + l[1] + l[2]) / (3 * t.mean_radiance * 4 * pi);
        REQUIRE(t.pdf[i] == Approx(expected).epsilon(1e-4).margin(1e-7));
    }
}

TEST_CASE("environment: the radiance at a patch's centre is its texel's", "[reference]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = args_of(t);
        for (int y = 0; y < t.height; ++y)
            for (int x = 0; x < t.width; ++x) {
                const vec3<float> d = direction_of((x + 0.5) / t.width, (y + 0.5) / t.height);
                glm::vec3 expected = c.environment.radiance;
                if (!c.environment.map.empty()) expected *= glm::vec3(c.environment.map(x, y));
                const float density = t.pdf[y * t.width + x];
                if (environment_radiance(in, d) == expected && environment_pdf(in, d) == density) continue;
                CAPTURE(x, y);
                REQUIRE(environment_radiance(in, d) == expected);
                REQUIRE(environment_pdf(in, d) == density);
            }
    }
    // Where things are: u = 1/2 looks along -z, u = 3/4 along +x, the top row up.
    const EnvironmentTable t = environment_table(speckled(5, 3));
    auto texel = [&](int x, int y) { return vec3<float>(t.radiance[4 * (5 * y + x)]); };
    const EnvironmentArgs in = args_of(t);
    REQUIRE(environment_radiance(in, vec3<float>(0, 0.7f, -0.7f)).x == texel(2, 0).x);
    REQUIRE(environment_radiance(in, vec3<float>(0.6f, 0.8f, 0)).x == texel(3, 0).x);
    REQUIRE(environment_radiance(in, vec3<float>(-0.6f, -0.8f, 0)).x == texel(1, 2).x);
}

TEST_CASE("environment: a sampled direction lies in the patch that was chosen", "[reference]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = args_of(t);
        const int n = 20000;
        int at_border = 0, elsewhere = 0, dark = 0, not_unit = 0;
        for (int i = 0; i < n; ++i) {
            const EnvironmentSample<float> s = sample_environment(in, hashed(i, 0), hashed(i, 1));
            not_unit += !(std::abs(glm::length(glm::dvec3(s.direction)) - 1) <= 3e-7);
            dark += !(s.pdf > 0 && s.radiance.y > 0);
            const glm::dvec2 p = coordinates_of(s.direction) * glm::dvec2(t.width, t.height);
            // A direction is rounded to 1e-7, which is more of a turn near a pole.
            const double reach = 3e-7 / std::sqrt(std::max(1e-12, 1 - double(s.direction.y) * s.direction.y));
            const glm::dvec2 away = glm::abs(p - glm::round(p));
            if (away.x <= reach * t.width || away.y <= 3e-7 * t.height)
                ++at_border;
            else
                elsewhere += environment_radiance(in, s.direction) != s.radiance ||
                             environment_pdf(in, s.direction) != s.pdf;
        }
        REQUIRE(not_unit == 0);
        REQUIRE(dark == 0);
        REQUIRE(elsewhere == 0);
        REQUIRE(at_border <= n / 200);
    }
}

TEST_CASE("environment: samples are the integral of the radiance", "[reference]") {
    // Irradiance of planes, and the mean over the sphere: the sampled estimate against a sum over the sphere, in which
    // each patch is cut into 8 x 8 of equal solid angle at least.
    const glm::dvec3 normals[] = {{0, 1, 0}, {0, -1, 0}, {0.6, 0, 0.8}, {-0.48, 0.6, -0.64}};
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = args_of(t);
        double expected[4] = {}, got[4] = {}, mean = 0;
        const int cut = t.width <= 16 ? 64 : 8, n = 512;
        for (int row = 0; row < t.height; ++row)
            for (int a = 0; a < cut; ++a) {
                const double top = host::cos(pi * row / t.height), bottom = host::cos(pi * (row + 1) / t.height);
                const double y = top + (bottom - top) * (a + 0.5) / cut;
                for (int k = 0; k < t.width * cut; ++k) {
                    const glm::dvec3 flat = direction_of((k + 0.5) / (t.width * cut), 0.5);
                    const double sine = std::sqrt(1 - y * y), l = t.radiance[4 * (row * t.width + k / cut) + 1];
                    const glm::dvec3 d(flat.x * sine, y, flat.z * sine);
                    for (int j = 0; j < 4; ++j)
                        expected[j] += l * std::max(0.0, glm::dot(d, normals[j])) * solid_angle(t, row) / (cut * cut);
                }
            }
        for (int i = 0; i < n * n; ++i) {
            const float u1 = (float(i % n) + hashed(i, 0)) / n, u2 = (float(i / n) + hashed(i, 1)) / n;
            const EnvironmentSample<float> s = sample_environment(in, u1, u2);
            const double weight = s.radiance.y / s.pdf / (n * n);
            for (int j = 0; j < 4; ++j) got[j] += weight * std::max(0.0, glm::dot(glm::dvec3(s.direction), normals[j]));
            mean += (double(s.radiance.x) + s.radiance.y + s.radiance.z) / 3 / s.pdf / (n * n) / (4 * pi);
        }
        for (int j = 0; j < 4; ++j) {
            CAPTURE(j);
            // Beside the sun, the sky gets one sample in six, and that no stratum of its own.
            REQUIRE(got[j] == Approx(expected[j]).epsilon(c.name == std::string("sun") ? 5e-3 : 3e-3));
        }
        REQUIRE(mean == Approx(t.mean_radiance).epsilon(1e-3));
    }
    // Closed form: a white upper half of radiance 1 gives a floor pi and has the mean 1/2.
    Environment half = mapped(1, 2);
    half.radiance = glm::vec3(1);
    half.map(0, 0) = glm::vec4(1);
    const EnvironmentTable t = environment_table(half);
    REQUIRE(t.mean_radiance == Approx(0.5).epsilon(1e-14));
    double irradiance = 0;
    for (int i = 0; i < 4096; ++i) {
        const EnvironmentSample<float> s = sample_environment(args_of(t), (i / 64 + 0.5f) / 64, (i % 64 + 0.5f) / 64);
        irradiance += s.radiance.y / s.pdf * std::max(0.0f, s.direction.y) / 4096;
    }
    REQUIRE(irradiance == Approx(pi).epsilon(1e-4));
}

TEST_CASE("environment: the ends of the unit interval reach either pole and no further", "[reference]") {
    for (const Case& c : cases()) {
        const EnvironmentTable t = environment_table(c.environment);
        for (const float u1 : {0.0f, 0x1p-24f, 0.5f, below_one})
            for (const float u2 : {0.0f, 0x1p-24f, 0.5f, below_one}) {
                const EnvironmentSample<float> s = sample_environment(args_of(t), u1, u2);
                CAPTURE(c.name, u1, u2);
                REQUIRE(std::abs(glm::length(glm::dvec3(s.direction)) - 1) <= 3e-7);
                REQUIRE((s.pdf > 0 && s.radiance.y > 0));
            }
    }
    const EnvironmentTable t = environment_table(uniform(1));
    REQUIRE(sample_environment(args_of(t), 0.0f, 0.5f).direction.y == Approx(1).margin(1e-6));
    REQUIRE(sample_environment(args_of(t), below_one, 0.5f).direction.y == Approx(-1).margin(1e-6));
    // A direction need not have unit length, and the poles themselves have a radiance.
    const EnvironmentTable map = environment_table(speckled(16, 8));
    for (const float y : {1.0f, -1.0f, 30.0f})
        REQUIRE(environment_radiance(args_of(map), vec3<float>(0, y, 0)).y == map.radiance[y > 0 ? 1 : 4 * 16 * 7 + 1]);
}

TEST_CASE("environment: what is no radiance is refused by its texel", "[reference]") {
    const float bad[] = {-1, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
    for (const float value : bad) {
        Environment e = speckled(4, 2);
        e.map(3, 1).y = value;
        REQUIRE_THROWS_AS(environment_table(e), InputError);
        REQUIRE_THROWS_WITH(environment_table(e), Contains("environment") && Contains("texel (3, 1)"));
    }
}
