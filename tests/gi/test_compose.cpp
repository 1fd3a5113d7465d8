// Composition and tone mapping against their formulas.
#include <catch2/catch.hpp>

#include "core/error.h"
#include "gi/compose/compose.h"

using namespace plumb;

namespace {

// The display value of a grey radiance.
float shown(float radiance, const compose::TonemapParams& params) {
    Image4 display;
    const Image4 image(1, 1, glm::vec4(radiance));
    compose::run(params, compose::TonemapInputs{&image}, {}, display);
    CHECK(display(0, 0).w == 1);
    return display(0, 0).x;
}
float shown(float radiance, compose::Operator op, float exposure = 1) {
    return shown(radiance, compose::TonemapParams{op, exposure});
}

// The inverse of the curve of sRGB (IEC 61966-2-1), in double precision.
double decoded(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace

TEST_CASE("compose: L = (rho (E_direct + E_indirect) + M) / pi; environment where nothing is", "[compose][analytic]") {
    Image4 normal(2, 1), albedo(2, 1, glm::vec4(0.5f, 0.25f, 0, 0)), emission(2, 1, glm::vec4(1, 2, 3, 0)),
        direct(2, 1, glm::vec4(4)), indirect(2, 1, glm::vec4(2));
    normal(0, 0) = glm::vec4(0, 0, 1, 1);
    Image4 radiance;
    compose::run(compose::ComposeParams{}, compose::ComposeInputs{&normal, &albedo, &emission, &direct, &indirect, glm::vec3(7, 8, 9)}, {}, radiance);
    const double pi = 3.141592653589793;
    CHECK(radiance(0, 0).x == Approx((0.5 * 6 + 1) / pi).epsilon(1e-7));
    CHECK(radiance(0, 0).y == Approx((0.25 * 6 + 2) / pi).epsilon(1e-7));
    CHECK(radiance(0, 0).z == Approx(3 / pi).epsilon(1e-7));
    CHECK(radiance(1, 0) == glm::vec4(7, 8, 9, 0));
}

TEST_CASE("compose: inputs of different sizes are refused by name", "[compose]") {
    const Image4 two(2, 1), one(1, 1);
    Image4 radiance;
    CHECK_THROWS_WITH(compose::run(compose::ComposeParams{}, compose::ComposeInputs{&two, &two, &one, &two, &two, {}}, {}, radiance),
                      "compose: input \"emission\" is [1, 1, 4]: expected [1, 2, 4]");
    CHECK_THROWS_WITH(compose::run(compose::ComposeParams{}, compose::ComposeInputs{&two, &two, &two, &two, nullptr, {}}, {}, radiance),
                      "compose: indirect must be bound");
}

TEST_CASE("tonemap: the four curves, then the curve of sRGB", "[tonemap][analytic]") {
    using Op = compose::Operator;
    CHECK(decoded(shown(0.25f, Op::clamp)) == Approx(0.25).epsilon(1e-6));
    CHECK(shown(7, Op::clamp) == 1.055f - 0.055f);  // in float a unit in the last place below 1
    CHECK(decoded(shown(1, Op::exposure)) == Approx(1 - 0.36787944117144233).epsilon(1e-6));
    CHECK(decoded(shown(0.5f, Op::exposure, 4)) == Approx(1 - 0.1353352832366127).epsilon(1e-6));
    CHECK(decoded(shown(3, Op::reinhard)) == Approx(0.75).epsilon(1e-6));
    // Hable 2010: f(x) = (x (0.15 x + 0.05) + 0.004) / (x (0.15 x + 0.5) + 0.06) - 1/15, shown as f(2 x) / f(11.2).
    auto f = [](double x) { return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3; };
    CHECK(decoded(shown(0.5f, Op::filmic)) == Approx(f(1) / f(11.2)).epsilon(1e-5));
    CHECK(shown(5.6f, Op::filmic) == Approx(1).epsilon(1e-6));
    for (auto op : {Op::clamp, Op::exposure, Op::reinhard, Op::filmic}) {
        CHECK(shown(0, op) == Approx(0).margin(1e-6));
        CHECK(shown(1e30f, op) == Approx(1).epsilon(1e-5));
        CHECK(shown(-1, op) == shown(0, op));
        // Monotone, within 0..1.
        float last = 0;
        for (float x = 1e-4f; x < 1e5f; x *= 1.5f) {
            const float value = shown(x, op);
            CHECK(value >= last);
            CHECK(value <= 1);
            last = value;
        }
    }
}

TEST_CASE("tonemap: contrast is a power about 0.18, the dimmer a factor, gamma the inverse power", "[tonemap][IPR A.1][analytic]") {
    using compose::TonemapParams;
    using Op = compose::Operator;
    // 0.18 stays for every contrast; a quarter of it becomes 0.18 / 4^contrast.
    for (float contrast : {0.1f, 0.5f, 2.1f, 10.0f})
        CHECK(decoded(shown(0.18f, {Op::clamp, 1, 1, contrast})) == Approx(0.18).epsilon(2e-6));
    CHECK(decoded(shown(0.045f, {Op::clamp, 1, 1, 2})) == Approx(0.18 / 16).epsilon(1e-6));
    CHECK(decoded(shown(0.045f, {Op::clamp, 1, 1, 0.5f})) == Approx(0.09).epsilon(1e-6));
    CHECK(shown(0.36f, {Op::reinhard, 1, 1, 2, 1}) == Approx(0.72 / 1.72).epsilon(1e-6));
    // A dimmer is what the light is multiplied by, and so before the contrast; 0 is dark.
    CHECK(shown(3, {Op::exposure, 1, 0.25f, 2.1f}) == shown(0.75f, {Op::exposure, 1, 1, 2.1f}));
    CHECK(shown(3, {Op::filmic, 2, 0.25f}) == shown(1.5f, Op::filmic));
    CHECK(shown(1e6f, {Op::exposure, 1, 0, 2.1f, 1.58f}) == 0);
    // gamma: 1 shows the curve itself, 2 its root.
    CHECK(shown(0.375f, {Op::clamp, 1, 1, 1, 1}) == 0.375f);
    CHECK(shown(0.25f, {Op::clamp, 1, 1, 1, 2}) == Approx(0.5).epsilon(1e-7));
    CHECK(shown(1, {Op::reinhard, 1, 1, 1, 0.5f}) == Approx(0.25).epsilon(1e-7));
    // The values of figure A.1, all at once: 1 - exp(-0.18 (11.9 0.03 L / 0.18)^2.1), to the power of 1/1.58.
    const TonemapParams figure{Op::exposure, 11.9f, 0.03f, 2.1f, 1.58f};
    for (float radiance : {0.01f, 0.3f, 1.0f, 2.5f}) {
        const double light = 0.18 * std::pow(11.9 * 0.03 * double(radiance) / 0.18, 2.1);
        CHECK(shown(radiance, figure) == Approx(std::pow(1 - std::exp(-light), 1 / 1.58)).epsilon(3e-6));
    }
}

TEST_CASE("tonemap: with contrast and gamma every curve still rises from 0 to 1", "[tonemap][IPR A.1]") {
    using Op = compose::Operator;
    for (auto op : {Op::clamp, Op::exposure, Op::reinhard, Op::filmic})
        for (float contrast : {0.1f, 2.1f, 10.0f})
            for (float gamma : {0.0f, 0.1f, 1.58f, 10.0f}) {
                CAPTURE(int(op), contrast, gamma);
                const compose::TonemapParams params{op, 1, 1, contrast, gamma};
                CHECK(shown(0, params) == Approx(0).margin(1e-6));
                CHECK(shown(-1, params) == shown(0, params));
                // A contrast of 0.1 lifts 1e30 to 2 alone: 0.18 (1e10 / 0.18)^0.1.
                if (contrast > 1) CHECK(shown(1e30f, params) == Approx(1).epsilon(1e-5));
                float last = 0;
                for (float x = 1e-4f; x < 1e5f; x *= 1.5f) {
                    const float value = shown(x, params);
                    CHECK(value >= last);
                    CHECK(value <= 1);
                    last = value;
                }
                CHECK(last > 0);
            }
}

TEST_CASE("tonemap: sRGB meets its line at 0.0031308 and hits known codes", "[tonemap]") {
    // IEC 61966-2-1: 0.5 -> 0.7353569831 -> 188; 0.2140411405 -> 0.5.
    CHECK(shown(0.5f, compose::Operator::clamp) == Approx(0.7353569831).epsilon(1e-6));
    CHECK(shown(0.2140411405f, compose::Operator::clamp) == Approx(0.5).epsilon(1e-6));
    CHECK(shown(0.001f, compose::Operator::clamp) == Approx(0.01292).epsilon(1e-6));
    CHECK(shown(0.0031308f, compose::Operator::clamp) == Approx(0.04045).epsilon(1e-4));
}

TEST_CASE("tonemap: bytes are rint(255 x), ties to even", "[tonemap]") {
    Image4 display(2, 1);
    display(0, 0) = glm::vec4(0, 1, 0.5f, 1);                       // 127.5 -> 128, even
    display(1, 0) = glm::vec4(126.5f / 255, 1.49f / 255, 1.51f / 255, 1);
    const std::vector<unsigned char> bytes = compose::to_bytes(display);
    CHECK(bytes[0] == 0);
    CHECK(bytes[1] == 255);
    CHECK(bytes[2] == 128);
    CHECK(bytes[3] == 126);
    CHECK(bytes[4] == 1);
    CHECK(bytes[5] == 2);
}

TEST_CASE("tonemap: exposure out of range names field, value and range", "[tonemap]") {
    const Image4 image(1, 1);
    Image4 display;
    CHECK_THROWS_WITH(compose::run(compose::TonemapParams{compose::Operator::clamp, -1}, compose::TonemapInputs{&image}, {}, display),
                      "tonemap: exposure = -1: expected 0 to 1e+20 m2 sr/W");
    const auto refused = [&](const compose::TonemapParams& params) {
        compose::run(params, compose::TonemapInputs{&image}, {}, display);
    };
    using Op = compose::Operator;
    CHECK_THROWS_WITH(refused(compose::TonemapParams{Op::clamp, 1, 1.5f}), "tonemap: dimmer = 1.5: expected 0 to 1");
    CHECK_THROWS_WITH(refused(compose::TonemapParams{Op::clamp, 1, 1, 0}), "tonemap: contrast = 0: expected 0.1 to 10");
    CHECK_THROWS_WITH(refused(compose::TonemapParams{Op::clamp, 1, 1, 1, 0.05f}), "tonemap: gamma = 0.05: expected 0 for the curve of sRGB, or 0.1 to 10");
    CHECK_THROWS_WITH(refused(compose::TonemapParams{Op::clamp, 1, 1, 1, 11}), "tonemap: gamma = 11: expected 0 to 10");
}
