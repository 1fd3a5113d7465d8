// Percentage closer filtering, exponential shadow maps and the logarithmic blur of their depth maps (ISR 4.6).
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/direct/direct.h"
#include "gi/direct/log_blur.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;
using direct::ShadowMode;
using direct::ShadowParams;
using direct::ShadowVariant;

namespace {

constexpr double ulp = 0x1p-24;  // of a rounding, relative

// A spot at the origin that looks along -z with a half angle of 45 degrees and sees 4 m far: an occluder of depth 1
// covers x < 0, before a wall at depth 2.
raster::Rsm half_occluded(int size) {
    raster::Rsm map = empty_map(size);
    map.view.forward = {0, 0, -1};
    map.view.far = 4;
    map.view.view_to_clip = glm::dmat4(0);
    map.view.view_to_clip[0][0] = 1;
    map.view.view_to_clip[1][1] = -1;
    map.view.view_to_clip[3][2] = 1;
    map.view.view_to_clip[2][3] = -1;
    map.texel_scale = 2.0 / size;
    map.position = Image4(size, size, glm::vec4(0, 0, 0, 2));
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size / 2; ++x) map.position(x, y).w = 1;
    return map;
}

// A directional light that looks along -z at [-1, 1]^2 from a box `range` m deep, from z = 0 on.
raster::Rsm sun_map(int size, double range) {
    raster::Rsm map = plane_map(size, [](double, double) { return 0.0; });
    map.view.forward = {0, 0, -1};
    map.view.view_to_clip[2][2] = 1 / range;
    map.texel_scale = 2.0 / size;
    map.position = Image4(size, size);
    return map;
}

ShadowParams mode(ShadowMode m, ShadowVariant variant = ShadowVariant::corrected) {
    ShadowParams params;
    params.test = direct::ShadowTest::depth;
    params.mode = m, params.variant = variant;
    params.esm_blur_radius = 0;
    return params;
}

float visibility_at(const ShadowParams& params, const raster::Rsm& map, glm::vec3 x, glm::vec3 n,
                    std::span<const Image4> blurred = {}) {
    const Points point(x, n);
    float visibility = -1;
    direct::run(params, {&point.position, &point.normal, {&map, 1}, nullptr, blurred}, {}, &visibility);
    return visibility;
}

// The point of depth d that falls on texel coordinate (t, 32) of half_occluded(64).
glm::vec3 at_column(double t, double d) { return {float(d * (t / 32 - 1)), 0, float(-d)}; }

Image4 row_of(const std::vector<float>& depths) {
    Image4 map(int(depths.size()), 1);
    for (std::size_t i = 0; i < depths.size(); ++i) map.texels[i].w = depths[i];
    return map;
}

ShadowParams blur_params(double c, int radius, float sigma) {
    ShadowParams params = mode(ShadowMode::esm);
    params.esm_c = float(c), params.esm_blur_radius = radius, params.esm_blur_sigma = sigma;
    return params;
}

Image4 blurred_row(const ShadowParams& params, const Image4& map, double range = 1,
                   direct::Direction direction = direct::Direction::horizontal, const RunOptions& options = {}) {
    Image4 out;
    direct::run(params, direct::LogBlurInputs{&map, direction, range}, options, out);
    return out;
}

// log(sum w exp(c d) / sum w) / c in double, from the deepest tap on; the border repeats.
double exact_blur(const Buffer<float>& weights, const std::vector<double>& depths, int at, double c) {
    const int radius = int(weights.size()) / 2, last = int(depths.size()) - 1;
    double deepest = 0, less = 0, sum = 0, total = 0;
    auto tap = [&](int i) { return depths[std::size_t(std::clamp(at + i, 0, last))]; };
    for (int i = -radius; i <= radius; ++i) deepest = std::max(deepest, tap(i));
    for (int i = -radius; i <= radius; ++i) {
        const double w = weights[std::size_t(i + radius)], x = c * (tap(i) - deepest);
        less += w * std::expm1(x), sum += w * std::exp(x), total += w;
    }
    return deepest + (less / total > -0.5 ? std::log1p(less / total) : std::log(sum / total)) / c;
}

