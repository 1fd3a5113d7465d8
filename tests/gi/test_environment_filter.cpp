// Interpolated maps of the environment: the lookup, what it sends, and that samples follow it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "gi/reference/environment.h"
#include "shade_probe.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

constexpr double pi = host::pi;

glm::dvec3 direction_of(double u, double v) {
    const double angle = 2 * pi * (u - 0.5), sine = host::sin(pi * v);
    return {sine * host::sin(angle), host::cos(pi * v), -sine * host::cos(angle)};
}
glm::dvec2 coordinates_of(const glm::dvec3& d) {
    return {0.5 + host::atan2(d.x, -d.z) / (2 * pi), host::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y) / pi};
}
double solid_angle(const EnvironmentTable& t, int row) {
    return 2 * pi / t.width * (host::cos(pi * row / t.height) - host::cos(pi * (row + 1) / t.height));
}

Environment mapped(int width, int height, Filter filter = Filter::bilinear) {
    Environment e;
    e.radiance = glm::vec3(1);
    e.map = Image4(width, height);
    e.filter = filter;
    return e;
}
// Any colours; half of the patches and two whole rows are black.
Environment speckled(int width, int height) {
    Environment e = mapped(width, height);
    for (int i = 0; i < width * height; ++i)
        if (i % 2 == 0 && i / width != height / 2 && i / width != height / 2 - 1)
            e.map.texels[i] = {hashed(i, 0), 2 * hashed(i, 1), 3 * hashed(i, 2), 1};
    return e;
}
Environment one_bright(int width, int height, int x, int y, Filter filter) {
    Environment e = mapped(width, height, filter);
    e.map(x, y) = glm::vec4(7);
    return e;
}

// In double, as core/scene.h says it.
double radiance_at(const EnvironmentTable& t, double u, double v, int channel) {
    const double x = u * t.width - 0.5, y = std::clamp(v * t.height - 0.5, 0.0, t.height - 1.0);
    const int column = int(std::floor(x)), row = int(std::floor(y));
    const auto texel = [&](int i, int j) {
        return double(t.radiance[4 * (std::min(j, t.height - 1) * t.width + (i + t.width) % t.width) + channel]);
    };
    const double s = x - column, r = y - row;
    return (1 - r) * ((1 - s) * texel(column, row) + s * texel(column + 1, row)) +
           r * ((1 - s) * texel(column, row + 1) + s * texel(column + 1, row + 1));
}

struct Case {
    const char* name;
    Environment environment;
};
std::vector<Case> cases() {
    return {{"speckled", speckled(16, 8)},
            {"odd", speckled(7, 5)},
            {"column", speckled(1, 6)},
            {"row", one_bright(6, 1, 2, 0, Filter::bilinear)},
            {"bright", one_bright(12, 6, 0, 2, Filter::bilinear)},
            {"bright at the pole", one_bright(12, 6, 5, 0, Filter::bilinear)},
            {"bright at the lower pole", one_bright(12, 6, 11, 5, Filter::bilinear)}};
}

// Integrates f(u, v) over the sphere: the midpoint rule in u and in v, where it has the weight sin.
template <class F>
double integral(const EnvironmentTable& t, int cut, const F& f) {
    const int columns = t.width * cut * (t.width < 4 ? 16 : 1), rows = t.height * cut;
    double sum = 0;
    for (int j = 0; j < rows; ++j) {
        const double v = (j + 0.5) / rows;
        double row = 0;
        for (int i = 0; i < columns; ++i) row += f((i + 0.5) / columns, v);
        sum += row * host::sin(pi * v);
    }
    return sum * (2 * pi / columns) * (pi / rows);
}

}  // namespace

