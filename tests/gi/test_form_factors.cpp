// Form factors in closed form against quadratures of cos cos / (pi r^2), which know none of them.
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>

#include "core/host_math.h"
#include "gi/reference/form_factors.h"

using namespace plumb::reference;
using plumb::host::pi;

namespace {

// From a patch at the origin to a disc that looks down from (aside, distance, 0): rings and sectors of equal width,
// which for the angle converges faster than any power.
double patch_quadrature(const glm::dvec3& normal, double radius, double distance, double aside) {
    const int rings = 2000, sectors = 400;
    double sum = 0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            const double r = radius * (i + 0.5) / rings, a = 2 * pi * (j + 0.5) / sectors;
            const glm::dvec3 to(aside + r * std::cos(a), distance, r * std::sin(a));
            const double d2 = glm::dot(to, to);
            sum += std::fmax(glm::dot(normal, to), 0) * distance / (pi * d2 * d2) * r;
        }
    return sum * radius / rings * 2 * pi / sectors;
}

// Points of a rectangle's sides by the midpoint rule, in four dimensions.
template <class F>
double mean4(int n, F f) {
    double sum = 0;
    for (int i = 0; i < n * n * n * n; ++i)
        sum += f((i % n + 0.5) / n, (i / n % n + 0.5) / n, (i / n / n % n + 0.5) / n, (i / n / n / n + 0.5) / n);
    return sum / (double(n) * n * n * n);
}

}  // namespace

TEST_CASE("form factors: rectangles, C-11 and C-14", "[reference][analytic]") {
    // verification.md 3.
    CHECK(opposed_rectangles(1, 1, 1) == Approx(0.199824895698387).margin(1e-15).epsilon(0));
    CHECK(perpendicular_rectangles(1, 1, 1) == Approx(0.200043776075403).margin(1e-15).epsilon(0));
    for (const double a : {0.5, 1.0, 2.0})
        for (const double b : {0.7, 1.5}) {
            CAPTURE(a, b);
            const double opposed = mean4(24, [&](double s, double t, double u, double v) {
                const double x = a * (s - u), z = b * (t - v), d2 = x * x + z * z + 1;
                return a * b / (pi * d2 * d2);
            });
            CHECK(opposed_rectangles(a, b, 1) == Approx(opposed).epsilon(1e-3));
            // Of z only the difference counts, with density 2 (1 - z); the density grows without bound towards the
            // shared edge, and points lie closer there, by a cube.
            const double right = mean4(40, [&](double s, double t, double u, double) {
                const double x = a * s * s * s, y = b * t * t * t, z = u * u * u, d2 = x * x + y * y + z * z;
                return 27 * s * s * t * t * u * u * 2 * (1 - z) * b * x * y / (pi * d2 * d2);
            });
            CHECK(perpendicular_rectangles(1, a, b) == Approx(right).epsilon(0.005));
            CHECK(a * perpendicular_rectangles(1, a, b) ==
                  Approx(b * perpendicular_rectangles(1, b, a)).epsilon(1e-12));
        }
    // From the floor of a room a x b x c to its ceiling and four walls: 1.
    const double a = 0.4, b = 1.7, c = 0.9;
    CHECK(opposed_rectangles(a, b, c) + 2 * perpendicular_rectangles(a, b, c) + 2 * perpendicular_rectangles(b, a, c) ==
          Approx(1).epsilon(1e-13));
}

TEST_CASE("form factors: from a patch to a disc, B-12, B-13, B-14 and tilted", "[reference][analytic]") {
    for (const double radius : {0.3, 1.0, 2.5})
        for (const double distance : {0.5, 1.0, 3.0}) {
            CAPTURE(radius, distance);
            CHECK(patch_to_disc(radius, distance) ==
                  Approx(patch_quadrature({0, 1, 0}, radius, distance, 0)).epsilon(1e-5));
            CHECK(patch_to_disc_aside(radius, distance, 0) == Approx(patch_to_disc(radius, distance)).epsilon(1e-14));
            for (const double aside : {0.2, 1.0, 4.0})
                CHECK(patch_to_disc_aside(radius, distance, aside) ==
                      Approx(patch_quadrature({0, 1, 0}, radius, distance, aside)).epsilon(1e-5));
            CHECK(upright_patch_to_disc(radius, distance, radius + 0.5) ==
                  Approx(patch_quadrature({1, 0, 0}, radius, distance, radius + 0.5)).epsilon(1e-5));
            for (const double angle : {0.0, 0.4, 1.0, 1.4, pi / 2, 1.8, 2.2, 2.8, 3.1})
                CHECK(tilted_patch_to_disc(radius, distance, angle) ==
                      Approx(patch_quadrature({std::sin(angle), std::cos(angle), 0}, radius, distance, 0))
                          .epsilon(2e-4)
                          .margin(2e-6));
        }
    // At a right angle: (alpha - sin alpha cos alpha) / pi of a cone of half angle alpha. Both parts meet.
    CHECK(tilted_patch_to_disc(1, 1, pi / 2) == Approx((pi / 4 - 0.5) / pi).epsilon(1e-14));
    CHECK(tilted_patch_to_disc(1, 1, pi / 4 - 1e-9) == Approx(tilted_patch_to_disc(1, 1, pi / 4 + 1e-9)).epsilon(1e-7));
}

TEST_CASE("form factors: discs and a sphere on one axis, C-41 and C-125", "[reference][analytic]") {
    for (const double from : {0.2, 1.0, 3.0})
        for (const double to : {0.5, 2.0})
            for (const double distance : {0.3, 1.0, 5.0}) {
                CAPTURE(from, to, distance);
                // The mean of B-13 over the first disc, which the case above holds against a quadrature.
                double mean = 0;
                const int n = 20000;
                for (int i = 0; i < n; ++i)
                    mean += patch_to_disc_aside(to, distance, from * std::sqrt((i + 0.5) / n)) / n;
                CHECK(coaxial_discs(from, to, distance) == Approx(mean).epsilon(1e-6));
                CHECK(from * from * coaxial_discs(from, to, distance) ==
                      Approx(to * to * coaxial_discs(to, from, distance)).epsilon(1e-12));
            }
    // From the disc to the sphere, by the patch's factor to a sphere, R^2 h / (h^2 + s^2)^(3/2), and reciprocity.
    for (const double radius : {0.1, 0.5})
        for (const double disc : {0.4, 2.0})
            for (const double distance : {0.6, 3.0}) {
                double sum = 0;
                const int n = 20000;
                for (int i = 0; i < n; ++i) {
                    const double s = disc * (i + 0.5) / n, d2 = distance * distance + s * s;
                    sum += radius * radius * distance / (d2 * std::sqrt(d2)) * 2 * pi * s * disc / n;
                }
                CHECK(sphere_to_coaxial_disc(disc, distance) == Approx(sum / (4 * pi * radius * radius)).epsilon(1e-6));
            }
}