// How far the float kernel may be from that. Of n terms the sums round n times each, an exponent x twice, which moves
// exp(x) by 2 |x| ulp, at most 4 ulp of a sum that holds the deepest tap's weight; where the mean is below 3/4, its
// logarithm of at least 0.288 sees its error 1/0.288 times.
double allowed(std::size_t n, double deepest, double got, double exact) {
    return 4 * (2 * double(n) + 16) * ulp * (deepest - exact) + 2 * ulp * std::max(std::abs(got), deepest);
}

const double cs[] = {1e-3, 0.1, 1, 10, 90, 1e3, 1e6};

float noise(int x, int y, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 7).x); }

}  // namespace

TEST_CASE("pcf: behind a straight edge a ramp of one texel, where the hard test is a step", "[shadow][pcf][analytic]") {
    // The edge is the border between columns 31 and 32, at 32; their centres lie at 31.5 and 32.5.
    const raster::Rsm map = half_occluded(64);
    for (int i = 0; i <= 64; ++i) {
        const double t = 30 + i / 16.0;
        CAPTURE(t);
        const glm::vec3 x = at_column(t, 1.5);
        CHECK(visibility_at(mode(ShadowMode::hard), map, x, {0, 0, 1}) == (t < 32 ? 0 : 1));
        CHECK(visibility_at(mode(ShadowMode::pcf), map, x, {0, 0, 1}) == std::clamp(t - 31.5, 0.0, 1.0));
        CHECK(visibility_at(mode(ShadowMode::pcf), map, at_column(t, 0.5), {0, 0, 1}) == 1);
    }
    // The same along y.
    raster::Rsm turned = map;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) turned.position(x, y).w = map.position(y, x).w;
    for (int i = 0; i <= 64; ++i) {
        const double t = 30 + i / 16.0;
        const glm::vec3 along = at_column(t, 1.5), x(0, -along.x, along.z);
        CHECK(visibility_at(mode(ShadowMode::pcf), turned, x, {0, 0, 1}) == std::clamp(t - 31.5, 0.0, 1.0));
    }
}

TEST_CASE("esm: exp(-c delta), bilinear across an edge", "[shadow][esm][ISR (30)][analytic]") {
    const raster::Rsm map = half_occluded(64);
    for (double c : {0.5, 5.0, 90.0})
        for (double bias : {0.0, 0.001})
            for (double d : {0.5, 1.0, 1.25, 1.5, 2.0}) {
                ShadowParams params = mode(ShadowMode::esm);
                params.esm_c = float(c), params.bias = float(bias);
                const double exponent = c / 4 * std::max(0.0, d - 1 - double(params.bias)), full = host::exp(-exponent);
                for (int i = 0; i <= 64; ++i) {
                    const double t = 30 + i / 16.0, lit = std::clamp(t - 31.5, 0.0, 1.0);
                    CAPTURE(c, bias, d, t);
                    const float got = visibility_at(params, map, at_column(t, d), {0, 0, 1});
                    // The exponent rounds three times; the exponential errs by a unit, the blend rounds four times.
                    const double off = full * (3 * exponent + 2) * ulp;
                    CHECK(std::abs(got - (full + lit * (1 - full))) <= (lit == 0 ? off : off + 4 * ulp));
                }
            }
}

TEST_CASE("pcf, esm: what the map does not hold does not block", "[shadow][pcf][esm]") {
    raster::Rsm map = half_occluded(64);
    for (ShadowMode m : {ShadowMode::pcf, ShadowMode::esm}) {
        CHECK(visibility_at(mode(m), map, {-9, 0.1f, -1.5f}, {0, 0, 1}) == 1);   // outside
        CHECK(visibility_at(mode(m), map, {-0.5f, 0.1f, 1.5f}, {0, 0, 1}) == 1);  // behind the light
    }
    // At the map's corner, half a texel outside of its texels' centres, a quarter of the weight lies on the map.
    for (glm::vec4& texel : map.position.texels) texel.w = 1;
    CHECK(visibility_at(mode(ShadowMode::pcf), map, {-1.5f, 1.5f, -1.5f}, {0, 0, 1}) == 0.75f);
    for (glm::vec4& texel : map.position.texels) texel.w = 0;
    for (ShadowMode m : {ShadowMode::pcf, ShadowMode::esm})
        CHECK(visibility_at(mode(m), map, {-0.5f, 0.1f, -1.5f}, {0, 0, 1}) == 1);
}

