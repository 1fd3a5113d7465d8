#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "core/sh.h"

using namespace plumb;
using sh::index;
using sh::max_count;

namespace {

const double pi = host::pi;

// An even spread of directions that no symmetry prefers.
glm::dvec3 direction(int i) { return sample_sphere(r2(std::uint64_t(i))); }

sh::Coefficients<double> some_coefficients() {
    sh::Coefficients<double> c;
    for (int i = 0; i < max_count; ++i) c[i] = 2 * unit_float<double>(pcg(i)) - 1;
    return c;
}

// A rotation by `angle` about a unit axis (Rodrigues).
glm::dmat3 rotation(const glm::dvec3& axis, double angle) {
    const double c = host::cos(angle), s = host::sin(angle);
    const glm::dmat3 cross(0, axis.z, -axis.y, -axis.z, 0, axis.x, axis.y, -axis.x, 0);
    return glm::dmat3(1) * c + cross * s + glm::outerProduct(axis, axis) * (1 - c);
}

}  // namespace

TEST_CASE("sh: the 64 functions are orthonormal", "[sh]") {
    std::vector<double> product(max_count * max_count);
    for (const sh::Node& node : sh::quadrature()) {
        const sh::Values y = sh::basis(node.direction);
        for (int i = 0; i < max_count; ++i)
            for (int j = 0; j < max_count; ++j) product[i * max_count + j] += node.weight * y[i] * y[j];
    }
    double worst = 0;
    for (int i = 0; i < max_count; ++i)
        for (int j = 0; j < max_count; ++j) worst = std::fmax(worst, std::fabs(product[i * max_count + j] - (i == j)));
    CAPTURE(worst);
    CHECK(worst < 1e-13);
    CHECK(worst > 0);
}

TEST_CASE("sh: functions to degree 14 begin with the 64, sum up to 1 / 4 pi a function, and integrate to 0", "[sh][analytic]") {
    for (int i = 0; i < 50; ++i) {
        const glm::dvec3 d = direction(i);
        const std::vector<double> y = sh::long_basis(d, sh::highest_degree);
        REQUIRE(y.size() == 225);
        const sh::Values first = sh::basis(d);
        for (int j = 0; j < max_count; ++j) REQUIRE(y[std::size_t(j)] == first[std::size_t(j)]);  // to the bit
        REQUIRE(sh::long_basis(d, 9) == std::vector<double>(y.begin(), y.begin() + 100));
        // The addition theorem at one direction: sum over m of Y_lm^2 = (2 l + 1) / 4 pi.
        for (int l = 0; l <= sh::highest_degree; ++l) {
            double squares = 0;
            for (int m = -l; m <= l; ++m) squares += y[std::size_t(index(l, m))] * y[std::size_t(index(l, m))];
            CHECK(squares == Approx((2 * l + 1) / (4 * pi)).epsilon(1e-13));
        }
    }
    // The quadrature is exact up to degree 14.
    std::vector<double> integrals(225, 0.0);
    for (const sh::Node& node : sh::quadrature()) {
        const std::vector<double> y = sh::long_basis(node.direction, 14);
        for (std::size_t j = 0; j < y.size(); ++j) integrals[j] += node.weight * y[j];
    }
    CHECK(integrals[0] == Approx(std::sqrt(4 * pi)).epsilon(1e-14));
    for (std::size_t j = 1; j < integrals.size(); ++j) CHECK(std::fabs(integrals[j]) < 1e-13);
    CHECK_THROWS_AS(sh::long_basis({0, 0, 1}, 15), InputError);
    CHECK_THROWS_AS(sh::long_basis({0, 0, 1}, -1), InputError);
}

TEST_CASE("sh: the quadrature integrates monomials exactly", "[sh]") {
    // Integral of x^2a y^2b z^2c over the sphere: 2 G(a+1/2) G(b+1/2) G(c+1/2) / G(a+b+c+3/2).
    double one = 0, z14 = 0, mixed = 0, odd = 0;
    for (const sh::Node& n : sh::quadrature()) {
        const glm::dvec3 d = n.direction;
        one += n.weight, z14 += n.weight * std::pow(d.z, 14);
        mixed += n.weight * std::pow(d.x, 4) * d.y * d.y * std::pow(d.z, 6), odd += n.weight * d.x * std::pow(d.z, 6);
    }
    CHECK(one == Approx(4 * pi).epsilon(1e-14));
    CHECK(z14 == Approx(4 * pi / 15).epsilon(1e-14));
    const double expected = 2 * std::tgamma(2.5) * std::tgamma(1.5) * std::tgamma(3.5) / std::tgamma(7.5);
    CHECK(mixed == Approx(expected).epsilon(1e-13));
    CHECK(std::fabs(odd) < 1e-15);
}