TEST_CASE("environment filter: the lookup is bilinear, round the back and up to the poles", "[reference]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = environment_args(t);
        double worst = 0;
        for (int i = 0; i < 20000; ++i) {
            const vec3<float> d = hashed_direction(i, 0);
            const glm::dvec2 at = coordinates_of(glm::dvec3(d));
            const vec3<float> got = environment_radiance(in, d);
            for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(got[k] - radiance_at(t, at.x, at.y, k)));
        }
        // Turns are good to 1e-7, slopes at most 7 a texel.
        CHECK(worst < 7 * 2e-7 * (t.width + 2 * t.height) + 2e-6);
    }

    // The middle of a texel is the texel; half way is the mean, also from the last column to the first, at u = 0 and 1.
    const EnvironmentTable t = environment_table(speckled(16, 8));
    const EnvironmentArgs in = environment_args(t);
    const auto texel = [&](int x, int y) { return t.radiance[4 * (y * 16 + x)]; };
    const auto red = [&](double u, double v) { return environment_radiance(in, vec3<float>(direction_of(u, v))).x; };
    for (int x = 0; x < 16; ++x)
        for (int y = 0; y < 8; ++y) CHECK(red((x + 0.5) / 16, (y + 0.5) / 8) == Approx(texel(x, y)).margin(1e-5));
    for (int y = 0; y < 8; ++y) {
        const double v = (y + 0.5) / 8, seam = 0.5 * (texel(15, y) + texel(0, y));
        CHECK(red(0, v) == Approx(seam).margin(1e-5));
        CHECK(red(1 - 1e-9, v) == Approx(seam).margin(1e-5));
        CHECK(red(0.25 / 16, v) == Approx(0.25 * texel(15, y) + 0.75 * texel(0, y)).margin(1e-5));
        CHECK(red(1 - 0.25 / 16, v) == Approx(0.75 * texel(15, y) + 0.25 * texel(0, y)).margin(1e-5));
    }
    // Beyond the middles of the first and the last row a column does not change; at the poles themselves it is the seam.
    for (int x = 0; x < 16; ++x) {
        CHECK(red((x + 0.5) / 16, 0.01 / 8) == Approx(texel(x, 0)).margin(1e-4));
        CHECK(red((x + 0.5) / 16, 1 - 0.01 / 8) == Approx(texel(x, 7)).margin(1e-4));
    }
    for (const float length : {1.0f, 30.0f}) {
        CHECK(environment_radiance(in, vec3<float>(0, length, 0)).x == Approx(0.5 * (texel(15, 0) + texel(0, 0))));
        CHECK(environment_radiance(in, vec3<float>(0, -length, 0)).x == Approx(0.5 * (texel(15, 7) + texel(0, 7))));
    }
}

TEST_CASE("environment filter: a uniform map is the same in both", "[reference]") {
    for (const Filter filter : {Filter::nearest, Filter::bilinear}) {
        Environment e = mapped(16, 8, filter);
        std::fill(e.map.texels.begin(), e.map.texels.end(), glm::vec4(0.3f, 1.7f, 2.9f, 0));
        const EnvironmentTable t = environment_table(e);
        CHECK(t.bilinear == (filter == Filter::bilinear));
        CHECK(t.mean_radiance == Approx((0.3f + 1.7f + 2.9f) / 3.0).epsilon(1e-7));
        for (int i = 0; i < 1000; ++i) {
            const vec3<float> d = hashed_direction(i, 0);
            REQUIRE(environment_radiance(environment_args(t), d) == vec3<float>(0.3f, 1.7f, 2.9f));
            REQUIRE(environment_pdf(environment_args(t), d) == Approx(1 / (4 * pi)).epsilon(1e-5));
            const EnvironmentSample<float> s = sample_environment(environment_args(t), hashed(i, 0), hashed(i, 1));
            REQUIRE(s.radiance == vec3<float>(0.3f, 1.7f, 2.9f));
        }
    }
    // One radiance without a map has no texels to interpolate.
    Environment plain;
    plain.radiance = glm::vec3(3), plain.filter = Filter::bilinear;
    CHECK_FALSE(environment_table(plain).bilinear);
}

TEST_CASE("environment filter: the power of one bright texel", "[reference]") {
    // A patch sends L (2 pi / width) 2 sin a sin(h/2), a its middle's polar angle and h = pi / height; a tent
    // L (2 pi / width) (2/h) (1 - cos h) sin a, which is (2/h) sin(h/2) times that; to the pole it stays 1:
    // 1 - cos a + cos a - (sin(a + h) - sin a)/h.
    const int width = 12, height = 6;
    const double h = pi / height;
    for (int y = 0; y < height; ++y) {
        const double a = (y + 0.5) * h, column = 7 * 2 * pi / width;
        const double patch = column * 2 * host::sin(a) * host::sin(h / 2);
        const double first = std::min(a, pi - a), end = 1 - (host::sin(first + h) - host::sin(first)) / h;
        const double tent = column * (y == 0 || y == height - 1 ? end : 2 / h * (1 - host::cos(h)) * host::sin(a));
        if (y != 0 && y != height - 1) CHECK(tent / patch == Approx(2 / h * host::sin(h / 2)));
        const EnvironmentTable nearest = environment_table(one_bright(width, height, 3, y, Filter::nearest));
        const EnvironmentTable bilinear = environment_table(one_bright(width, height, 3, y, Filter::bilinear));
        CAPTURE(y);
        CHECK(nearest.mean_radiance * 4 * pi == Approx(patch).epsilon(1e-12));
        CHECK(bilinear.mean_radiance * 4 * pi == Approx(tent).epsilon(1e-12));
        CHECK(integral(bilinear, 40, [&](double u, double v) { return radiance_at(bilinear, u, v, 0); }) ==
              Approx(tent).epsilon(1e-4));
    }
}