TEST_CASE("pcf, esm: a tilted plane does not shadow itself, blurred or not", "[shadow][pcf][esm][acne]") {
    const int size = 64;
    for (double slope : {0.0, 0.5, 1.0, 4.0}) {
        raster::Rsm map = sun_map(size, 20);
        auto depth = [&](double u, double v) { return 10 + slope * u + 0.3 * v; };
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                map.position(x, y).w = float(depth((2 * x + 1.0) / size - 1, 1 - (2 * y + 1.0) / size));
        const glm::vec3 n = normalize3<float>(glm::vec3(float(slope), 0.3f, 1));
        int pcf_without = 0, esm_without = 0, points = 0;
        std::vector<Image4> blurred;
        direct::blur_maps(blur_params(90, 3, 1.5f), {&map, 1}, {}, blurred);
        for (double v = -0.85; v < 0.85; v += 0.0437)
            for (double u = -0.85; u < 0.85; u += 0.0431, ++points) {
                const glm::vec3 x(float(u), float(v), float(-depth(u, v)));
                for (ShadowMode m : {ShadowMode::pcf, ShadowMode::esm}) {
                    ShadowParams with = mode(m), without = with;
                    with.bias = without.bias = 1e-5f;
                    without.slope_bias = 0;
                    CAPTURE(slope, u, v, int(m));
                    // Weights sum to 1 but for their rounding.
                    CHECK(visibility_at(with, map, x, n) == 1);
                    if (m == ShadowMode::esm) CHECK(visibility_at(with, map, x, n, blurred) == 1);
                    (m == ShadowMode::pcf ? pcf_without : esm_without) += visibility_at(without, map, x, n) < 1;
                }
            }
        if (slope > 0) CHECK(pcf_without > points / 2);  // the bias is what prevents it
        if (slope > 0) CHECK(esm_without > points / 2);
    }
}

TEST_CASE("esm: Listing 8 as printed, on numbers worked out by hand", "[shadow][esm][ISR Listing 8]") {
    // ls.xy = (0.65, 0.45), times 4: (2.6, 1.8); ls.z = 5/8. saturate(dot(-n, direction)) = 0.8.
    raster::Rsm map = sun_map(4, 8);
    for (glm::vec4& texel : map.position.texels) texel.w = 0.5f;  // what no tap may read
    map.position(2, 1).w = 4, map.position(3, 1).w = 5.5f, map.position(2, 2).w = 2, map.position(3, 2).w = 0;
    const glm::vec3 x(0.3f, 0.1f, -5), n(0, 0.6f, 0.8f);
    ShadowParams params = mode(ShadowMode::esm, ShadowVariant::published);
    params.bias = 0.25f;  // z_bias = 0.0f
    // 5/8 - 4/8 = 1/8, 5/8 - 5.5/8 < 0, 5/8 - 2/8 = 3/8, 5/8 - 1 < 0; times 0.8: 0.1, 0, 0.3, 0.
    // c = 2: exp(-0.2) = 0.8187308, exp(-0.6) = 0.5488116.
    // lerp(0.8187308, 1, 0.6) = 0.9274923, lerp(0.5488116, 1, 0.6) = 0.8195247; lerp(.., .., 0.8) = 0.8411182.
    params.esm_c = 2;
    CHECK(visibility_at(params, map, x, n) == Approx(0.8411182).margin(1e-6));
    // c = 90: exp(-9) = 0.000123410, exp(-27) = 1.9e-12; 0.6000494 and 0.6; 0.6000099.
    params.esm_c = 90;
    CHECK(visibility_at(params, map, x, n) == Approx(0.6000099).margin(1e-6));
    // Corrected, the taps are (2, 1) .. (3, 2) with fractions 0.1 and 0.3, without the cosine:
    // exp(-2/8) = 0.7788008, 1; exp(-6/8) = 0.4723666, 1; 0.8009207, 0.5251299; 0.7181835.
    params.variant = ShadowVariant::corrected;
    params.esm_c = 2, params.bias = 0, params.slope_bias = 0;
    CHECK(visibility_at(params, map, x, n) == Approx(0.7181835).margin(1e-6));
}