TEST_CASE("sh: degrees 0 to 2 are the formulas of the figure", "[sh][IPR fig. 3.4]") {
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 d = direction(i);
        const auto [x, y, z] = std::array{d.x, d.y, d.z};
        const double a = std::sqrt(3 / (4 * pi)), b = std::sqrt(15 / pi) / 2;
        const double expected[] = {std::sqrt(1 / pi) / 2,
                                   a * y,
                                   a * z,
                                   a * x,
                                   b * x * y,
                                   b * y * z,
                                   std::sqrt(5 / pi) / 4 * (2 * z * z - x * x - y * y),
                                   b * z * x,
                                   b / 2 * (x * x - y * y)};
        const sh::Values got = sh::basis(d), short_form = sh::basis(d, 2);
        for (int k = 0; k < 9; ++k) {
            REQUIRE(std::fabs(got[k] - expected[k]) < 2e-15);
            REQUIRE(short_form[k] == got[k]);
        }
        REQUIRE(short_form[9] == 0);
    }
}

TEST_CASE("sh: some functions of higher degree have their closed form", "[sh]") {
    // P_7(z) = (429 z^7 - 693 z^5 + 315 z^3 - 35 z) / 16; Y_77 ~ Re (x + i y)^7, Y_4,-3 ~ z y (3 x^2 - y^2).
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 d = direction(i);
        const auto [x, y, z] = std::array{d.x, d.y, d.z};
        const sh::Values got = sh::basis(d);
        const double p7 = (429 * std::pow(z, 7) - 693 * std::pow(z, 5) + 315 * std::pow(z, 3) - 35 * z) / 16;
        CHECK(std::fabs(got[index(7, 0)] - std::sqrt(15 / (4 * pi)) * p7) < 1e-14);
        const double re7 =
            std::pow(x, 7) - 21 * std::pow(x, 5) * y * y + 35 * x * x * x * std::pow(y, 4) - 7 * x * std::pow(y, 6);
        CHECK(std::fabs(got[index(7, 7)] - 3. / 64 * std::sqrt(715 / pi) * re7) < 1e-14);
        CHECK(std::fabs(got[index(4, -3)] - 3. / 4 * std::sqrt(35 / (2 * pi)) * y * (3 * x * x - y * y) * z) < 1e-14);
    }
}

TEST_CASE("sh: Condon and Shortley's phase turns the sign of odd m", "[sh]") {
    const glm::dvec3 d = direction(5);
    const sh::Values plain = sh::basis(d), phased = sh::basis(d, 7, sh::Phase::condon_shortley);
    for (int l = 0; l <= 7; ++l)
        for (int m = -l; m <= l; ++m) REQUIRE(phased[index(l, m)] == (m % 2 ? -1 : 1) * plain[index(l, m)]);
}

TEST_CASE("sh: the addition theorem holds", "[sh]") {
    // sum_m Y_lm(a) Y_lm(b) = (2 l + 1) / (4 pi) P_l(a.b)
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 a = direction(i), b = direction(3 * i + 1);
        const sh::Values y = sh::basis(a), v = sh::basis(b);
        const double t = glm::dot(a, b);
        double p = 1, previous = 0;
        for (int l = 0; l <= 7; ++l) {
            double sum = 0;
            for (int m = -l; m <= l; ++m) sum += y[index(l, m)] * v[index(l, m)];
            REQUIRE(std::fabs(sum - (2 * l + 1) / (4 * pi) * p) < 1e-14);
            const double next = ((2 * l + 1) * t * p - l * previous) / (l + 1);
            previous = p, p = next;
        }
    }
}

