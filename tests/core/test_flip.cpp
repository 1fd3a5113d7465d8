// FLIP against closed forms, properties, and figures of the authors' own program.
#include "core/flip.h"

#include <catch2/catch.hpp>
#include <cmath>

using glm::dvec3;
using plumb::Image;
using namespace plumb::compare;

namespace {

constexpr double density = default_pixels_per_degree;

double flip_of_flat(dvec3 reference, dvec3 test) {
    return flip_ldr(Image<dvec3>(3, 2, reference), Image<dvec3>(3, 2, test), density, 1).mean;
}

// 48 x 40 in steps of 1/256; hdr: the column's exposure rises from 0 to 5 stops. The test is off by -16..15 steps.
Image<dvec3> picture(bool hdr, bool test) {
    Image<dvec3> out(48, 40);
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 48; ++x) {
            for (int c = 0; c < 3; ++c) {
                const int value = (x * x + 3 * y * y + 50 * c) % 256, error = (7 * x + 13 * y + 5 * c) % 32 - 16;
                const int shown = test ? std::min(std::max(value + error, 0), 255) : value;
                out(x, y)[c] = std::ldexp(shown / 256.0, hdr ? x / 8 : 0);
            }
        }
    }
    return out;
}

// The distance of green and blue, 203.3016546108775, to the power 0.7: evaluated from the formulas by a script.
constexpr double c_max = 41.276098414595445;

// The redistribution of FLIP 2020: errors e (to the power q_c) of flat pictures, which have no features.
double redistributed(double e) {
    const double knee = 0.4 * c_max;
    return e < knee ? 0.95 / knee * e : 0.95 + 0.05 * (e - knee) / (c_max - knee);
}

// L* of a grey above (6/29)^3.
double lightness(double grey) { return 116 * std::cbrt(grey) - 16; }

}  // namespace

TEST_CASE("flip: equal pictures give exactly 0 everywhere", "[compare][flip]") {
    for (const bool hdr : {false, true}) {
        const Image<dvec3> p = picture(hdr, false);
        const FlipResult result = hdr ? flip_hdr(p, p, density, 1) : flip_ldr(p, p, density, 1);
        CHECK(result.mean == 0);
        for (const float error : result.map.texels) REQUIRE(error == 0);
    }
}

TEST_CASE("flip: flat pictures have the distance of their colours", "[compare][flip][analytic]") {
    // Greys have no chroma, so HyAB is the difference of L*: 100 from black to white. The tolerance is the root
    // (q_f = 0.5) of what rounding leaves of the features, 1e-16.
    CHECK(flip_of_flat(dvec3(0), dvec3(1)) == Approx(redistributed(std::pow(100, 0.7))).epsilon(1e-7));
    CHECK(flip_of_flat(dvec3(0), dvec3(1)) == Approx(0.9673797614921327).epsilon(1e-7));
    CHECK(flip_of_flat(dvec3(0), dvec3(0.25)) == Approx(redistributed(std::pow(lightness(0.25), 0.7))).epsilon(1e-7));
    const double step = lightness(0.5) - lightness(0.25);
    CHECK(flip_of_flat(dvec3(0.25), dvec3(0.5)) == Approx(redistributed(std::pow(step, 0.7))).epsilon(1e-7));
    // Below (6/29)^3 = 0.00886 L* is linear in the grey, with the slope 116 (29/6)^2/3 = 903.3.
    const double dark = 116 * 841 / 108.0 * 0.004;
    CHECK(flip_of_flat(dvec3(0), dvec3(0.004)) == Approx(redistributed(std::pow(dark, 0.7))).epsilon(1e-7));
    // By definition of the scale.
    CHECK(flip_of_flat({0, 1, 0}, {0, 0, 1}) == Approx(1).epsilon(1e-12));
}

TEST_CASE("flip: values outside the display are clamped", "[compare][flip]") {
    CHECK(flip_of_flat(dvec3(-1), dvec3(5)) == flip_of_flat(dvec3(0), dvec3(1)));
}

TEST_CASE("flip: grows with the error", "[compare][flip]") {
    double last = 0;
    for (int step = 1; step <= 16; ++step) {
        const double error = flip_of_flat(dvec3(0.1), dvec3(0.1 + step * 0.05));
        CHECK(error > last);
        last = error;
    }
    CHECK(last < 1);
}

TEST_CASE("flip: LDR-FLIP of swapped pictures has the same bits", "[compare][flip][bits]") {
    const Image<dvec3> a = picture(false, false), b = picture(false, true);
    const FlipResult forward = flip_ldr(a, b, density, 1), backward = flip_ldr(b, a, density, 1);
    CHECK(forward.mean > 0);
    CHECK(forward.map.texels == backward.map.texels);
}

TEST_CASE("flip: the same bits for every number of threads", "[compare][flip][bits]") {
    const Image<dvec3> a = picture(true, false), b = picture(true, true);
    const FlipResult one = flip_hdr(a, b, density, 1);
    for (const int threads : {2, 3}) {
        const FlipResult other = flip_hdr(a, b, density, threads);
        CHECK(other.mean == one.mean);
        CHECK(other.map.texels == one.map.texels);
    }
}