TEST_CASE("pcf, esm: as printed, a shadow lies half a texel beside its place", "[shadow][pcf][esm][ISR Listing 8]") {
    raster::Rsm map = sun_map(64, 4);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) map.position(x, y).w = x < 32 ? 1.0f : 2.0f;
    for (int i = 0; i <= 64; ++i) {
        const double t = 30 + i / 16.0;
        const glm::vec3 x(float(t / 32 - 1), 0, -1.5f);
        CAPTURE(t);
        CHECK(visibility_at(mode(ShadowMode::pcf), map, x, {0, 0, 1}) == std::clamp(t - 31.5, 0.0, 1.0));
        CHECK(visibility_at(mode(ShadowMode::pcf, ShadowVariant::published), map, x, {0, 0, 1}) ==
              std::clamp(t - 31, 0.0, 1.0));
        const double full = host::exp(-90 * 0.125);
        CHECK(visibility_at(mode(ShadowMode::esm, ShadowVariant::published), map, x, {0, 0, 1}) ==
              Approx(full + (1 - full) * std::clamp(t - 31, 0.0, 1.0)).margin(1e-6));
    }
}

TEST_CASE("esm: as printed, a spot's points are not divided by w", "[shadow][esm][ISR Listing 8]") {
    // A wall in front of one column alone. At depth 2, clip x = 0.5: printed 0.5 + 0.25 of 64 texels is column 48;
    // divided it is 40.
    for (int column : {40, 48}) {
        raster::Rsm map = half_occluded(64);
        for (int y = 0; y < 64; ++y)
            for (int i = 0; i < 64; ++i) map.position(i, y).w = i == column ? 1.0f : 3.0f;
        const glm::vec3 printed_at(0.5f, 0, -2), corrected_at(2 * 8.5f / 32, 0, -2);
        for (ShadowMode m : {ShadowMode::pcf, ShadowMode::esm}) {
            const float printed = visibility_at(mode(m, ShadowVariant::published), map, printed_at, {0, 0, 1});
            const float corrected = visibility_at(mode(m), map, corrected_at, {0, 0, 1});
            CHECK((printed < 0.1f) == (column == 48));
            CHECK((corrected < 0.1f) == (column == 40));
        }
    }
}

TEST_CASE("esm: c is over the light's range, one for all faces of a point light", "[shadow][esm]") {
    raster::Rsm maps[6];
    for (int f = 0; f < 6; ++f) maps[f].view.far = 1 + f;
    CHECK(direct::depth_range(maps) == 6);
    CHECK(direct::c_per_metre(ShadowParams{}, maps) == 15);
    const raster::Rsm sun = sun_map(4, 8);
    CHECK(direct::depth_range({&sun, 1}) == 8);
    Light light;
    light.type = LightType::directional;
    light.direction = {1, -1, 0.5f};
    const View view = raster::light_view(light, {-1, 0, -1}, {2, 1, 3});
    const raster::Rsm drawn = raster::unseen_rsm(light, view);
    CHECK(direct::depth_range({&drawn, 1}) == Approx(drawn.texel_scale * drawn.size).epsilon(1e-12));
    const raster::Rsm none;
    CHECK(direct::depth_range({&none, 1}) == 1);
}

TEST_CASE("shadow.blur: a constant is that constant, bit for bit", "[shadow][blur][analytic]") {
    for (double c : cs)
        for (float depth : {1e-6f, 0.3f, 1.0f, 7.7f, 1e6f, 1e30f})
            for (int radius : {0, 1, 3, 32})
                for (float sigma : {0.05f, 1.5f, 1e6f}) {
                    CAPTURE(c, depth, radius, sigma);
                    const Image4 got = blurred_row(blur_params(c, radius, sigma), row_of(std::vector<float>(9, depth)));
                    for (const glm::vec4& texel : got.texels) CHECK(texel == glm::vec4(0, 0, 0, depth));
                }
}

