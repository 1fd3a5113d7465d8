// The comparator against planted errors (verification.md 2). Each states what the metrics must be, in closed form, and
// each bound is tried on both sides.
#include "core/compare.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "core/compare_metrics.h"
#include "core/compare_pictures.h"
#include "core/error.h"

using namespace plumb::compare;
using Limits = std::numeric_limits<float>;

namespace {

const float nan_value = Limits::quiet_NaN(), infinite = Limits::infinity();

Picture make(int width, int height, const std::function<float(int x, int y, int c)>& value,
             std::vector<std::string> channels = {"R", "G", "B"}) {
    Picture picture{std::move(channels), width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < int(picture.channels.size()); ++c) picture.data.push_back(value(x, y, c));
        }
    }
    return picture;
}

Picture flat(int width, int height, float value) {
    return make(width, height, [=](int, int, int) { return value; });
}

// 16 x 16, not flat, values 0.5 .. 0.75 in steps of 1/64; 768 values.
Picture base() {
    return make(16, 16, [](int x, int y, int c) { return 0.5f + float((x + 3 * y + 5 * c) % 17) / 64; });
}

float& at(Picture& p, int x, int y, int c) { return p.data[(std::size_t(y) * p.width + x) * p.channels.size() + c]; }

Options ldr() {
    Options options;
    options.encoding = Encoding::ldr_linear;
    options.threads = 1;
    return options;
}

Options bounded(std::optional<double> error, std::optional<std::uint32_t> ulp, std::optional<double> differing) {
    Options options = ldr();
    options.max_error = error;
    options.max_ulp = ulp;
    options.max_differing = differing;
    return options;
}

double below(double value) { return std::nextafter(value, 0.0); }

// No bound, however wide, may make it agree.
void require_disagreement(const Picture& a, const Picture& b) {
    CHECK_FALSE(compare(a, b, ldr()).agree);
    const Report report = compare(a, b, bounded(1e300, saturated_ulp, 1));
    CHECK_FALSE(report.agree);
    CHECK_FALSE(report.reason.empty());
    CHECK(report.reason.find('\n') == std::string::npos);
    CHECK_FALSE(report.equal);
    CHECK(report.max_ulp == saturated_ulp);
    for (const auto& metric : {report.mean_error, report.rmse, report.rel_mse, report.psnr, report.ssim, report.flip,
                               report.pearson}) {
        CHECK_FALSE(metric.has_value());
    }
}

}  // namespace

TEST_CASE("compare: equal pictures", "[compare]") {
    const Report report = compare(base(), base(), bounded(0, 0, 0));
    CHECK(report.agree);
    CHECK(report.reason.empty());
    CHECK(report.equal);
    CHECK(report.sizes_match);
    CHECK(report.channels_match);
    CHECK(report.mean_error.value() == 0);
    CHECK(report.rmse.value() == 0);
    CHECK(report.rel_mse.value() == 0);
    CHECK(report.psnr.value() == std::numeric_limits<double>::infinity());
    CHECK(report.ssim.value() == 1);
    CHECK(report.flip.value() == 0);
    CHECK(report.pearson.value() == Approx(1).epsilon(1e-14));
    CHECK(report.max_ulp == 0);
    CHECK(report.differing == 0);
    CHECK(report.pixels == 256);
    CHECK(report.nonfinite == 0);
    CHECK_FALSE(report.worst.has_value());
}

