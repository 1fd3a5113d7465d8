// plumb experiment hemicube: fitted exponents, the box, its truth, and that a wrong result shows in the error.
#include <catch2/catch.hpp>
#include <cmath>

#include "tools/experiments/hemicube_world.h"

using namespace plumb;
using namespace plumb::cli;

TEST_CASE("experiment hemicube: exponents of powers", "[experiment]") {
    CHECK(fitted_exponent({1, 2, 4, 8}, {3, 12, 48, 192}) == Approx(2));
    CHECK(fitted_exponent({774, 2734, 10254}, {5, 5, 5}) == Approx(0).margin(1e-12));
    CHECK(fitted_exponent({1, 10}, {10, 1}) == Approx(-1));
    CHECK(fitted_exponent({3, 3}, {1, 2}) == 0);  // one x says nothing
}

TEST_CASE("experiment hemicube: where a curve falls to a level", "[experiment]") {
    CHECK(*where_it_falls_to({1, 4, 16}, {8, 4, 1}, 2) == Approx(8));  // halfway in logarithms
    CHECK(*where_it_falls_to({1, 4, 16}, {8, 4, 1}, 4) == Approx(4));
    CHECK(*where_it_falls_to({1, 4}, {2, 2}, 2) == Approx(1));
    CHECK_FALSE(where_it_falls_to({1, 4, 16}, {8, 4, 1}, 0.5));
    CHECK_FALSE(where_it_falls_to({1, 4, 16}, {8, 4, 1}, 9));
    CHECK_FALSE(where_it_falls_to({1, 4}, {8, std::nan("")}, 4));
}

TEST_CASE("experiment hemicube: the benchmark's meshes", "[experiment][HEM 5.8]") {
    for (const BenchmarkMesh& mesh : benchmark_meshes) {
        if (mesh.vertices > 3000) continue;  // the others are test_radiosity_boxes.cpp's
        const Box box = benchmark_box(mesh.triangles, false, {});
        CHECK(box.elements.count() == mesh.vertices);
        CHECK(int(box.elements.geometry.triangles.size()) == mesh.triangles);
    }
    CHECK(benchmark_box(1200, true, {}).elements.inset == 0);
    CHECK(benchmark_box(1200, false, {}).elements.inset > 0);
}

TEST_CASE("experiment hemicube: irradiance against path tracing, and a planted error", "[experiment][HEM 5.8]") {
    const Box box = benchmark_box(1200, false, {});
    HemicubeRequest request;
    request.samples = 512, request.elements = 128;
    const ElementTruth truth = trace_elements(box, request, {});
    REQUIRE(truth.index.size() <= 128);
    REQUIRE(truth.index.size() > 64);
    const radiosity::FormFactors factors = radiosity::form_factors(box.elements, {32, radiosity::Weights::exact}, {});
    const RowTransport rows(factors, box.elements);
    const Buffer<glm::vec4> b = radiosity::floats_of(converged(box.elements, rows, {}));
    Buffer<glm::vec4> h = rows.irradiance(b, {});
    const IprErrors good = errors_of(h, truth);
    CAPTURE(good.mean, good.bias, good.rms, good.noise);
    CHECK(good.truth > 0.5);
    CHECK(good.rms < 0.12);
    CHECK(std::fabs(good.bias) < 0.03);
    for (glm::vec4& v : h) v *= 1.1f;
    CHECK(errors_of(h, truth).bias == Approx(good.bias + 0.1 * (1 + good.bias)).epsilon(1e-4));
    // Passes come nearer to the converged solution, each by the mean reflectance at least.
    double last = 1;
    for (const int passes : {1, 2, 4, 8, 16}) {
        const double left = mean_difference(radiosity::floats_of(passes_of(box.elements, rows, passes, {})), b, box.elements.area);
        CHECK(left < last);
        last = left;
    }
    CHECK(last < 0.01);
    CHECK(mean_difference(b, b, box.elements.area) == 0);
}