TEST_CASE("environment filter: the mean, and the irradiance of planes by samples, are quadrature's", "[reference]") {
    const glm::dvec3 normals[] = {{0, 1, 0}, {0, -1, 0}, {0.6, 0, 0.8}, {-0.48, 0.6, -0.64}};
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = environment_args(t);
        const double mean = integral(t, 24, [&](double u, double v) {
            return (radiance_at(t, u, v, 0) + radiance_at(t, u, v, 1) + radiance_at(t, u, v, 2)) / (3 * 4 * pi);
        });
        CHECK(t.mean_radiance == Approx(mean).epsilon(1e-3));
        double got[4] = {}, both[4] = {}, largest = 0;
        const int n = 512;
        for (int i = 0; i < n * n; ++i) {
            const float u1 = (float(i % n) + hashed(i, 0)) / n, u2 = (float(i / n) + hashed(i, 1)) / n;
            const EnvironmentSample<float> s = sample_environment(in, u1, u2);
            REQUIRE(s.pdf > 0);
            const double weight = s.radiance.y / s.pdf / (n * n);
            largest = std::max(largest, double(s.radiance.y / s.pdf));
            // Beside samples over the whole sphere, weighted by the balance heuristic, as a path's two ways to the sky.
            const vec3<float> d = hashed_direction(i, 1);
            const double uniform = 1 / (4 * pi), pdf = environment_pdf(in, d);
            for (int j = 0; j < 4; ++j) {
                const double cosine = std::max(0.0, glm::dot(glm::dvec3(s.direction), normals[j]));
                got[j] += weight * cosine;
                both[j] += s.radiance.y * cosine / (s.pdf + uniform) / (n * n) +
                           environment_radiance(in, d).y * std::max(0.0, glm::dot(glm::dvec3(d), normals[j])) / (pdf + uniform) / (n * n);
            }
        }
        // Radiance over density is bounded: it is positive wherever there is radiance.
        CHECK(largest < 60 * t.mean_radiance * 4 * pi);
        for (int j = 0; j < 4; ++j) {
            const double expected = integral(t, 24, [&](double u, double v) {
                return radiance_at(t, u, v, 1) * std::max(0.0, glm::dot(direction_of(u, v), normals[j]));
            });
            CAPTURE(j);
            CHECK(got[j] == Approx(expected).epsilon(4e-3).margin(1e-3 * t.mean_radiance));
            CHECK(both[j] == Approx(expected).epsilon(1e-2).margin(4e-3 * t.mean_radiance));
        }
    }
}

TEST_CASE("environment filter: samples have the density that is told, chi-square", "[reference]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = environment_args(t);
        // A patch has 2 x 2 bins: halves of its longitudes and of its solid angle.
        std::vector<double> expected(4 * t.pdf.size()), seen(4 * t.pdf.size());
        const int n = 200000;
        double total = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            expected[i] = n * t.pdf[i / 4] * solid_angle(t, int(i / 4) / t.width) / 4;
            total += expected[i];
        }
        CHECK(total == Approx(n).epsilon(1e-6));
        for (int i = 0; i < n; ++i) {
            const EnvironmentSample<float> s = sample_environment(in, hashed(i, 2), hashed(i, 3));
            const double u = coordinates_of(glm::dvec3(s.direction)).x * t.width;
            const int x = std::clamp(int(u), 0, t.width - 1);
            // Rows by their cosines.
            int y = 0;
            while (y < t.height - 1 && s.direction.y < host::cos(pi * (y + 1) / t.height)) ++y;
            const double middle = (host::cos(pi * y / t.height) + host::cos(pi * (y + 1) / t.height)) / 2;
            ++seen[4 * std::size_t(y * t.width + x) + 2 * (s.direction.y < middle) + (u - x >= 0.5)];
        }
        double chi = 0, rest_expected = 0, rest_seen = 0;
        int bins = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            if (expected[i] < 10) {
                rest_expected += expected[i], rest_seen += seen[i];
                continue;
            }
            chi += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i], ++bins;
        }
        if (rest_expected > 10) chi += (rest_seen - rest_expected) * (rest_seen - rest_expected) / rest_expected, ++bins;
        else CHECK(rest_seen <= rest_expected + 5 * std::sqrt(rest_expected) + 10);  // rounding over a border
        CAPTURE(chi, bins);
        CHECK(bins > 3);
        CHECK(chi < bins + 5 * std::sqrt(2.0 * bins));
    }
}

TEST_CASE("environment filter: what shines is sampled, beside a texel and not in it alone", "[reference]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const EnvironmentTable t = environment_table(c.environment);
        const EnvironmentArgs in = environment_args(t);
        int shining = 0, unseen = 0;
        for (int y = 0; y < t.height; ++y)
            for (int x = 0; x < t.width; ++x)
                for (int k = 0; k < 16; ++k) {
                    // Inside of the patch, off its border.
                    const vec3<float> d(direction_of((x + 0.05 + 0.3 * (k % 4)) / t.width, (y + 0.05 + 0.3 * (k / 4)) / t.height));
                    const bool shines = environment_radiance(in, d).y > 1e-5f;
                    shining += shines, unseen += shines && !(environment_pdf(in, d) > 0);
                }
        CHECK(shining > 0);
        CHECK(unseen == 0);
    }
    // A black map is none.
    CHECK(environment_table(mapped(4, 2)).width == 0);
}
