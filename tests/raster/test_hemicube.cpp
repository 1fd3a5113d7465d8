#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "raster/hemicube.h"
#include "tests/raster/drawing.h"

namespace plumb::raster {
namespace {

using test::add_triangle;
using test::at;
using test::dot;

Geometry quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
    Geometry g;
    add_triangle(g, at(glm::vec3(a)), at(glm::vec3(b)), at(glm::vec3(c)));
    add_triangle(g, at(glm::vec3(a)), at(glm::vec3(c)), at(glm::vec3(d)));
    return g;
}

// The form factor from a small patch to what the hemicube sees.
double form_factor(const Hemicube& cube) {
    const std::vector<double> top = delta_form_factors_top(cube.size), side = delta_form_factors_side(cube.size);
    double sum = 0;
    for (int face = 0; face < hemicube_faces; ++face) {
        const Image<std::int32_t>& items = cube.faces[face].triangle;
        for (std::size_t i = 0; i < items.size(); ++i)
            if (items.texels[i] >= 0) sum += face == 0 ? top[i] : side[i];
    }
    return sum;
}

double form_factor(const Geometry& g, const glm::dvec3& eye, const glm::dvec3& normal, int size) {
    Hemicube cube;
    draw_hemicube(g, nullptr, eye, normal, 1e-4, size, {}, cube);
    return form_factor(cube);
}

}  // namespace

TEST_CASE("hemicube: delta form factors sum to one", "[raster][HEM 4.5.3][analytic]") {
    // Errors of the midpoint rule as evaluated in double: verification.md 3.
    const struct {
        int size;
        double error;
    } known[] = {{32, 5.3e-4}, {64, 1.3e-4}, {128, 3.3e-5}, {256, 8.3e-6}};
    for (const auto [size, error] : known) {
        double sum = 0;
        for (double f : delta_form_factors_top(size)) sum += f;
        for (double f : delta_form_factors_side(size)) sum += 4 * f;
        CHECK(std::fabs(sum - 1) == Approx(error).epsilon(0.03));
    }
}

TEST_CASE("hemicube: a patch opposite a square, turned by 0 to 90 degrees", "[raster][HEM 4.5.3][analytic]") {
    // dA to a centred, opposed unit square at distance 1, and the error in % of it that the sum over pixels has in exact
    // arithmetic: rms 0.267, largest 0.898 for 64 pixels; 0.0266 and 0.0977 for 256 with corners where they are, 0.0252
    // and 0.0808 with corners moved to 1/256 pixel, as here.
    const double truth = 0.239456470460774;
    const struct {
        int size;
        double rms, largest;
    } known[] = {{64, 0.2673, 0.8982}, {256, 0.0252, 0.0808}};
    for (const auto [size, rms, largest] : known) {
        double squares = 0, worst = 0;
        for (int degree = 0; degree <= 90; ++degree) {
            const double a = degree * host::pi / 180, c = host::cos(a) / 2, s = host::sin(a) / 2;
            auto corner = [&](double x, double y) { return glm::dvec3(c * x - s * y, 1, s * x + c * y); };
            const Geometry g = quad(corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1));
            const double error = 100 * (form_factor(g, {0, 0, 0}, {0, 1, 0}, size) / truth - 1);
            squares += error * error, worst = std::max(worst, std::fabs(error));
        }
        CHECK(std::sqrt(squares / 91) == Approx(rms).epsilon(2e-3));
        CHECK(worst == Approx(largest).epsilon(2e-3));
    }
}

TEST_CASE("hemicube: a wall seen by the side faces", "[raster][HEM 4.5.3][analytic]") {
    // dA on a floor to a unit square wall at distance 0.5 from the middle of its foot: verification.md 3. The wall turns
    // around the patch, so that every side face sees it.
    const double truth = 0.190135882384807;
    for (const glm::dvec3 towards : {glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)}) {
        const glm::dvec3 across(towards.z, 0, -towards.x), foot = 0.5 * towards, up(0, 1, 0);
        const Geometry g = quad(foot - 0.5 * across, foot + 0.5 * across, foot + 0.5 * across + up, foot - 0.5 * across + up);
        CHECK(form_factor(g, {0, 0, 0}, {0, 1, 0}, 512) == Approx(truth).epsilon(2e-3));
    }
}

TEST_CASE("hemicube: walls that fill a part of the side faces", "[raster][HEM 4.5.3][analytic]") {
    // dA on a floor to a rectangle that stands on it at distance d, of height h, from the foot of the distance to w on
    // one side: F = 1/(2 pi) (atan(w/d) - d/r atan(w/r)), r^2 = d^2 + h^2. A centred wall is two of them, one that starts
    // above the floor the difference of two.
    auto standing = [](double h, double d) {
        const double w = 0.5, r = std::sqrt(d * d + h * h);
        return 2 * (std::atan(w / d) - d / r * std::atan(w / r)) / (2 * host::pi);
    };
    REQUIRE(standing(1, 0.5) == Approx(0.190135882384807).epsilon(1e-12));
    const struct {
        double low, high;
    } walls[] = {{0, 0.25}, {0, 0.125}, {0.125, 0.25}, {0.25, 0.5}};
    for (const auto [low, high] : walls)
        for (const glm::dvec3 towards :
             {glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)}) {
            const glm::dvec3 across = 0.5 * glm::dvec3(towards.z, 0, -towards.x);
            const glm::dvec3 foot = 0.5 * towards + glm::dvec3(0, low, 0), top = 0.5 * towards + glm::dvec3(0, high, 0);
            const Geometry g = quad(foot - across, foot + across, top + across, top - across);
            CAPTURE(low, high, towards.x, towards.z);
            CHECK(form_factor(g, {0, 0, 0}, {0, 1, 0}, 512) ==
                  Approx(standing(high, 0.5) - standing(low, 0.5)).epsilon(2e-3));
        }
}