TEST_CASE("flip: an isolated pixel raises its own error above that of its neighbours", "[compare][flip]") {
    Image<dvec3> black(41, 41, dvec3(0)), point = black;
    point(20, 20) = dvec3(1);
    const FlipResult result = flip_ldr(black, point, density, 1);
    for (const float error : result.map.texels) CHECK(error <= result.map(20, 20));
    CHECK(result.map(20, 20) > result.map(21, 20));
    // The eye resolves neither transpose nor mirror images differently.
    CHECK(result.map(20, 23) == Approx(result.map(23, 20)).epsilon(1e-6));
    CHECK(result.map(17, 20) == Approx(result.map(23, 20)).epsilon(1e-6));

    // A blue point spreads as far as the widest filter, blue-yellow: ceil(3 sqrt(0.04/(2 pi^2)) 67.02) = 10 pixels.
    point(20, 20) = dvec3(0, 0, 1);
    const FlipResult blue = flip_ldr(black, point, density, 1);
    CHECK(blue.map(30, 20) > 0);
    CHECK(blue.map(31, 20) == 0);
}

TEST_CASE("flip: means agree with the authors' program", "[compare][flip]") {
    // C++ FLIP 1.6 on these pictures (single precision, which costs it some 1e-6): "FLIP::evaluate" at this density.
    struct Row {
        bool hdr, swapped;
        double density, mean;
    };
    for (const Row& row : {Row{false, false, 67.02064, 0.0449926}, {false, false, 40, 0.0739760},
                           {false, false, 20, 0.1591114}, {true, false, 67.02064, 0.0807565},
                           {true, true, 67.02064, 0.0809409}, {true, false, 20, 0.1971908}}) {
        const Image<dvec3> reference = picture(row.hdr, row.swapped), test = picture(row.hdr, !row.swapped);
        const FlipResult result = row.hdr ? flip_hdr(reference, test, row.density, 1)
                                          : flip_ldr(reference, test, row.density, 1);
        CAPTURE(row.hdr, row.swapped, row.density);
        CHECK(result.mean == Approx(row.mean).margin(3e-6));
    }
}

TEST_CASE("flip: exposures lift the brightest and the median pixel to 0.85", "[compare][flip][analytic]") {
    // The tone curve gives 0.85 at x = 2.118872323987315; log2 of it is 1.0832966584510983 (by a script).
    const Image<dvec3> flat(5, 5, dvec3(1));
    const FlipResult same = flip_hdr(flat, flat, density, 1);
    CHECK(same.start_exposure == Approx(1.0832966584510983).epsilon(1e-12));
    CHECK(same.stop_exposure == Approx(1.0832966584510983).epsilon(1e-12));
    CHECK(same.exposures == 2);

    // Median 0.07, brightest 8: log2(8/0.07) = 6.84 stops apart, so 7 exposures.
    Image<dvec3> wide(5, 5, dvec3(0.07));
    wide(2, 2) = dvec3(8);
    const FlipResult result = flip_hdr(wide, wide, density, 1);
    CHECK(result.start_exposure == Approx(1.0832966584510983 - 3).epsilon(1e-12));
    CHECK(result.stop_exposure == Approx(1.0832966584510983 - std::log2(0.07)).epsilon(1e-12));
    CHECK(result.exposures == 7);
}

TEST_CASE("flip: HDR-FLIP does not depend on the unit of radiance", "[compare][flip]") {
    Image<dvec3> a = picture(true, false), b = picture(true, true);
    const double mean = flip_hdr(a, b, density, 1).mean;
    for (dvec3& v : a.texels) v *= 1024.0;
    for (dvec3& v : b.texels) v *= 1024.0;
    const FlipResult scaled = flip_hdr(a, b, density, 1);
    CHECK(scaled.mean == Approx(mean).epsilon(1e-9));
}

TEST_CASE("flip: mostly black and all black references have exposures", "[compare][flip]") {
    // Median 0: the median of the positive luminances, here of 1 and 4 the upper.
    Image<dvec3> reference(16, 16, dvec3(0)), test = reference;
    reference(3, 3) = dvec3(1);
    reference(4, 4) = dvec3(4);
    test(9, 9) = dvec3(1);
    const FlipResult sparse = flip_hdr(reference, test, density, 1);
    CHECK(sparse.stop_exposure == Approx(1.0832966584510983 - 2).epsilon(1e-12));
    CHECK(sparse.mean > 0);
    CHECK(sparse.mean < 1);

    const FlipResult black = flip_hdr(Image<dvec3>(16, 16, dvec3(0)), test, density, 1);
    CHECK(black.exposures == 1);
    CHECK(black.start_exposure == 0);
    CHECK(black.mean > 0);
    CHECK(black.mean < 1);
}

TEST_CASE("flip: the sRGB curve and its knee", "[compare][flip]") {
    // IEC 61966-2-1: v/12.92 up to 0.04045, ((v + 0.055)/1.055)^2.4 above.
    CHECK(srgb_to_linear(0) == 0);
    CHECK(srgb_to_linear(1) == Approx(1).epsilon(1e-15));
    CHECK(srgb_to_linear(0.04) == Approx(0.04 / 12.92).epsilon(1e-15));
    for (int i = 11; i <= 255; ++i) {
        CHECK(srgb_to_linear(i / 255.0) == Approx(std::pow((i / 255.0 + 0.055) / 1.055, 2.4)).epsilon(1e-14));
    }
}