TEST_CASE("shadow.blur: two depths against the formula in double", "[shadow][blur][ISR 4.6][analytic]") {
    const float depths[] = {1e-6f, 1e-3f, 0.25f, 1, 1.0001f, 3, 1e3f, 1e6f};
    for (double c : cs)
        for (float near : depths)
            for (float far : depths)
                for (auto [radius, sigma] : {std::pair{1, 1.0f}, {3, 1.5f}, {8, 4.0f}}) {
                    const ShadowParams params = blur_params(c, radius, sigma);
                    const Buffer<float> weights = direct::blur_weights(params);
                    // A step in the middle of a row.
                    std::vector<float> row(24, near);
                    std::fill(row.begin() + 12, row.end(), far);
                    const Image4 got = blurred_row(params, row_of(row));
                    const std::vector<double> exactly(row.begin(), row.end());
                    for (int i = 0; i < 24; ++i) {
                        const double exact = exact_blur(weights, exactly, i, double(float(c)));
                        const float d = got(i, 0).w;
                        CAPTURE(c, near, far, radius, i, d, exact);
                        const bool near_exact =
                            std::abs(d - exact) <= allowed(weights.size(), std::max(near, far), d, exact);
                        const bool between = d >= std::min(near, far) && d <= std::max(near, far);
                        CHECK((near_exact && between));
                    }
                }
}

TEST_CASE("shadow.blur: nothing overflows, is lost or is no number", "[shadow][blur][extreme]") {
    const float depths[] = {0, 1e-38f, 1e-6f, 1, 1e6f, 1e30f, 3e38f};
    for (double c : {1e-3, 1.0, 90.0, 1e6, 1e9})
        for (double range : {1e-6, 1.0, 1e6, 1e15})
            for (float a : depths)
                for (float b : depths)
                    for (float sigma : {0.05f, 1.5f}) {
                        CAPTURE(c, range, a, b, sigma);
                        const Image4 got = blurred_row(blur_params(c, 3, sigma), row_of({a, a, b, a, b, b, b}), range);
                        for (const glm::vec4& texel : got.texels) {
                            const bool none = a == 0 && b == 0;
                            CHECK((none ? texel.w == 0 : texel.w > 0 && texel.w <= 3.1e38f));
                        }
                    }
}

TEST_CASE("shadow.blur: deeper taps and a larger c give no nearer depth", "[shadow][blur][analytic]") {
    for (auto [near, far] : {std::pair{1.0f, 2.0f}, {1.0f, 1.001f}, {0.5f, 30.0f}}) {
        double before = 0;
        for (double c = 1e-3; c < 1e6; c *= 2) {
            const ShadowParams params = blur_params(c, 3, 1.5f);
            const double d = blurred_row(params, row_of({near, near, near, far, near, near, near}))(3, 0).w;
            CAPTURE(c, near, far);
            CHECK(d >= before - 2 * allowed(7, far, float(d), d));
            before = d;
        }
        CHECK(before == Approx(far).epsilon(1e-5));  // the largest c: the deepest tap, but for its weight
    }
    for (double c : cs) {
        double before = 0;
        for (float far = 1; far < 4; far += 1 / 64.0f) {
            const double d = blurred_row(blur_params(c, 3, 1.5f), row_of({1, 1, 1, far, 1, 1, 1}))(3, 0).w;
            CAPTURE(c, far);
            CHECK(d >= before - 2 * allowed(7, far, float(d), d));
            before = d;
        }
    }
}

TEST_CASE("shadow.blur: along rows and columns is the blur over a square", "[shadow][blur][analytic]") {
    raster::Rsm map = sun_map(16, 8);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) map.position(x, y).w = 1 + 3 * noise(x, y, 0);
    for (double c : {0.5, 8.0, 90.0}) {
        const ShadowParams params = blur_params(c, 2, 1);
        const Buffer<float> w = direct::blur_weights(params);
        std::vector<Image4> blurred;
        direct::blur_maps(params, {&map, 1}, {}, blurred);
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x) {
                double sum = 0, total = 0;
                for (int j = -2; j <= 2; ++j)
                    for (int i = -2; i <= 2; ++i) {
                        const float stored = map.position(std::clamp(x + i, 0, 15), std::clamp(y + j, 0, 15)).w;
                        const double weight = double(w[std::size_t(i + 2)]) * w[std::size_t(j + 2)];
                        sum += weight * std::exp(c / 8 * (stored - 8.0));
                        total += weight;
                    }
                const double exact = 8 + std::log(sum / total) * 8 / c;
                CAPTURE(c, x, y);
                CHECK(std::abs(blurred[0](x, y).w - exact) <= 2 * allowed(5, 8, 8, exact));
            }
    }
}

