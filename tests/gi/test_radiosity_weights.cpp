// What a hemicube's texels weigh.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/radiosity/texel_weights.h"

using namespace plumb;
using namespace plumb::radiosity;

namespace {

double sum_of(const std::vector<double>& values, std::size_t first, std::size_t last) {
    long double sum = 0;
    for (std::size_t i = first; i < last; ++i) sum += values[i];
    return double(sum);
}

// Gauss' rule of 8 x 8 points over [x0, x1] x [y0, y1].
template <class F>
double quadrature(F f, double x0, double x1, double y0, double y1) {
    const double at[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    const double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    double sum = 0;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            const double x = (i < 4 ? -1 : 1) * at[i % 4], y = (j < 4 ? -1 : 1) * at[j % 4];
            sum += weight[i % 4] * weight[j % 4] *
                   f(0.5 * (x0 + x1) + 0.5 * (x1 - x0) * x, 0.5 * (y0 + y1) + 0.5 * (y1 - y0) * y);
        }
    return sum * 0.25 * (x1 - x0) * (y1 - y0);
}
double top_density(double x, double y) {
    const double r2 = x * x + y * y + 1;
    return 1 / (host::pi * r2 * r2);
}
double side_density(double y, double z) { return z * top_density(y, z); }

}  // namespace

TEST_CASE("texel weights: exact ones sum to one for every size", "[radiosity][HEM 4.5.3][analytic]") {
    double worst = 0;
    for (int size = 2; size <= 1024; size += size < 96 ? 2 : 2 * (size / 12)) {
        const std::vector<double> w = texel_weights(size, Weights::exact);
        REQUIRE(w.size() == 3 * std::size_t(size) * std::size_t(size));
        const std::size_t top = std::size_t(size) * std::size_t(size), side = top / 2;
        worst = std::fmax(worst, std::fabs(sum_of(w, 0, w.size()) - 1));
        // Shares of the top and of a side, algorithms.md 6.
        CHECK(sum_of(w, 0, top) == Approx(0.554126424).margin(1e-9));
        for (std::size_t face = 0; face < 4; ++face)
            CHECK(sum_of(w, top + face * side, top + (face + 1) * side) == Approx(0.111468394).margin(1e-9));
        for (const double x : w) REQUIRE(x > 0);
    }
    CAPTURE(worst * 1e15);
    CHECK(worst < 2e-14);  // what the corners' rounding leaves of three million terms
}

TEST_CASE("texel weights: exact ones are the density's integral over each texel", "[radiosity][HEM 4.5.3][analytic]") {
    for (const int size : {4, 6, 16, 64}) {
        const std::vector<double> w = texel_weights(size, Weights::exact);
        const double d = 2.0 / size;
        double worst = 0;
        std::size_t at = 0;
        for (int j = 0; j < size; ++j)
            for (int i = 0; i < size; ++i)
                worst = std::fmax(worst, std::fabs(w[at++] - quadrature(top_density, i * d - 1, (i + 1) * d - 1,
                                                                        j * d - 1, (j + 1) * d - 1)));
        for (int face = 0; face < 4; ++face)
            for (int j = 0; j < size / 2; ++j)
                for (int i = 0; i < size; ++i)
                    worst = std::fmax(worst, std::fabs(w[at++] - quadrature(side_density, i * d - 1, (i + 1) * d - 1,
                                                                            1 - (j + 1) * d, 1 - j * d)));
        CAPTURE(size);
        CHECK(worst < (size < 6 ? 1e-11 : 2e-16));  // the rule itself errs by 1e-12 on texels of half a face
    }
}

TEST_CASE("texel weights: mirrored texels share one value", "[radiosity]") {
    for (const Weights kind : {Weights::exact, Weights::centre, Weights::published}) {
        const int size = 22;
        const std::vector<double> w = texel_weights(size, kind);
        auto top = [&](int i, int j) { return w[std::size_t(j * size + i)]; };
        const double least = kind == Weights::exact ? 0 : 1e-17;
        for (int j = 0; j < size; ++j)
            for (int i = 0; i < size; ++i) {
                CHECK(std::fabs(top(i, j) - top(size - 1 - i, j)) <= least);
                CHECK(std::fabs(top(i, j) - top(i, size - 1 - j)) <= least);
                CHECK(std::fabs(top(i, j) - top(j, i)) <= least);
            }
        // The first row of a side is the uppermost, next to the top; the last one looks along the surface.
        CHECK(w[std::size_t(size * size)] > 5 * w[std::size_t(size * size + (size / 2 - 1) * size)]);
    }
}

TEST_CASE("texel weights: at centres they sum to more than one", "[radiosity][HEM 4.5.3][analytic]") {
    // verification.md 3.
    const struct {
        int size;
        double error;
    } known[] = {{32, 5.3e-4}, {64, 1.3e-4}, {128, 3.3e-5}, {256, 8.3e-6}};
    for (const auto [size, error] : known) {
        const std::vector<double> w = texel_weights(size, Weights::centre);
        CHECK(sum_of(w, 0, w.size()) - 1 == Approx(error).epsilon(0.03));
    }
}

TEST_CASE("texel weights: the published maps, and what they are divided by", "[radiosity][HEM 5.6]") {
    // algorithms.md 6: 4,977 at 64 texels, times a texel's area 4.86. At 2 texels, x = y = 1/2 everywhere: (5.5) is
    // 2/3, (5.7) is 1/3, and there are 4 and 8 of them.
    CHECK(published_sum(64) == Approx(4977).margin(0.5));
    CHECK(published_sum(64) * 4 / (64 * 64) == Approx(4.86).margin(0.005));
    CHECK(published_sum(2) == Approx(16.0 / 3).epsilon(1e-15));
    const std::vector<double> two = texel_weights(2, Weights::published);
    CHECK(two[0] == Approx(2.0 / 16).epsilon(1e-15));
    CHECK(two[11] == Approx(1.0 / 16).epsilon(1e-15));
    for (const int size : {2, 8, 64, 512}) {
        const std::vector<double> w = texel_weights(size, Weights::published);
        CHECK(sum_of(w, 0, w.size()) == Approx(1).margin(1e-12));
    }
    // One cosine where three are due: the top's corners weigh too much, its middle too little. In the limit the middle
    // has 1 / 4.86 a unit of area where 1 / pi is due.
    const std::vector<double> w = texel_weights(256, Weights::published), e = texel_weights(256, Weights::exact);
    CHECK(w[0] / e[0] == Approx(3 * 3.14159265 / 4.8604).epsilon(0.02));
    CHECK(w[128 * 256 + 128] / e[128 * 256 + 128] == Approx(3.14159265 / 4.8604).epsilon(1e-3));
}

TEST_CASE("texel weights: sizes that no hemicube has are refused", "[radiosity]") {
    for (const int size : {-2, 0, 1, 3, 63, 4098}) {
        CHECK_THROWS_AS(texel_weights(size, Weights::exact), InputError);
        CHECK_THROWS_AS(published_sum(size), InputError);
    }
}