TEST_CASE("compare: one pixel off by one ULP", "[compare][planted]") {
    // 0.5 and its neighbour differ by 2^-24. Over 768 values: mean 2^-24/768, mean square 2^-48/768, relative to
    // 0.5^2 + 0.01 = 0.26; PSNR with peak 1 is 10 log10(768 * 2^48).
    Picture a = base(), b = base();
    at(b, 7, 9, 1) = 0.5f;
    at(a, 7, 9, 1) = std::nextafter(0.5f, 1.0f);
    const double difference = std::ldexp(1.0, -24);
    const Report report = compare(a, b, ldr());
    CHECK(report.mean_error.value() == Approx(difference / 768).epsilon(1e-14));
    CHECK(report.rmse.value() == Approx(difference / std::sqrt(768.0)).epsilon(1e-14));
    CHECK(report.rel_mse.value() == Approx(difference * difference / 0.26 / 768).epsilon(1e-14));
    CHECK(report.psnr.value() == Approx(10 * std::log10(768 * std::ldexp(1.0, 48))).epsilon(1e-14));
    CHECK(report.max_ulp == 1);
    CHECK(report.differing == 1.0 / 256);
    CHECK_FALSE(report.equal);
    CHECK(report.max_absolute == difference);
    CHECK(report.worst.value().x == 7);
    CHECK(report.worst.value().y == 9);
    CHECK(report.worst.value().channel == "G");
    CHECK(report.worst.value().b == 0.5f);
    CHECK(report.agree);  // no bound is set

    // Each bound holds at the value itself and breaks just below.
    CHECK(compare(a, b, bounded({}, 1, {})).agree);
    CHECK_FALSE(compare(a, b, bounded({}, 0, {})).agree);
    CHECK(compare(a, b, bounded({}, {}, 1.0 / 256)).agree);
    CHECK_FALSE(compare(a, b, bounded({}, {}, below(1.0 / 256))).agree);
    CHECK(compare(a, b, bounded(report.mean_error, {}, {})).agree);
    CHECK_FALSE(compare(a, b, bounded(below(*report.mean_error), {}, {})).agree);
    // One broken bound of three is enough.
    CHECK_FALSE(compare(a, b, bounded(1, 0, 1)).agree);
    CHECK(compare(a, b, bounded(1, 1, 1)).agree);
}

TEST_CASE("compare: a ramp shifted by one pixel", "[compare][planted]") {
    // b = x/16, a = ((x + 1) mod 16)/16: 15 columns differ by 1/16 and one by 15/16. Mean (30/16)/16, mean square
    // (240/256)/16 = 15/256. With sums over x of (x - 7.5)^2 = 340 and of the product = 1120 - 900 = 220, r = 11/17.
    const Picture b = make(16, 16, [](int x, int, int) { return float(x) / 16; });
    const Picture a = make(16, 16, [](int x, int, int) { return float((x + 1) % 16) / 16; });
    const Report report = compare(a, b, ldr());
    CHECK(report.mean_error.value() == Approx(30.0 / 256).epsilon(1e-14));
    CHECK(report.rmse.value() == Approx(std::sqrt(15.0 / 256)).epsilon(1e-14));
    CHECK(report.psnr.value() == Approx(10 * std::log10(256.0 / 15)).epsilon(1e-14));
    CHECK(report.pearson.value() == Approx(11.0 / 17).epsilon(1e-14));
    CHECK(report.differing == 1);
    CHECK(report.ssim.value() < 1);
    CHECK(report.flip.value() > 0);
    CHECK(compare(a, b, bounded(30.0 / 256, {}, {})).agree);
    CHECK_FALSE(compare(a, b, bounded(below(30.0 / 256), {}, {})).agree);
}

TEST_CASE("compare: red and blue swapped", "[compare][planted]") {
    // (3/4, 1/2, 1/4) against (1/4, 1/2, 3/4): mean 1/3, mean square 1/6, correlation -1; relative error
    // (0.25/0.0725 + 0 + 0.25/0.5725)/3.
    const Picture b = make(12, 12, [](int, int, int c) { return 0.25f * float(c + 1); });
    const Picture a = make(12, 12, [](int, int, int c) { return 0.25f * float(3 - c); });
    const Report report = compare(a, b, ldr());
    CHECK(report.mean_error.value() == Approx(1.0 / 3).epsilon(1e-14));
    CHECK(report.rmse.value() == Approx(std::sqrt(1.0 / 6)).epsilon(1e-14));
    CHECK(report.rel_mse.value() == Approx((0.25 / 0.0725 + 0.25 / 0.5725) / 3).epsilon(1e-14));
    CHECK(report.pearson.value() == Approx(-1).epsilon(1e-14));
    CHECK(report.flip.value() > 0.3);
    CHECK(report.differing == 1);

    // The same data under swapped names is another set of channels.
    Picture renamed = b;
    std::swap(renamed.channels[0], renamed.channels[2]);
    require_disagreement(renamed, b);
    CHECK_FALSE(compare(renamed, b).channels_match);
    CHECK(compare(renamed, b).sizes_match);
}