TEST_CASE("shadow.blur: texels where nothing is drawn have no weight", "[shadow][blur][analytic]") {
    for (double c : cs) {
        // Between holes a constant stays what it is; beyond the radius, nothing stays nothing.
        const Image4 got = blurred_row(blur_params(c, 2, 1), row_of({0, 0, 0, 2.5f, 0, 2.5f, 2.5f, 0, 0, 0, 0}));
        for (int i = 0; i < 11; ++i) CHECK(got(i, 0).w == (i >= 1 && i <= 8 ? 2.5f : 0));
        // Of two depths: w1 exp(c 1) + w2 exp(c 2), the hole between left out.
        const ShadowParams params = blur_params(c, 2, 1);
        const Buffer<float> w = direct::blur_weights(params);
        const double k = double(float(c)), less = w[1] * std::expm1(-k) / (double(w[1]) + double(w[4]));
        const double rest = (w[1] * std::exp(-k) + w[4]) / (double(w[1]) + double(w[4]));
        const double exact = 2 + (less > -0.5 ? std::log1p(less) : std::log(rest)) / k;
        const float d = blurred_row(params, row_of({0, 1, 0, 0, 2}))(2, 0).w;
        CAPTURE(c, d, exact);
        CHECK(std::abs(d - exact) <= allowed(5, 2, d, exact));
    }
}

// What ISR 4.6 blurs the map for: across an edge the light grows over several texels.
TEST_CASE("esm: a blurred map widens the border of a shadow", "[shadow][esm][blur]") {
    raster::Rsm map = half_occluded(64);
    for (glm::vec4& texel : map.position.texels)
        if (texel.w == 2) texel.w = 1.5f;
    std::vector<Image4> blurred;
    const ShadowParams params = blur_params(90, 4, 2);
    direct::blur_maps(params, {&map, 1}, {}, blurred);
    int sharp = 0, soft = 0;
    float before = -1;
    for (int i = 0; i < 16 * 16; ++i) {
        const glm::vec3 x = at_column(24 + i / 16.0, 1.5);
        const float hard_edge = visibility_at(params, map, x, {0, 0, 1});
        const float v = visibility_at(params, map, x, {0, 0, 1}, blurred);
        CHECK(v >= before);  // the texels' depths grow towards the light
        before = v;
        sharp += hard_edge > 0.01f && hard_edge < 0.99f;
        soft += v > 0.01f && v < 0.99f;
    }
    CHECK(sharp <= 16);
    CHECK(soft >= 2 * 16);
}

TEST_CASE("esm: a background far behind the receiver lights a border of radius - 1/2 texels", "[shadow][esm][blur]") {
    raster::Rsm map = half_occluded(64);
    for (glm::vec4& texel : map.position.texels)
        if (texel.w == 2) texel.w = 3.5f;
    for (int radius : {1, 3, 6}) {
        const ShadowParams params = blur_params(90, radius, 1.5f);
        std::vector<Image4> blurred;
        direct::blur_maps(params, {&map, 1}, {}, blurred);
        // The first texel whose window holds the background is 32 - radius, its centre half a texel further.
        const double first = 32 - radius + 0.5;
        CAPTURE(radius);
        CHECK(visibility_at(params, map, at_column(first, 1.5), {0, 0, 1}, blurred) == 1);
        const float beside = visibility_at(params, map, at_column(first - 0.25, 1.5), {0, 0, 1}, blurred);
        CHECK(beside == Approx(0.75).margin(1e-3));
        CHECK(visibility_at(params, map, at_column(first - 1, 1.5), {0, 0, 1}, blurred) < 1e-4f);
        CHECK(visibility_at(params, map, at_column(31.75, 1.5), {0, 0, 1}) < 0.3f);  // not without the blur
    }
}

