// One picture in place of a hemicube: what it shows of the hemisphere, and form factors with it.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/radiosity/contour.h"
#include "gi/radiosity/hemicube_factor.h"
#include "gi/radiosity/projections.h"

using namespace plumb;
using namespace plumb::radiosity;

namespace {

double sum_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum;
}

Geometry geometry_of(const Polygon& polygon) {
    Geometry g;
    for (const glm::dvec3& p : polygon) {
        Vertex v;
        v.position = glm::vec3(p);
        g.vertices.push_back(v);
    }
    for (std::uint32_t k = 2; k < polygon.size(); ++k) g.triangles.push_back({0, k - 1, k});
    g.material.assign(g.triangles.size(), 0), g.object = g.material;
    return g;
}

// From the origin, looking up.
double seen(const Polygon& polygon, const ProjectionParams& p) {
    const Geometry g = geometry_of(polygon);
    return projected_form_factor(g, nullptr, {{{0, 0, 0}, {0, 1, 0}}}, std::vector<std::int32_t>(2 * g.triangles.size(), 0), p, 1e-6, {});
}

// x along `ahead` of the patch, y up: a wall between two heights, 1 wide.
Polygon wall(double ahead, double low, double high) { return {{ahead, low, -0.5}, {ahead, high, -0.5}, {ahead, high, 0.5}, {ahead, low, 0.5}}; }

}  // namespace

TEST_CASE("projections: a picture's share of the hemisphere is the form factor of its plane", "[radiosity][HEM 4.5.3][analytic]") {
    CHECK(share_of_view(90) == Approx(0.554126424).margin(1e-9));  // a hemicube's top
    for (const double view : {1.0, 60.0, 120.0, 170.0, 179.0}) {
        const double e = host::tan(view * host::pi / 360);
        const Polygon plane = {{-e, 1, -e}, {-e, 1, e}, {e, 1, e}, {e, 1, -e}};
        CAPTURE(view);
        CHECK(share_of_view(view) == Approx(point_form_factor({0, 0, 0}, {0, 1, 0}, plane)).epsilon(1e-13));
        for (const int size : {2, 30, 110}) CHECK(sum_of(projection_weights({Projection::plane, size, view, false})) == Approx(share_of_view(view)).epsilon(1e-12));
        CHECK(sum_of(projection_weights({Projection::plane, 64, view, true})) == Approx(1).epsilon(1e-12));
        if (view > 10) CHECK(sum_of(projection_weights({Projection::fish_eye, 64, view, true})) == Approx(1).epsilon(1e-12));
    }
    CHECK(share_of_view(179.999) > 0.9999999);
}

TEST_CASE("projections: a lens' texels weigh the same, and lose what its picture does", "[radiosity][HEM 4.5.3][analytic]") {
    for (const double view : {90.0, 150.0, 170.0}) {
        CAPTURE(view);
        for (const int size : {64, 256, 1024})
            CHECK(sum_of(projection_weights({Projection::fish_eye, size, view, false})) == Approx(share_of_view(view)).margin(0.5 / size));
        // Whole numbers of one texel's share.
        const std::vector<double> weights = projection_weights({Projection::fish_eye, 64, view, false});
        double least = 1;
        for (const double w : weights)
            if (w > 0) least = std::min(least, w);
        for (const double w : weights) CHECK(std::fabs(w / least - std::floor(w / least + 0.5)) < 1e-9);
        CHECK(least == Approx(4.0 / (host::pi * 64 * 64)).epsilon(0.01));
    }
}

TEST_CASE("projections: a plane of 90 degrees is a hemicube's top", "[radiosity][HEM 4.5.3]") {
    // The square at distance 1 is within it at any rotation.
    for (const int size : {32, 64}) {
        const RotationErrors cube = rotation_errors(size, Weights::exact, {});
        const RotationErrors plane = rotation_errors([&](const Geometry& g) {
            return projected_form_factor(g, nullptr, {{{0, 0, 0}, {0, 1, 0}}}, {0, 0, 0, 0}, {Projection::plane, size, 90, false}, 1e-6, {});
        });
        CAPTURE(size);
        CHECK(plane.rms == Approx(cube.rms).margin(1e-3));
        CHECK(plane.largest == Approx(cube.largest).margin(1e-3));
    }
}

TEST_CASE("projections: a wall is seen from where the picture's edge meets it", "[radiosity][HEM 4.5.3][analytic]") {
    // All of it gives 0.190135882384807 (verification.md 3).
    const Polygon whole = wall(0.5, 0, 1);
    REQUIRE(point_form_factor({0, 0, 0}, {0, 1, 0}, whole) == Approx(0.190135882384807).margin(1e-12));
    for (const double view : {120.0, 150.0, 170.0}) {
        const double from = 0.5 / host::tan(view * host::pi / 360);
        const double truth = point_form_factor({0, 0, 0}, {0, 1, 0}, wall(0.5, from, 1));
        const double off = 0.8 * 2 * 0.5 / from / 1024;  // outlines follow whole texels, tan(view / 2) 2 / 1024 wide at distance 1
        CAPTURE(view, from, truth);
        CHECK(seen(whole, {Projection::plane, 1024, view, false}) == Approx(truth).epsilon(off));
        CHECK(seen(whole, {Projection::fish_eye, 1024, view, false}) == Approx(truth).epsilon(off));
        CHECK(seen(wall(0.5, 0, 0.9 * from), {Projection::plane, 512, view, false}) == 0);
        CHECK(seen(wall(0.5, 0, 0.9 * from), {Projection::fish_eye, 512, view, false}) == 0);
    }
}

TEST_CASE("projections: as many texels as a hemicube, and what is refused", "[radiosity]") {
    for (const int size : {8, 64, 512}) CHECK(std::fabs(size_of_equal_texels(size) / (std::sqrt(3.0) * size) - 1) < 0.08);
    CHECK(size_of_equal_texels(64) == 110);
    CHECK_THROWS_AS(projection_weights({Projection::plane, 7, 90, false}), InputError);
    CHECK_THROWS_AS(projection_weights({Projection::plane, 8, 180, false}), InputError);
    CHECK_THROWS_AS(projection_weights({Projection::plane, 8, NAN, false}), InputError);
    CHECK_THROWS_AS(projection_weights({Projection::fish_eye, 64, 1, true}), InputError);  // no texel's lens looks there
    CHECK_THROWS_AS(share_of_view(0), InputError);
}