TEST_CASE("compare: a NaN or an infinity on either side or on both disagrees", "[compare][planted]") {
    for (const float bad : {nan_value, -nan_value, infinite, -infinite}) {
        for (const int side : {1, 2, 3}) {
            Picture a = base(), b = base();
            if (side & 1) at(a, 3, 15, 2) = bad;
            if (side & 2) at(b, 3, 15, 2) = bad;
            CAPTURE(bad, side);
            require_disagreement(a, b);
            const Report report = compare(a, b, ldr());
            CHECK(report.nonfinite == 1);
            CHECK(report.pixels == 256);
            CHECK(report.differing == 1.0 / 256);
            CHECK(report.reason.find(side & 1 ? "A(3, 15).B" : "B(3, 15).B") != std::string::npos);
        }
    }
    // Two channels of one pixel are one pixel; another pixel is another.
    Picture a = base();
    at(a, 0, 0, 0) = at(a, 0, 0, 1) = at(a, 5, 0, 0) = nan_value;
    CHECK(compare(a, base(), ldr()).nonfinite == 2);
}

TEST_CASE("compare: a gradient of error", "[compare][planted]") {
    // a = 1/2 + x/32 against 1/2, x = 0..15: mean (120/32)/16, mean square (1240/1024)/16, relative to 0.26. b is flat,
    // so no correlation.
    const Picture b = flat(16, 16, 0.5f);
    const Picture a = make(16, 16, [](int x, int, int) { return 0.5f + float(x) / 32; });
    const Report report = compare(a, b, ldr());
    CHECK(report.mean_error.value() == Approx(120.0 / 512).epsilon(1e-14));
    CHECK(report.rmse.value() == Approx(std::sqrt(1240.0 / 16384)).epsilon(1e-14));
    CHECK(report.rel_mse.value() == Approx(1240.0 / 16384 / 0.26).epsilon(1e-14));
    CHECK_FALSE(report.pearson.has_value());
    CHECK(report.differing == 15.0 / 16);
    CHECK(report.worst.value().x == 15);
    CHECK(report.worst.value().y == 0);
    CHECK(compare(a, b, bounded({}, {}, 15.0 / 16)).agree);
    CHECK_FALSE(compare(a, b, bounded({}, {}, below(15.0 / 16))).agree);
}

TEST_CASE("compare: one large error in a large picture", "[compare][planted]") {
    // 1024 x 512 values of 1, one of 1048577: 2^20 too much. Mean 2^20/2^19, mean square 2^40/2^19, share 2^-19.
    const Picture b = make(1024, 512, [](int, int, int) { return 1.0f; }, {"Y"});
    Picture a = b;
    at(a, 1000, 500, 0) = 1048577.0f;
    Options options = ldr();
    options.perceptual = false;
    const Report report = compare(a, b, options);
    CHECK(report.mean_error.value() == 2);
    CHECK(report.rmse.value() == std::sqrt(2097152.0));
    CHECK(report.max_absolute == 1048576);
    CHECK(report.worst.value().x == 1000);
    CHECK(report.worst.value().y == 500);
    CHECK(report.differing == std::ldexp(1.0, -19));
    // 1048577 = (1 + 2^-20) 2^20: 20 exponents up, and 8 steps of 2^-23.
    CHECK(report.max_ulp == (20u << 23) + 8);
    CHECK_FALSE(report.ssim.has_value());
    CHECK_FALSE(report.flip.has_value());
    for (const std::uint32_t bound : {(20u << 23) + 7, (20u << 23) + 8}) {
        options.max_ulp = bound;
        CHECK(compare(a, b, options).agree == (bound == report.max_ulp));
    }
}

TEST_CASE("compare: pictures that cannot be compared disagree", "[compare][planted]") {
    require_disagreement(flat(4, 3, 1), flat(3, 4, 1));
    CHECK(compare(flat(4, 3, 1), flat(3, 4, 1)).reason == "sizes differ: A is 4 x 3, B is 3 x 4");
    CHECK_FALSE(compare(flat(4, 3, 1), flat(3, 4, 1)).sizes_match);

    Picture grey = make(4, 3, [](int, int, int) { return 1.0f; }, {"R"});
    require_disagreement(flat(4, 3, 1), grey);
    CHECK(compare(flat(4, 3, 1), grey).reason == "channels differ: A has R,G,B, B has R");

    require_disagreement(Picture{}, Picture{});
    require_disagreement(flat(4, 3, 1), Picture{});
    require_disagreement(Picture{}, flat(4, 3, 1));
    require_disagreement(Picture{{}, 4, 3, {}}, Picture{{}, 4, 3, {}});
    require_disagreement(Picture{{"R"}, -1, -1, {1}}, Picture{{"R"}, -1, -1, {1}});

    // Fewer values than the size promises, on either side.
    Picture cut = flat(4, 3, 1);
    cut.data.pop_back();
    require_disagreement(cut, flat(4, 3, 1));
    require_disagreement(flat(4, 3, 1), cut);
    CHECK(compare(flat(4, 3, 1), cut).reason == "B holds 35 values, expected 36");
}

