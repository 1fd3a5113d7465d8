// Signed errors against answers worked out by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/signed_error.h"

using namespace plumb;
using namespace plumb::compare;

namespace {

const double nan_value = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

Plane row(std::vector<double> values) {
    Plane plane(int(values.size()), 1);
    std::copy(values.begin(), values.end(), plane.texels.begin());
    return plane;
}
Image<std::uint8_t> mask(std::vector<std::uint8_t> values) {
    Image<std::uint8_t> image(int(values.size()), 1);
    std::copy(values.begin(), values.end(), image.texels.begin());
    return image;
}

}  // namespace

TEST_CASE("signed error: shares, energies and means of four pixels by hand", "[compare][analytic]") {
    // Off by 0, -1, +1/8, +4: with a tolerance of 10 % the second is too dark, the third and fourth are too bright.
    const SignedErrors e = signed_errors(row({1, 1, 1.125, 8}), row({1, 2, 1, 4}), {}, {}, {0.1, 3});
    CHECK(e.pixels == 4);
    CHECK(e.nonfinite == 0);
    CHECK(e.too_dark == 0.25);
    CHECK(e.too_bright == 0.5);
    CHECK(e.wrong == 0.75);
    CHECK(e.mean_truth == 2);          // 8 / 4
    CHECK(e.mean_error == 3.125 / 8);  // (0 - 1 + 1/8 + 4) / 8
    CHECK(e.removed == 1.0 / 8);
    CHECK(e.leaked == 4.125 / 8);
    CHECK(*e.rms == Approx(std::sqrt((1 + 1.0 / 64 + 16) / 4) / 2).epsilon(1e-15));
    CHECK(e.noise == 0);
    CHECK_FALSE(e.below_noise);
    // 12.5 % is within 12.5 %, not beyond it.
    CHECK(signed_errors(row({1, 1, 1.125, 8}), row({1, 2, 1, 4}), {}, {}, {0.125, 3}).too_bright == 0.25);
}

TEST_CASE("signed error: the truth's noise is taken off", "[compare][analytic]") {
    // Off by -3 and +5 with standard errors of 1 and 2.
    const Plane a = row({7, 15}), truth = row({10, 10}), error = row({1, 2});
    // Allowed: 1 + 1 and 1 + 2; with two standard errors 1 + 2 and 1 + 4; the differences must be larger.
    CHECK(signed_errors(a, truth, error, {}, {0.1, 1}).wrong == 1);
    const SignedErrors two = signed_errors(a, truth, error, {}, {0.1, 2});
    CHECK(two.wrong == 0);
    // Beyond two standard errors: 3 - 2 and 5 - 4 of 20.
    CHECK(two.removed == 1.0 / 20);
    CHECK(two.leaked == 1.0 / 20);
    // Beyond three nothing is left.
    CHECK(signed_errors(a, truth, error, {}, {0, 3}).removed == 0);
    CHECK(signed_errors(a, truth, error, {}, {0, 3}).leaked == 0);
    // (9 + 25 - 1 - 4) / 2 and (1 + 4) / 2, of the mean 10.
    CHECK(*two.rms == Approx(std::sqrt(14.5) / 10).epsilon(1e-15));
    CHECK(*two.noise == Approx(std::sqrt(2.5) / 10).epsilon(1e-15));
    CHECK(*two.mean_error == Approx(0.1).epsilon(1e-15));
    CHECK_FALSE(two.below_noise);

    // As far off as the noise is wide: nothing that can be told from it.
    const SignedErrors within = signed_errors(row({9, 12}), truth, error);
    CHECK(within.below_noise);
    CHECK(within.rms == 0);
}

TEST_CASE("signed error: what is no number is wrong, and no sum hides it", "[compare]") {
    for (const double bad : {nan_value, infinite, -infinite}) {
        for (const int where : {0, 1, 2}) {
            CAPTURE(bad, where);
            const auto with = [&](int which) { return row({1, which == where ? bad : 1, 1, 1}); };
            const SignedErrors e = signed_errors(with(0), with(1), with(2), {}, {0.1, 0});
            CHECK(e.nonfinite == 1);
            CHECK(e.wrong == 0.25);
            CHECK(e.too_dark == 0);
            CHECK(e.too_bright == 0);
            CHECK_FALSE(e.rms);
            CHECK_FALSE(e.mean_error);
            CHECK_FALSE(e.removed);
            CHECK_FALSE(e.leaked);
            CHECK_FALSE(e.mean_truth);
            CHECK_FALSE(e.below_noise);
        }
    }
    // Not where it is not looked at.
    const SignedErrors e = signed_errors(row({1, nan_value}), row({1, 1}), {}, mask({1, 0}));
    CHECK(e.pixels == 1);
    CHECK(e.nonfinite == 0);
    CHECK(e.wrong == 0);
    CHECK(e.rms == 0);
}