TEST_CASE("hemicube: five faces see all of a half space once", "[raster][HEM 4.5.3]") {
    // In a closed box every pixel sees a wall, whatever the normal.
    Geometry g;
    const glm::vec3 p[8] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
    const int faces[6][4] = {{0, 1, 2, 3}, {5, 4, 7, 6}, {4, 0, 3, 7}, {1, 5, 6, 2}, {3, 2, 6, 7}, {4, 5, 1, 0}};
    for (const auto& f : faces) {
        add_triangle(g, at(p[f[0]]), at(p[f[1]]), at(p[f[2]]));
        add_triangle(g, at(p[f[0]]), at(p[f[2]]), at(p[f[3]]));
    }
    test::Random random(7);
    for (int i = 0; i < 20; ++i) {
        Hemicube cube;
        draw_hemicube(g, nullptr, glm::dvec3(random.vector(-0.9, 0.9)), glm::dvec3(random.vector(-1, 1)), 1e-4, 64, {}, cube);
        for (const VisibilityBuffer& face : cube.faces)
            for (std::int32_t t : face.triangle.texels) REQUIRE(t >= 0);
    }
}

TEST_CASE("hemicube: each pixel sees what a ray through its centre hits", "[raster][HEM 5.6]") {
    // The axes of table 5.1, pixel by pixel, against the triangle plane it must hit: a floor of two colours.
    const glm::dvec3 eye(0.1, 0.7, -0.2), normal(0.3, -1, 0.2);
    Geometry g;
    add_triangle(g, at({-50, 0, -50}), at({0, 0, -50}), at({0, 0, 50}));
    add_triangle(g, at({-50, 0, -50}), at({0, 0, 50}), at({-50, 0, 50}));
    add_triangle(g, at({0, 0, -50}), at({50, 0, -50}), at({50, 0, 50}));
    add_triangle(g, at({0, 0, -50}), at({50, 0, 50}), at({0, 0, 50}));
    const int size = 64;
    Hemicube cube;
    draw_hemicube(g, nullptr, eye, normal, 1e-4, size, {}, cube);
    const HemicubeAxes a = hemicube_axes(normal);
    CHECK(dot(a.n, a.u) == Approx(0).margin(1e-15));
    CHECK(dot(a.n, a.t) == Approx(0).margin(1e-15));
    const glm::dvec3 forward[] = {a.n, a.u, -a.u, a.t, -a.t};
    int left = 0, right = 0;
    for (int face = 0; face < hemicube_faces; ++face) {
        const glm::dvec3 f = forward[face], up = face == 0 ? a.u : a.n;
        const glm::dvec3 across(f.y * up.z - f.z * up.y, f.z * up.x - f.x * up.z, f.x * up.y - f.y * up.x);
        const Image<std::int32_t>& items = cube.faces[face].triangle;
        for (int j = 0; j < items.height; ++j)
            for (int i = 0; i < size; ++i) {
                const glm::dvec3 ray = f + across * ((i + 0.5) * 2 / size - 1) + up * (1 - (j + 0.5) * 2 / size);
                if (ray.y > -0.02) continue;  // near the horizon the floor ends at 50 m
                const double x = eye.x - ray.x * eye.y / ray.y, z = eye.z - ray.z * eye.y / ray.y;
                if (std::fabs(x) < 0.02 || std::fabs(x) > 49 || std::fabs(z) > 49) continue;
                INFO("face " << face << " pixel " << i << ", " << j << " x " << x);
                REQUIRE((items(i, j) >= 2) == (x > 0));
                REQUIRE(items(i, j) >= 0);
                ++(x > 0 ? right : left);
            }
    }
    CHECK(left > 1000);
    CHECK(right > 1000);
}

TEST_CASE("hemicube: sizes 2 and 1024, and what is refused", "[raster][bad input]") {
    const Geometry g = quad({-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1});
    CHECK(form_factor(g, {0, 0, 0}, {0, 1, 0}, 2) > 0);
    CHECK(form_factor(g, {0, 0, 0}, {0, 1, 0}, 1024) == Approx(0.5541).epsilon(1e-3));
    Hemicube cube;
    CHECK_THROWS_WITH(draw_hemicube(g, nullptr, {0, 0, 0}, {0, 0, 0}, 1, 8, {}, cube), Catch::Contains("normal = [0, 0, 0]"));
    CHECK_THROWS_WITH(draw_hemicube(g, nullptr, {0, 0, 0}, {0, 1, 0}, 0, 8, {}, cube), Catch::Contains("near = 0"));
    CHECK_THROWS_WITH(draw_hemicube(g, nullptr, {0, 0, 0}, {0, 1, 0}, 1, 7, {}, cube), Catch::Contains("size = 7"));
}

}  // namespace plumb::raster