TEST_CASE("compare: zeros of unlike sign are at distance 0 but not equal", "[compare]") {
    // 1/x tells them apart, and the promise is equal bits.
    const Report report = compare(flat(12, 12, -0.0f), flat(12, 12, 0.0f), ldr());
    CHECK(report.mean_error.value() == 0);
    CHECK(report.max_ulp == 0);
    CHECK(report.differing == 1);
    CHECK_FALSE(report.equal);
    CHECK(compare(flat(12, 12, -0.0f), flat(12, 12, 0.0f), bounded(0, 0, {})).agree);
    CHECK_FALSE(compare(flat(12, 12, -0.0f), flat(12, 12, 0.0f), bounded(0, 0, 0)).agree);
}

TEST_CASE("compare: ULP distance along the ordered floats", "[compare]") {
    const float tiny = Limits::denorm_min();
    CHECK(ulp_distance(0.0f, -0.0f) == 0);
    CHECK(ulp_distance(0.0f, tiny) == 1);
    CHECK(ulp_distance(-tiny, tiny) == 2);
    CHECK(ulp_distance(-1.0f, std::nextafter(-1.0f, 0.0f)) == 1);
    CHECK(ulp_distance(1.0f, 2.0f) == 1u << 23);
    CHECK(ulp_distance(2.0f, 1.0f) == 1u << 23);
    CHECK(ulp_distance(Limits::lowest(), Limits::max()) == 2 * 0x7f7fffffu);
    for (const float bad : {nan_value, infinite, -infinite}) {
        CHECK(ulp_distance(bad, 1.0f) == saturated_ulp);
        CHECK(ulp_distance(1.0f, bad) == saturated_ulp);
        CHECK(ulp_distance(bad, bad) == saturated_ulp);
    }
}

TEST_CASE("compare: the extremes of float do not overflow", "[compare]") {
    const Picture a = make(12, 12, [](int x, int, int) { return x % 2 ? Limits::max() : Limits::lowest(); });
    const Picture b = make(12, 12, [](int x, int, int) { return x % 2 ? Limits::lowest() : Limits::max(); });
    Options options;
    const Report report = compare(a, b, options);
    CHECK(report.agree);
    CHECK(report.mean_error.value() == 2.0 * Limits::max());
    CHECK(report.rel_mse.value() == Approx(4).epsilon(1e-12));
    CHECK(report.pearson.value() == Approx(-1).epsilon(1e-12));
    for (const auto& metric : {report.rmse, report.psnr, report.ssim, report.flip}) {
        CHECK(std::isfinite(metric.value()));
    }
}

TEST_CASE("compare: the peak is 1 for a display, the brightest value of the reference in general", "[compare]") {
    // 4 against 2: mse 4. PSNR 10 log10(peak^2/4), SSIM of flat pictures (2 p q + c1)/(p^2 + q^2 + c1).
    const Picture a = flat(12, 12, 4), b = flat(12, 12, 2);
    auto expected_ssim = [](double peak) { return (16 + 1e-4 * peak * peak) / (20 + 1e-4 * peak * peak); };
    Options options = ldr();
    CHECK(compare(a, b, options).psnr.value() == Approx(10 * std::log10(1 / 4.0)).epsilon(1e-14));
    CHECK(compare(a, b, options).ssim.value() == Approx(expected_ssim(1)).epsilon(1e-9));
    options.encoding = Encoding::hdr;
    CHECK(compare(a, b, options).psnr.value() == Approx(0).margin(1e-14));
    CHECK(compare(a, b, options).ssim.value() == Approx(expected_ssim(2)).epsilon(1e-9));
    options.peak = 255;
    CHECK(compare(a, b, options).psnr.value() == Approx(10 * std::log10(65025 / 4.0)).epsilon(1e-14));
    CHECK(compare(a, b, options).ssim.value() == Approx(expected_ssim(255)).epsilon(1e-9));

    // A black reference has no peak.
    options.peak.reset();
    const Report black = compare(a, flat(12, 12, 0), options);
    CHECK_FALSE(black.psnr.has_value());
    CHECK_FALSE(black.ssim.has_value());
    CHECK(black.flip.value() > 0);
    CHECK(black.rel_mse.value() == Approx(1600).epsilon(1e-14));
}

