// The gather over every texel is a quadrature of the form factor from a differential area; closed forms are those of
// verification.md 3.
#include <catch2/catch.hpp>

#include "core/host_math.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

const rsm::GatherParams all_texels = [] {
    rsm::GatherParams p;
    p.gather = rsm::Gather::all;
    return p;
}();

// A unit wall of radiosity 1 W/m2 at x = 0, y in [0, 1], z in [-1/2, 1/2], facing +x, as n x n pixel lights.
raster::Rsm unit_wall(int n) {
    raster::Rsm map = empty_map(n);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            set_texel(map, i, j, {0, (j + 0.5) / n, (i + 0.5) / n - 0.5}, {1, 0, 0}, glm::vec3(1.0f / n / n));
    return map;
}

double floor_point_error_percent(int n, double distance, double exact) {
    const Points floor_point({float(distance), 0, 0}, {0, 1, 0});
    return (gather(all_texels, floor_point, unit_wall(n))(0, 0).x / exact - 1) * 100;
}

}  // namespace

TEST_CASE("rsm.all: dA to a coaxial disc is a^2 / (a^2 + d^2)", "[rsm][VRSM (3.2)][analytic]") {
    // A disc of radius 1/2 and radiosity 1 in the plane of a 512^2 map. Cutting a circle out of square texels moves the
    // area by less than its circumference times a tenth of a texel: 2 a / n * 0.1 relative.
    const double a = 0.5;
    const int n = 512;
    const raster::Rsm map = plane_map(n, [&](double x, double y) { return x * x + y * y < a * a ? 1.0 : 0.0; });
    for (double d : {0.1, 0.25, 0.5, 1.0, 2.0, 8.0}) {
        const double got = gather(all_texels, Points({0, 0, float(d)}, {0, 0, -1}), map)(0, 0).x;
        CAPTURE(d, got);
        CHECK(got == Approx(a * a / (a * a + d * d)).epsilon(4e-4).margin(0));
    }
}

TEST_CASE("rsm.all: dA to an opposed centred unit square at distance 1", "[rsm][VRSM (3.2)][analytic]") {
    const raster::Rsm map =
        plane_map(256, [](double x, double y) { return std::abs(x) < 0.5 && std::abs(y) < 0.5 ? 1.0 : 0.0; });
    const double got = gather(all_texels, Points({0, 0, 1}, {0, 0, -1}), map)(0, 0).x;
    // The midpoint rule over texels of side 1/128 errs by about h^2/12 times the second derivatives: 2e-5.
    CHECK(got == Approx(0.239456470460774).epsilon(2e-5).margin(0));
}

TEST_CASE("rsm.all: a floor point at a wall's foot errs as the quadrature must", "[rsm][VRSM (3.2)][analytic]") {
    const double at_half = 0.190135882384807, at_foot = 0.484323815518066;
    // Errors in percent as verification.md 3 lists them, to the digits it gives.
    CHECK(floor_point_error_percent(16, 0.5, at_half) == Approx(0.205).margin(0.0006));
    CHECK(floor_point_error_percent(64, 0.5, at_half) == Approx(0.013).margin(0.0006));
    CHECK(floor_point_error_percent(256, 0.5, at_half) == Approx(0.001).margin(0.0006));
    CHECK(floor_point_error_percent(16, 0.02, at_foot) == Approx(-11.7).margin(0.06));
    CHECK(floor_point_error_percent(64, 0.02, at_foot) == Approx(3.17).margin(0.006));
    CHECK(floor_point_error_percent(256, 0.02, at_foot) == Approx(0.166).margin(0.0006));
}

TEST_CASE("rsm.all: the published equation lacks 1/pi", "[rsm][VRSM (3.2)][published]") {
    rsm::GatherParams published = all_texels;
    published.variant = rsm::Variant::published;
    const Points point({0.5f, 0, 0}, {0, 1, 0});
    const raster::Rsm wall = unit_wall(64);
    const double corrected = gather(all_texels, point, wall)(0, 0).x, printed = gather(published, point, wall)(0, 0).x;
    CHECK(printed / corrected == Approx(host::pi).epsilon(1e-6));
}

TEST_CASE("rsm.all: light behind the receiver or behind the pixel light counts nothing", "[rsm][VRSM (3.2)]") {
    const raster::Rsm wall = unit_wall(8);
    CHECK(gather(all_texels, Points({0.5f, 0.5f, 0}, {1, 0, 0}), wall)(0, 0) == glm::vec4(0));
    CHECK(gather(all_texels, Points({-0.5f, 0.5f, 0}, {1, 0, 0}), wall)(0, 0) == glm::vec4(0));
}

TEST_CASE("rsm: a point on a pixel light, or at the ends of the range, stays finite", "[rsm][extreme]") {
    for (float distance : {0.0f, 1e-30f, 1e-20f, 1e-10f, 1e10f, 1e20f, 1e30f}) {
        raster::Rsm map = empty_map(1);
        set_texel(map, 0, 0, {0, 0, 0}, {0, 0, 1}, glm::vec3(1));
        const glm::vec4 e = gather(all_texels, Points({0, 0, distance}, {0, 0, -1}), map)(0, 0);
        CAPTURE(distance, e.x);
        CHECK(std::isfinite(e.x));
        CHECK(e.x >= 0);
        // 1/(pi d^2) wherever that is a normal float and above the floor of 1e-37 m2.
        const double exact = 1 / (host::pi * double(distance) * distance);
        if (distance >= 1e-15f && exact > 1e-37 && exact < 1e38) CHECK(e.x == Approx(exact).epsilon(1e-6).margin(0));
    }
}

TEST_CASE("rsm: min_distance is the floor of |x - x_p|", "[rsm][VRSM (3.2)]") {
    raster::Rsm map = empty_map(1);
    set_texel(map, 0, 0, {0, 0, 0}, {0, 0, 1}, glm::vec3(1));
    rsm::GatherParams params = all_texels;
    params.min_distance = 0.5f;
    // cos_p = cos_x = 0.25 m, over a floor of 0.25 m2 twice.
    CHECK(gather(params, Points({0, 0, 0.25f}, {0, 0, -1}), map)(0, 0).x == Approx(1 / host::pi).epsilon(1e-6));
}