TEST_CASE("signed error: nothing to compare is nothing that agrees", "[compare]") {
    for (const SignedErrors& e : {signed_errors({}, {}), signed_errors(row({1}), row({1}), {}, mask({0}))}) {
        CHECK(e.pixels == 0);
        CHECK(e.wrong == 1);
        CHECK_FALSE(e.rms);
        CHECK_FALSE(e.below_noise);
    }
    // In the dark nothing is relative to anything; what is brighter is still too bright.
    const SignedErrors dark = signed_errors(row({0, 0.5}), row({0, 0}));
    CHECK(dark.too_bright == 0.5);
    CHECK(dark.mean_truth == 0);
    CHECK_FALSE(dark.rms);
    CHECK_FALSE(dark.leaked);
}

TEST_CASE("signed error: sizes and options that mean nothing are refused", "[compare]") {
    const Plane one = row({1}), two = row({1, 1});
    CHECK_THROWS_AS(signed_errors(one, two), InputError);
    CHECK_THROWS_AS(signed_errors(one, one, two), InputError);
    CHECK_THROWS_AS(signed_errors(one, one, {}, mask({1, 1})), InputError);
    CHECK_THROWS_AS(relative_errors(one, two, 0), InputError);
    CHECK_THROWS_AS(relative_errors(one, one, 0, two), InputError);
    for (const double bad : {-1.0, nan_value, infinite}) {
        CHECK_THROWS_AS(signed_errors(one, one, {}, {}, {bad, 3}), InputError);
        CHECK_THROWS_AS(signed_errors(one, one, {}, {}, {0.1, bad}), InputError);
        CHECK_THROWS_AS(relative_errors(one, one, bad), InputError);
        CHECK_THROWS_AS(relative_errors(one, one, 0, one, bad), InputError);
    }
}

TEST_CASE("signed error: relative to the truth and a floor, pixel by pixel", "[compare][analytic]") {
    const Plane e = relative_errors(row({1, 3, 0, 0, nan_value, infinite, 1, -1}),
                                    row({2, 2, 0, 1, 1, infinite, nan_value, -3}), 1);
    CHECK(e.texels[0] == -1.0 / 3);
    CHECK(e.texels[1] == 1.0 / 3);
    CHECK(e.texels[2] == 0);
    CHECK(e.texels[3] == -0.5);
    for (const int i : {4, 5, 6}) CHECK(std::isnan(e.texels[std::size_t(i)]));
    CHECK(e.texels[7] == 0.5);
    const Plane without = relative_errors(row({0, 1, -1}), row({0, 0, 0}), 0);
    CHECK(without.texels[0] == 0);
    CHECK(without.texels[1] == infinite);
    CHECK(without.texels[2] == -infinite);
    // Two standard errors of 1/4, 1/2, 1 and none of differences of -1, -1, +1 and +1, of 2 + 2.
    const Plane beyond =
        relative_errors(row({1, 1, 3, 3, 2}), row({2, 2, 2, 2, 2}), 2, row({0.25, 0.5, 1, 0, nan_value}), 2);
    CHECK(beyond.texels[0] == -0.125);
    CHECK(beyond.texels[1] == 0);
    CHECK(beyond.texels[2] == 0);
    CHECK(beyond.texels[3] == 0.25);
    CHECK(std::isnan(beyond.texels[4]));
}

TEST_CASE("signed error: blue is too dark, red too bright, white neither, green no number", "[compare]") {
    CHECK(signed_color(0, 1) == glm::vec3(1));
    const glm::vec3 dark = signed_color(-1, 1), bright = signed_color(1, 1);
    CHECK((dark.z > dark.x && dark.z > dark.y));
    CHECK((bright.x > bright.y && bright.x > bright.z));
    CHECK(signed_color(-7, 1) == dark);
    CHECK(signed_color(infinite, 1) == bright);
    CHECK(signed_color(0.25, 0.5).y == Approx((1 + bright.y) / 2));
    CHECK(signed_color(nan_value, 1) == glm::vec3(0, 1, 0));
    CHECK(signed_color(1, 0) == glm::vec3(0, 1, 0));
}

TEST_CASE("signed error: luminance by ISR (17)", "[compare][ISR 17]") {
    Image4 image(2, 1);
    image.texels[0] = {1, 0, 0, 9};
    image.texels[1] = {1, 2, 4, 9};
    const Plane plane = luminances(image);
    CHECK(plane.texels[0] == 0.27);
    CHECK(plane.texels[1] == Approx(0.27 + 1.34 + 0.24).epsilon(1e-15));
}