TEST_CASE("compare: channels of one layer are RGB, those of two are not", "[compare]") {
    auto ramp = [](int x, int, int c) { return float(x + c) / 16; };
    const Picture plain = make(12, 12, ramp), layer = make(12, 12, ramp, {"indirect.R", "indirect.G", "indirect.B"});
    const auto expected = linear_rgb(plain, Encoding::hdr), got = linear_rgb(layer, Encoding::hdr);
    CHECK(got.value().texels == expected.value().texels);
    CHECK(expected.value()(3, 0) == glm::dvec3(3 / 16.0, 4 / 16.0, 5 / 16.0));

    // The order of the names decides, other channels do not count.
    const Picture mixed = make(1, 1, [](int, int, int c) { return float(c); }, {"A", "B", "Z", "G", "R"});
    CHECK(linear_rgb(mixed, Encoding::hdr).value()(0, 0) == glm::dvec3(4, 3, 1));

    CHECK(linear_rgb(make(1, 1, ramp, {"depth"}), Encoding::hdr).has_value());
    CHECK_FALSE(linear_rgb(make(1, 1, ramp, {"R", "G"}), Encoding::hdr).has_value());
    CHECK_FALSE(linear_rgb(make(1, 1, ramp, {"X", "Y", "Z"}), Encoding::hdr).has_value());
    CHECK_FALSE(linear_rgb(make(1, 1, ramp, {"a.R", "a.G", "a.B", "b.R", "b.G", "b.B"}), Encoding::hdr).has_value());

    const Picture positions = make(12, 12, ramp, {"X", "Y", "Z"});
    const Report report = compare(positions, positions, bounded(0, 0, 0));
    CHECK(report.agree);
    CHECK_FALSE(report.ssim.has_value());
    CHECK_FALSE(report.flip.has_value());
}

TEST_CASE("compare: FLIP sees encoded values as the light of the display", "[compare]") {
    // 188/255 encodes 0.502886 (IEC 61966-2-1): the same two colours, once encoded and once linear.
    const float code = 188 / 255.0f, light = float(std::pow((188 / 255.0 + 0.055) / 1.055, 2.4));
    Options options = ldr();
    const double linear = compare(flat(12, 12, light), flat(12, 12, 1), options).flip.value();
    options.encoding = Encoding::ldr_srgb;
    const double encoded = compare(flat(12, 12, code), flat(12, 12, 1), options).flip.value();
    CHECK(encoded == Approx(linear).epsilon(1e-6));
    CHECK(compare(flat(12, 12, light), flat(12, 12, 1), options).flip.value() > encoded + 0.1);
}

TEST_CASE("compare: b is the reference of HDR-FLIP", "[compare]") {
    // The exposures follow from the reference, and the two pictures give different ones.
    const Picture a = flat(16, 16, 0.5f), b = base();
    Options options;
    options.threads = 1;
    const auto rgb_a = *linear_rgb(a, Encoding::hdr), rgb_b = *linear_rgb(b, Encoding::hdr);
    const double expected = flip_hdr(rgb_b, rgb_a, default_pixels_per_degree, 1).mean;
    CHECK(compare(a, b, options).flip.value() == expected);
    CHECK(compare(b, a, options).flip.value() != expected);
}

TEST_CASE("compare: the same bits for every number of threads", "[compare][bits]") {
    auto value = [](int x, int y, int c) { return float((x * x + 3 * y * y + 50 * c) % 251) / 97; };
    const Picture b = make(41, 53, value);
    const Picture a = make(41, 53, [&](int x, int y, int c) { return value(x, y, c) + float((x * y) % 5) / 31; });
    Options options;
    options.threads = 1;
    const Report one = compare(a, b, options);
    for (const int threads : {2, 3, 0}) {
        options.threads = threads;
        const Report other = compare(a, b, options);
        CHECK(other.mean_error == one.mean_error);
        CHECK(other.rmse == one.rmse);
        CHECK(other.rel_mse == one.rel_mse);
        CHECK(other.psnr == one.psnr);
        CHECK(other.ssim == one.ssim);
        CHECK(other.flip == one.flip);
        CHECK(other.pearson == one.pearson);
        CHECK(other.max_ulp == one.max_ulp);
        CHECK(other.differing == one.differing);
    }
}