TEST_CASE("pcf, esm, shadow.blur: the same bits for every instruction set and thread count", "[shadow][blur][bits]") {
    const int size = 24;
    for (glm::ivec2 frame : {glm::ivec2(1, 1), {3, 2}, {17, 5}, {64, 33}}) {
        Points points(frame.x, frame.y);
        for (int y = 0; y < frame.y; ++y)
            for (int x = 0; x < frame.x; ++x) {
                points.position(x, y) = {2 * noise(x, y, 0) - 1, 2 * noise(x, y, 1) - 1, -1 - 2 * noise(x, y, 2), 0};
                const glm::vec3 n(noise(x, y, 3) - 0.5f, noise(x, y, 4) - 0.5f, noise(x, y, 5));
                points.normal(x, y) = glm::vec4(normalize3<float>(n), 1);
            }
        raster::Rsm map = half_occluded(size);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) map.position(x, y).w = noise(x, y, 7) < 0.1f ? 0 : 1 + 2 * noise(x, y, 6);
        std::vector<Image4> first_blur;
        RunOptions scalar;
        scalar.isa = Isa::scalar, scalar.threads = 1;
        const ShadowParams of_blur = blur_params(90, 3, 1.5f);
        direct::blur_maps(of_blur, {&map, 1}, scalar, first_blur);
        for (Isa isa : supported_isas())
            for (int threads : {1, 3}) {
                CAPTURE(isa_name(isa), threads, frame.x);
                RunOptions options;
                options.isa = isa, options.threads = threads;
                std::vector<Image4> blurred;
                direct::blur_maps(of_blur, {&map, 1}, options, blurred);
                CHECK(std::memcmp(blurred[0].data(), first_blur[0].data(), blurred[0].size() * 16) == 0);
                for (ShadowMode m : {ShadowMode::pcf, ShadowMode::esm})
                    for (ShadowVariant variant : {ShadowVariant::corrected, ShadowVariant::published}) {
                        std::vector<float> a(points.position.size(), -1), b(a.size(), -2);
                        const direct::ShadowInputs in{&points.position, &points.normal, {&map, 1}, nullptr,
                                                      variant == ShadowVariant::corrected ? std::span(blurred)
                                                                                          : std::span<Image4>()};
                        direct::run(mode(m, variant), in, scalar, a.data());
                        direct::run(mode(m, variant), in, options, b.data());
                        CHECK(std::memcmp(a.data(), b.data(), a.size() * 4) == 0);
                        for (float v : a) CHECK((v >= 0 && v <= 1));
                    }
            }
    }
}

TEST_CASE("shadow.blur: what is out of range is refused, and texels are explained", "[shadow][blur][explain]") {
    const Image4 map = row_of({1, 2, 3, 0, 5});
    ShadowParams params = blur_params(90, 2, 1);
    Image4 out;
    for (double range : {0.0, -1.0, double(INFINITY), double(NAN)})
        CHECK_THROWS_AS(direct::run(params, direct::LogBlurInputs{&map, direct::Direction::horizontal, range}, {}, out), InputError);
    CHECK_THROWS_WITH(direct::run(params, direct::LogBlurInputs{}, {}, out), "shadow.blur: map must be bound");
    params.esm_blur_radius = 33;
    CHECK_THROWS_WITH(direct::run(params, direct::LogBlurInputs{&map}, {}, out), Catch::Contains("esm_blur_radius = 33"));
    params.esm_blur_radius = 2;
    const auto taps = direct::explain(params, direct::LogBlurInputs{&map, direct::Direction::horizontal, 7}, {2, 0});
    out = blurred_row(params, map, 7);
    CHECK(taps.back().name == "depth");
    CHECK(float(taps.back().value.at(0)) == out(2, 0).w);

    const raster::Rsm one = half_occluded(8);
    const Points point({0, 0, -1}, {0, 0, 1});
    float v;
    const std::vector<Image4> wrong(1, Image4(4, 4)), many(2, Image4(8, 8));
    const ShadowParams esm = mode(ShadowMode::esm);
    CHECK_THROWS_AS(direct::run(esm, {&point.position, &point.normal, {&one, 1}, nullptr, wrong}, {}, &v), InputError);
    CHECK_THROWS_AS(direct::run(esm, {&point.position, &point.normal, {&one, 1}, nullptr, many}, {}, &v), InputError);
}
