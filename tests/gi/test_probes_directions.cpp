// The directions of a bake: every prefix of them is uniform; weights sum to what they must.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "core/sh_kernel.h"
#include "gi/probes/directions.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

// The largest error of the means of Y_j, j > 0, over the first n directions: 0 for an exact quadrature.
double error_of(const Buffer<glm::vec4>& directions, int n, int degree) {
    const Buffer<float> y = harmonics_of(directions, degree);
    const int count = sh::count(degree);
    double worst = 0;
    for (int j = 1; j < count; ++j) {
        double sum = 0;
        for (int k = 0; k < n; ++k) sum += double(y[std::size_t(k * count + j)]);
        worst = std::max(worst, std::fabs(4 * host::pi * sum / n));
    }
    return worst;
}

// Golden angle and equal heights: made for one number of directions.
Buffer<glm::vec4> fibonacci(int n) {
    Buffer<glm::vec4> all;
    for (int k = 0; k < n; ++k) {
        const double z = 1 - (2 * k + 1.0) / n, r = std::sqrt(1 - z * z), turn = k * (3 - std::sqrt(5.0)) / 2;
        all.emplace_back(r * host::cos(2 * host::pi * turn), r * host::sin(2 * host::pi * turn), z, 0);
    }
    return all;
}

}  // namespace

TEST_CASE("probes: every prefix of the relight rays is uniform", "[probes][IPR 3.2.3.1]") {
    const Buffer<glm::vec4> directions = relight_directions(512), spiral = fibonacci(512);
    for (const glm::vec4& d : directions) CHECK(glm::length(glm::dvec3(d)) == Approx(1).epsilon(1e-7));
    double before = 10;
    for (const int n : {64, 128, 256, 512}) {
        const double low = error_of(directions, n, 2), error = error_of(directions, n, 7);
        CAPTURE(n, low, error);
        // Independent directions err by sqrt(4 pi / n): 0.44 at 64, 0.16 at 512, each of 63 functions.
        CHECK(error < 1.5 * std::sqrt(4 * host::pi / n));
        CHECK(low < 0.5 * std::sqrt(4 * host::pi / n));
        CHECK(error < before);
        before = error;
        // A longer set begins with the same directions.
        const Buffer<glm::vec4> own = relight_directions(n);
        CHECK(std::equal(own.begin(), own.end(), directions.begin()));
        // The first part of a spiral is a cap.
        if (n < 512) CHECK(error_of(spiral, n, 2) > 1);
    }
    CHECK_THROWS_AS(relight_directions(0), InputError);
    CHECK_THROWS_AS(relight_directions(32769), InputError);
}

TEST_CASE("probes: weights of relight rays integrate harmonics exactly, and so the sampled Y_j are orthonormal", "[probes][analytic]") {
    CHECK(exact_degree(512) == 14);
    CHECK(exact_degree(256) == 10);
    CHECK(exact_degree(128) == 7);
    CHECK(exact_degree(64) == 4);
    CHECK(exact_degree(1) == 0);
    CHECK(exact_degree(32768) == 14);
    const Buffer<glm::vec4> directions = relight_directions(512);
    for (const int n : {1, 2, 8, 64, 128, 256, 500, 512}) {
        const Buffer<float> w = relight_weights(directions, n);
        REQUIRE(int(w.size()) == n);
        for (const float one : w) CHECK(one > 0.3 * 4 * host::pi / n);  // none is negative or nearly lost
        // Products of two functions up to half the degree: the integrals of the products are 1 or 0.
        const int degree = std::min(7, exact_degree(n) / 2), count = sh::count(degree);
        double worst = 0;
        for (int a = 0; a < count; ++a)
            for (int b = 0; b <= a; ++b) {
                double sum = 0;
                for (int r = 0; r < n; ++r) {
                    const glm::dvec3 d(directions[std::size_t(r)]);
                    const sh::Values y = sh::basis(d / glm::length(d), degree);
                    sum += double(w[std::size_t(r)]) * y[std::size_t(a)] * y[std::size_t(b)];
                }
                worst = std::max(worst, std::fabs(sum - (a == b ? 1 : 0)));
            }
        CAPTURE(n, degree);
        CHECK(worst < 1e-6);  // weights are floats
    }
    CHECK_THROWS_AS(relight_weights(directions, 513), InputError);
    CHECK_THROWS_AS(relight_weights(directions, 0), InputError);
}

TEST_CASE("probes: directions and weights have the same bits everywhere", "[probes][bits]") {
    const Buffer<glm::vec4> directions = relight_directions(512);
    std::uint64_t hash = content_hash(directions.data(), directions.size() * sizeof(glm::vec4));
    for (const int n : {1, 64, 128, 256, 512}) {
        const Buffer<float> weights = relight_weights(directions, n);
        hash = content_hash(weights.data(), weights.size() * sizeof(float), hash);
    }
    CHECK(hash_text(hash) == "944049cabc2d7098");
}

TEST_CASE("probes: factors of a receiver's rays sum to pi", "[probes][analytic]") {
    for (const int n : {1, 64, 500, 4096}) {
        double cosine = 0, uniform = 0;
        for (const float f : ray_factors(receiver_directions(n, Distribution::cosine), Distribution::cosine)) cosine += double(f);
        for (const float f : ray_factors(receiver_directions(n, Distribution::uniform), Distribution::uniform)) uniform += double(f);
        CHECK(cosine == Approx(host::pi).epsilon(1e-7));
        // The mean of 2 cos(theta) over heights whose discrepancy is a few parts in n.
        CHECK(uniform == Approx(host::pi).margin(4 * host::pi / n));
    }
}

TEST_CASE("sh: a kernel's functions are those of the host, one at a time and all at once", "[sh][analytic]") {
    for (int k = 0; k < 50; ++k) {
        const auto h = pixel_hash<std::int32_t>(k, 1, 2, 9);
        const glm::dvec3 d = glm::normalize(glm::dvec3(unit_float<double>(h.x), unit_float<double>(h.y), unit_float<double>(h.z)) - 0.5);
        const vec3<float> f(d);
        const sh::Values expected = sh::basis(glm::dvec3(f) / glm::length(glm::dvec3(f)));
        for (int degree = 0; degree <= 7; ++degree) {
            float sums[64];
            for (int j = 0; j < 64; ++j) sums[j] = float(j);
            sh::add_harmonics<float>(sh::recurrence().data(), degree, f, 0.75f, sums);
            for (int l = 0; l <= 7; ++l)
                for (int m = -l; m <= l; ++m) {
                    const int j = sh::index(l, m);
                    const float one = sh::add_harmonic<float>(sh::recurrence().data(), l, std::abs(m), m < 0, f, 0.75f, float(j));
                    CHECK(sums[j] == (l <= degree ? one : float(j)));
                    // Rounding of sums near 64, and of 14 steps of the recurrence.
                    CHECK(one - float(j) == Approx(0.75 * expected[std::size_t(j)]).margin(1e-5));
                }
        }
    }
}