TEST_CASE("compare: options out of range are refused by name", "[compare]") {
    auto refuses = [](const Options& options, const char* name) {
        CHECK_THROWS_WITH(compare(base(), base(), options), Catch::Contains(name) && Catch::Contains("expected"));
        CHECK_THROWS_AS(compare(base(), base(), options), plumb::InputError);
    };
    const double nan = std::nan("");
    for (const double bad : {-1.0, nan}) refuses(bounded(bad, {}, {}), "max_error");
    for (const double bad : {-0.1, 1.1, nan}) refuses(bounded({}, {}, bad), "max_differing");
    for (const double bad : {0.0, -1.0, nan, 1.0 / 0.0}) {
        Options options;
        options.peak = bad;
        refuses(options, "peak");
    }
    for (const double bad : {0.5, 1001.0, nan}) {
        Options options;
        options.pixels_per_degree = bad;
        refuses(options, "pixels_per_degree");
    }
    Options options;
    options.threads = -1;
    refuses(options, "threads");
}

TEST_CASE("compare: difference pictures", "[compare]") {
    // a - b = -1/8, 0, 1/4, 2.
    const std::vector<std::string> channels = {"R", "G", "B", "A"};
    const Picture a{channels, 1, 1, {0.125f, 0.5f, 0.75f, 3}}, b{channels, 1, 1, {0.25f, 0.5f, 0.5f, 1}};
    CHECK(difference(a, b).data == std::vector<float>{0.125f, 0, 0.25f, 2});
    CHECK(difference(a, b, Difference::signed_).data == std::vector<float>{-0.125f, 0, 0.25f, 2});
    CHECK(difference(a, b, Difference::signed_, 4).data == std::vector<float>{-0.5f, 0, 1, 8});
    CHECK(difference(a, b, Difference::negative).data == std::vector<float>{0.875f, 1, 0.75f, 0});
    CHECK(difference(a, b, Difference::negative, 2).data == std::vector<float>{0.75f, 1, 0.5f, 0});
    CHECK(difference(a, b).channels == channels);

    // What is not a number stays visible.
    Picture bad = a;
    bad.data = {nan_value, infinite, 0, 0};
    for (const Difference kind : {Difference::absolute, Difference::negative, Difference::signed_}) {
        CHECK(std::isnan(difference(bad, b, kind).data[0]));
        CHECK(std::isnan(difference(b, bad, kind).data[0]));
    }
    CHECK(std::isnan(difference(bad, bad).data[1]));
    CHECK(difference(bad, b).data[1] == infinite);

    CHECK_THROWS_AS(difference(a, flat(1, 1, 0)), plumb::InputError);
    CHECK_THROWS_AS(difference(Picture{}, Picture{}), plumb::InputError);
    for (const double amplification : {0.0, -1.0, std::nan(""), 1.0 / 0.0}) {
        CHECK_THROWS_WITH(difference(a, b, Difference::absolute, amplification), Catch::Contains("amplification"));
    }
}

TEST_CASE("compare: quality, gain and share of improved pixels", "[compare][ISR 21]") {
    CHECK(quality(0.1, 0.2) == 1);
    CHECK(quality(0.2, 0.1) == -1);
    CHECK(quality(0.2, 0.2) == 0);
    CHECK_THROWS_AS(quality(std::nan(""), 0), plumb::InputError);
    CHECK(gain(0.25, 0.125).value() == 0.5);
    CHECK(gain(0.25, 0.5).value() == -1);
    CHECK_FALSE(gain(0, 0.5).has_value());

    // ISR (17): weights that sum to 1, red 0.27.
    CHECK(luminance(glm::dvec3(1)) == Approx(1).epsilon(1e-15));
    CHECK(luminance(glm::dvec3(1, 0, 0)) == 0.27);

    // Four pixels of a grey 1/2; before: 1/4 everywhere; after: closer, as far, overshot farther, far.
    const float grey[4] = {0.375f, 0.25f, 0.8125f, 1};
    const Picture model = flat(4, 1, 0.5f), before = flat(4, 1, 0.25f);
    const Picture after = make(4, 1, [&](int x, int, int) { return grey[x]; });
    CHECK(share_improved(model, before, after).value() == 0.25);
    CHECK(share_improved(model, before, before).value() == 0);
    CHECK(share_improved(model, before, model).value() == 1);
    CHECK(share_improved(model, before, flat(4, 1, nan_value)).value() == 0);
    CHECK_THROWS_AS(share_improved(model, before, flat(1, 4, 0)), plumb::InputError);
}
