// SSIM against closed forms and against the index of Wang et al. 2004 written out as double sums over the window.
#include "core/ssim.h"

#include <catch2/catch.hpp>
#include <cmath>

using plumb::Image;
using plumb::compare::ssim;

namespace {

constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;  // for a dynamic range of 1

// Values 0 .. 255/256 without a pattern the window could hide.
Image<double> pattern(int width, int height, int seed) {
    Image<double> picture(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) picture(x, y) = (x * x + 3 * y * y + seed * (x + 2 * y)) % 256 / 256.0;
    }
    return picture;
}

double window_weight(int offset) {
    double sum = 0;
    for (int k = -5; k <= 5; ++k) sum += std::exp(-k * k / 4.5);
    return std::exp(-offset * offset / 4.5) / sum;
}

}  // namespace

TEST_CASE("ssim: equal pictures give 1 to the bit", "[compare][ssim]") {
    const Image<double> picture = pattern(24, 19, 5);
    CHECK(ssim(picture, picture, 1, 1).value() == 1);
    CHECK(ssim(Image<double>(11, 11, 0.0), Image<double>(11, 11, 0.0), 1, 1).value() == 1);
}

TEST_CASE("ssim: flat pictures leave the luminance term", "[compare][ssim]") {
    // No variance: the index is (2 p q + c1)/(p^2 + q^2 + c1).
    const double p = 0.25, q = 0.75;
    const auto value = ssim(Image<double>(13, 12, p), Image<double>(13, 12, q), 1, 1);
    CHECK(value.value() == Approx((2 * p * q + c1) / (p * p + q * q + c1)).epsilon(1e-12));
}

TEST_CASE("ssim: opposed checkerboards have opposed structure", "[compare][ssim]") {
    // c + s and c - s with s = +-d. The window turns s into +-d g^2, g the alternating sum of its weights; the variance
    // of each is d^2 (1 - g^4), the covariance its negative, and the luminance term has c -+ d g^2.
    const double c = 0.5, d = 0.25;
    Image<double> a(12, 12), b(12, 12);
    for (int y = 0; y < 12; ++y) {
        for (int x = 0; x < 12; ++x) {
            const double s = (x + y) % 2 ? -d : d;
            a(x, y) = c + s;
            b(x, y) = c - s;
        }
    }
    double g = 0;
    for (int k = -5; k <= 5; ++k) g += k % 2 ? -window_weight(k) : window_weight(k);
    const double m = d * g * g, variance = d * d * (1 - g * g * g * g);
    const double expected = (2 * (c * c - m * m) + c1) * (-2 * variance + c2) /
                            ((2 * (c * c + m * m) + c1) * (2 * variance + c2));
    CHECK(expected < -0.98);
    CHECK(ssim(a, b, 1, 1).value() == Approx(expected).epsilon(1e-12));
}

TEST_CASE("ssim: the separable form equals the double sum over each whole window", "[compare][ssim]") {
    const Image<double> a = pattern(17, 13, 1), b = pattern(17, 13, 6);
    const double range = 2, k1 = 0.01 * range * 0.01 * range, k2 = 0.03 * range * 0.03 * range;
    double sum = 0;
    for (int y = 5; y < 13 - 5; ++y) {
        for (int x = 5; x < 17 - 5; ++x) {
            double ma = 0, mb = 0, vaa = 0, vbb = 0, vab = 0;
            for (int pass = 0; pass < 2; ++pass) {
                for (int v = -5; v <= 5; ++v) {
                    for (int u = -5; u <= 5; ++u) {
                        const double w = window_weight(u) * window_weight(v), p = a(x + u, y + v), q = b(x + u, y + v);
                        if (pass == 0) {
                            ma += w * p;
                            mb += w * q;
                        } else {
                            vaa += w * (p - ma) * (p - ma);
                            vbb += w * (q - mb) * (q - mb);
                            vab += w * (p - ma) * (q - mb);
                        }
                    }
                }
            }
            sum += (2 * ma * mb + k1) * (2 * vab + k2) / ((ma * ma + mb * mb + k1) * (vaa + vbb + k2));
        }
    }
    CHECK(ssim(a, b, range, 1).value() == Approx(sum / (7 * 3)).epsilon(1e-12));
}

TEST_CASE("ssim: symmetric, and the same bits for every number of threads", "[compare][ssim][bits]") {
    const Image<double> a = pattern(40, 50, 1), b = pattern(40, 50, 2);
    const double value = ssim(a, b, 1, 1).value();
    CHECK(ssim(b, a, 1, 1).value() == value);
    CHECK(ssim(a, b, 1, 2).value() == value);
    CHECK(ssim(a, b, 1, 3).value() == value);
}

TEST_CASE("ssim: undefined where no window fits and where the range vanishes", "[compare][ssim]") {
    CHECK(ssim(pattern(11, 11, 1), pattern(11, 11, 2), 1, 1).has_value());
    CHECK_FALSE(ssim(pattern(10, 11, 1), pattern(10, 11, 2), 1, 1).has_value());
    CHECK_FALSE(ssim(pattern(11, 10, 1), pattern(11, 10, 2), 1, 1).has_value());
    CHECK_FALSE(ssim(pattern(11, 11, 1), pattern(11, 11, 2), 0, 1).has_value());
    CHECK_FALSE(ssim(pattern(11, 11, 1), pattern(11, 11, 2), std::nan(""), 1).has_value());
}