TEST_CASE("sh: projection gives back the coefficients of a function of the span", "[sh]") {
    const auto c = some_coefficients();
    const auto back = sh::project([&](glm::dvec3 d) { return sh::evaluate(c, d); });
    for (int i = 0; i < max_count; ++i) REQUIRE(std::fabs(back[i] - c[i]) < 1e-13);
    const auto colour = sh::project([&](glm::dvec3 d) { return glm::dvec3(1, d.z, d.x * d.y); }, 2);
    CHECK(colour[0].x == Approx(std::sqrt(4 * pi)).epsilon(1e-14));
    CHECK(colour[index(1, 0)].y == Approx(std::sqrt(4 * pi / 3)).epsilon(1e-14));
    CHECK(colour[index(2, -2)].z == Approx(2 * std::sqrt(pi / 15)).epsilon(1e-14));
}

TEST_CASE("sh: rotated coefficients are those of the rotated function", "[sh]") {
    const auto c = some_coefficients();
    for (auto phase : {sh::Phase::none, sh::Phase::condon_shortley})
        for (int k = 0; k < 8; ++k) {
            const glm::dmat3 r = rotation(direction(k), 0.3 + k);
            const auto rotated = sh::Rotation(r, 7, phase)(c);
            for (int i = 0; i < 100; ++i) {
                const glm::dvec3 d = direction(i);
                const double got = sh::evaluate(rotated, r * d, 7, phase), expected = sh::evaluate(c, d, 7, phase);
                REQUIRE(std::fabs(got - expected) < 1e-13);
            }
        }
}

TEST_CASE("sh: rotation matrices are orthogonal to 1e-12 and compose", "[sh]") {
    const glm::dmat3 r = rotation(direction(2), 1.1), s = rotation(direction(9), -2.3);
    const sh::Rotation first(r), second(s), both(s * r);
    double worst = 0, worst_product = 0;
    for (int l = 0; l <= 7; ++l)
        for (int i = -l; i <= l; ++i)
            for (int j = -l; j <= l; ++j) {
                double dot = 0, product = 0;
                for (int k = -l; k <= l; ++k) {
                    dot += first.at(l, i, k) * first.at(l, j, k);
                    product += second.at(l, i, k) * first.at(l, k, j);
                }
                worst = std::fmax(worst, std::fabs(dot - (i == j)));
                worst_product = std::fmax(worst_product, std::fabs(product - both.at(l, i, j)));
            }
    CAPTURE(worst, worst_product);
    CHECK(worst < 1e-12);
    CHECK(worst_product < 1e-12);
    CHECK(first.at(1, 0, 0) == Approx(r[2][2]));  // Y_10 is z
    CHECK(first.at(1, 1, -1) == Approx(r[1][0]));
}

TEST_CASE("sh: convolution with the clamped cosine turns radiance into irradiance", "[sh]") {
    const auto& a = sh::clamped_cosine();
    const double table[] = {pi, 2 * pi / 3, pi / 4, 0, -pi / 24, 0, pi / 64, 0};
    for (int l = 0; l <= 7; ++l) {
        CHECK(a[l] == table[l]);
        // A_l = 2 pi times the integral of t P_l(t) over [0, 1], by Simpson's rule, exact enough at 2000 steps.
        double sum = 0;
        const int n = 2000;
        for (int i = 0; i <= n; ++i) {
            const double t = double(i) / n;
            double p = 1, previous = 0;
            for (int k = 0; k < l; ++k) {
                const double next = ((2 * k + 1) * t * p - k * previous) / (k + 1);
                previous = p, p = next;
            }
            sum += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * t * p;
        }
        CHECK(std::fabs(2 * pi * sum / (3 * n) - a[l]) < 1e-9);
    }
}

TEST_CASE("sh: float values are the double ones, rounded; a degree beyond 7 is refused", "[sh]") {
    const glm::vec3 d(0.48f, -0.6f, 0.64f);
    const auto rounded = sh::basis(d);
    const sh::Values exact = sh::basis(glm::dvec3(d));
    for (int i = 0; i < max_count; ++i) REQUIRE(rounded[i] == float(exact[i]));
    CHECK_THROWS_WITH(sh::basis(d, 8), "spherical harmonics: degree = 8: must be 0..7");
}
