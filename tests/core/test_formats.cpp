#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "core/formats.h"

using namespace plumb;

namespace {

bool full() {
    const char* value = std::getenv("PLUMB_FULL");
    return value && value[0] == '1';
}

float float_of(std::uint32_t bits) { return std::bit_cast<float>(bits); }
std::uint32_t bits_of(float x) { return std::bit_cast<std::uint32_t>(x); }

// binary16 from its definition: a multiple of the quantum 2^(max(exponent, -14) - 10), infinity from 65520 on.
double half_by_definition(float x, HalfStore mode) {
    if (std::isinf(x)) return x;
    const double magnitude = std::fabs(double(x));
    const double quantum = std::ldexp(1, std::max(magnitude > 0 ? std::ilogb(magnitude) : -14, -14) - 10);
    const double steps = magnitude / quantum;
    double rounded = quantum * (mode == HalfStore::nearest ? std::nearbyint(steps) : std::floor(steps));
    if (rounded > 65504) rounded = mode == HalfStore::nearest ? HUGE_VAL : 65504;
    return std::copysign(rounded, x);
}

// Calls f with every float's bits in the full run; else with every exponent by the mantissas next to a rounding
// boundary of a half, and by a stride through the others.
template <class F>
void for_many_floats(F f) {
    if (full()) {
        for (std::uint64_t bits = 0; bits < std::uint64_t(1) << 32; ++bits) f(std::uint32_t(bits));
        return;
    }
    for (std::uint32_t top = 0; top < 1u << 19; ++top)  // sign, exponent and the ten mantissa bits that a half keeps
        for (std::uint32_t rest : {0u, 1u, 0xfffu, 0x1000u, 0x1001u, 0x1fffu}) f(top << 13 | rest);
    for (std::uint32_t bits = 0; bits < 0xfffff000; bits += 997) f(bits);
}

}  // namespace

TEST_CASE("half: all 65536 codes survive a round trip, NaNs become 7e00", "[formats]") {
    for (std::uint32_t code = 0; code < 65536; ++code) {
        const bool nan = (code & 0x7fff) > 0x7c00;
        const float x = half_to_float({std::uint16_t(code)});
        REQUIRE(std::isnan(x) == nan);
        for (HalfStore mode : {HalfStore::nearest, HalfStore::truncate})
            REQUIRE(float_to_half(x, mode).bits == (nan ? 0x7e00 : code));
    }
}

TEST_CASE("half: rounding is that of the definition of binary16", "[formats]") {
    for (HalfStore mode : {HalfStore::nearest, HalfStore::truncate}) {
        std::uint64_t wrong = 0, checked = 0;
        for_many_floats([&](std::uint32_t bits) {
            const float x = float_of(bits);
            ++checked;
            const Half h = float_to_half(x, mode);
            if (std::isnan(x)) {
                wrong += h.bits != 0x7e00;
                return;
            }
            const float got = half_to_float(h), expected = float(half_by_definition(x, mode));
            wrong += bits_of(got) != bits_of(expected);
        });
        CHECK(checked > 1u << 22);
        CHECK(wrong == 0);
    }
}

TEST_CASE("half: ties go to even, 65520 goes to infinity, 2^-25 to zero", "[formats]") {
    CHECK(float_to_half(2049).bits == float_to_half(2048).bits);
    CHECK(float_to_half(2051).bits == float_to_half(2052).bits);
    CHECK(float_to_half(65519.996f).bits == 0x7bff);
    CHECK(float_to_half(65520).bits == 0x7c00);
    CHECK(float_to_half(-65520).bits == 0xfc00);
    CHECK(float_to_half(0x1p-25f).bits == 0);
    CHECK(float_to_half(0x1.000002p-25f).bits == 1);
    CHECK(float_to_half(0x1p-24f).bits == 1);
    CHECK(float_to_half(-0.0f).bits == 0x8000);
    // Truncated, as lavapipe stores.
    CHECK(float_to_half(65520, HalfStore::truncate).bits == 0x7bff);
    CHECK(float_to_half(3e38f, HalfStore::truncate).bits == 0x7bff);
    CHECK(float_to_half(HUGE_VALF, HalfStore::truncate).bits == 0x7c00);
    CHECK(float_to_half(0x1.fffffep-24f, HalfStore::truncate).bits == 1);
}

TEST_CASE("r11g11b10f: every 11-bit and 10-bit code survives a round trip", "[formats]") {
    for (std::uint32_t code = 0; code < 2048; ++code) {
        const std::uint32_t blue = code >> 1, packed = code | code << 11 | blue << 22;
        const glm::vec3 v = decode_r11g11b10f(packed);
        // NaN has one code each: the highest mantissa bit alone.
        const std::uint32_t expected = code > 0x7c0 ? 0x7e0 : code, expected_blue = blue > 0x3e0 ? 0x3f0 : blue;
        REQUIRE(encode_r11g11b10f(v) == (expected | expected << 11 | expected_blue << 22));
    }
}

TEST_CASE("r11g11b10f: values go to the nearest code, finite ones to a finite code", "[formats]") {
    // By definition: neighbours a < b of the format, their midpoint, and a float on each side of it.
    for (std::uint32_t code = 0; code + 1 < 0x7c0; ++code) {
        const float a = decode_r11g11b10f(code).x, b = decode_r11g11b10f(code + 1).x, tie = (a + b) / 2;
        REQUIRE(encode_r11g11b10f({tie, 0, 0}) == code + (code & 1));
        REQUIRE(encode_r11g11b10f({std::nextafter(tie, 0.0f), 0, 0}) == code);
        REQUIRE(encode_r11g11b10f({std::nextafter(tie, b), 0, 0}) == code + 1);
    }
    for (std::uint32_t code = 0; code + 1 < 0x3e0; ++code) {
        const float a = decode_r11g11b10f(code << 22).z, b = decode_r11g11b10f((code + 1) << 22).z, tie = (a + b) / 2;
        REQUIRE(encode_r11g11b10f({0, 0, tie}) == (code + (code & 1)) << 22);
        REQUIRE(encode_r11g11b10f({0, 0, std::nextafter(tie, b)}) == (code + 1) << 22);
    }
    const glm::vec3 top = decode_r11g11b10f(encode_r11g11b10f(glm::vec3(3e38f)));
    CHECK(top == glm::vec3(65024, 65024, 64512));  // OpenGL 4.6, 2.3.4.3 and 2.3.4.4
    CHECK(encode_r11g11b10f(glm::vec3(-HUGE_VALF)) == 0);
    CHECK(encode_r11g11b10f({-1, -0.0f, -1e-30f}) == 0);
    CHECK(decode_r11g11b10f(encode_r11g11b10f(glm::vec3(HUGE_VALF))) == glm::vec3(HUGE_VALF));
}

TEST_CASE("unorm: codes survive, ties go to even, NaN goes to 0", "[formats]") {
    for (int bits : {2, 8, 10, 16})
        for (std::uint32_t code = 0; code < 1u << bits; ++code)
            REQUIRE(encode_unorm(decode_unorm(code, bits), bits) == code);
    CHECK(encode_unorm(0.5f, 8) == 128);      // 127.5
    CHECK(encode_unorm(0.5f, 10) == 512);     // 511.5
    CHECK(encode_unorm(0.5f / 255, 8) == 0);  // 0.5 after the rounded product
    CHECK(encode_unorm(1.5f / 255, 8) == 2);  // 1.5 likewise
    CHECK(encode_unorm(std::nanf(""), 8) == 0);
    CHECK(encode_unorm(-HUGE_VALF, 8) == 0);
    CHECK(encode_unorm(HUGE_VALF, 8) == 255);
    CHECK(decode_unorm(51, 8) == 0.2f);
}

TEST_CASE("snorm: codes survive but the lowest, which is -1 as well", "[formats]") {
    for (int bits : {8, 16}) {
        const int scale = (1 << (bits - 1)) - 1;
        for (int code = -scale; code <= scale; ++code) REQUIRE(encode_snorm(decode_snorm(code, bits), bits) == code);
        CHECK(decode_snorm(-scale - 1, bits) == -1);
        CHECK(encode_snorm(-7, bits) == -scale);
        CHECK(encode_snorm(std::nanf(""), bits) == 0);
    }
}

TEST_CASE("d24s8: every depth code survives, beside its stencil", "[formats]") {
    std::uint32_t wrong = 0;
    for (std::uint32_t code = 0; code <= 0xffffff; ++code)
        wrong += encode_d24s8(decode_depth24(code), 0xa5) != (code | 0xa5000000);
    CHECK(wrong == 0);
    CHECK(encode_d24s8(1, 0) == 0xffffff);
    CHECK(encode_d24s8(0.5f, 0) == 0x800000);  // 8388607.5: a tie
    CHECK(encode_d24s8(2, 3) == 0x3ffffff);
    CHECK(encode_d24s8(std::nanf(""), 0) == 0);
}

TEST_CASE("octahedral: the angle error over the sphere stays below the spacing of the codes", "[formats]") {
    // Measured over a million directions of a spiral: 0.003665 and 0.945854 degrees; a code's cell at the middle of an
    // octant is about 2/127 of a radian wide, whose half diagonal is 0.9 degrees.
    struct Case {
        Format format;
        double bound_deg;
    };
    for (const Case& c : {Case{Format::octahedral16, 0.0038}, Case{Format::octahedral8, 0.95}}) {
        double worst = 0;
        for (int i = 0; i < 1000000; ++i) {
            const double z = 1 - (2 * i + 1) / 1e6, r = std::sqrt(1 - z * z), phi = 2.399963229728653 * i;
            const glm::dvec3 n(r * std::cos(phi), r * std::sin(phi), z);
            glm::vec4 v(glm::vec3(n), 7);
            quantise(c.format, v);
            const glm::dvec3 m(v);
            if (!(std::fabs(glm::length(m) - 1) < 2e-7)) worst = HUGE_VAL;
            worst = std::max(worst, std::asin(glm::length(glm::cross(n, m / glm::length(m)))) * 57.29577951308232);
        }
        CAPTURE(info(c.format).name, worst);
        CHECK(worst <= c.bound_deg);
        CHECK(worst >= 0.5 * c.bound_deg);
    }
}

TEST_CASE("octahedral: the axes are exact, zero becomes +z", "[formats]") {
    for (float s : {1.0f, -1.0f})
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec4 v(0);
            v[axis] = s;
            const glm::vec4 expected = v;
            quantise(Format::octahedral16, v);
            CHECK(v == expected);
        }
    glm::vec4 zero(0);
    quantise(Format::octahedral8, zero);
    CHECK(zero == glm::vec4(0, 0, 1, 0));
}

TEST_CASE("rgbe: every code with a full mantissa survives a round trip", "[formats][HEM 5.7]") {
    for (int e = 0; e < 256; ++e)
        for (int m = 128; m < 256; ++m) {  // 128/255 is more than a half, so no lower exponent serves
            const glm::u8vec4 code(m, m / 2, 255 - m, e);
            REQUIRE(encode_rgbe(decode_rgbe(code)) == code);
        }
}

TEST_CASE("rgbe: the exponent is the ceiling of the logarithm, clamped", "[formats][HEM 5.7]") {
    CHECK(encode_rgbe({1, 0.5f, 0}) == glm::u8vec4(255, 128, 0, 128));  // log2(1) = 0; 127.5 to even
    CHECK(encode_rgbe({1.0000001f, 0, 0}) == glm::u8vec4(128, 0, 0, 129));
    CHECK(encode_rgbe({10, 1, 0}) == glm::u8vec4(159, 16, 0, 132));  // 255 * 10/16 = 159.4, 255/16 = 15.9
    CHECK(encode_rgbe({0, 0, 0}) == glm::u8vec4(0, 0, 0, 0));
    CHECK(encode_rgbe({-1, std::nanf(""), 0}) == glm::u8vec4(0, 0, 0, 0));
    CHECK(encode_rgbe({0x1p-128f, 0, 0}) == glm::u8vec4(255, 0, 0, 0));
    CHECK(encode_rgbe({0x1p-149f, 0, 0}) == glm::u8vec4(0, 0, 0, 0));
    CHECK(encode_rgbe({0x1p127f, 3e38f, HUGE_VALF}) == glm::u8vec4(255, 255, 255, 255));
    CHECK(decode_rgbe({255, 0, 51, 128}) == glm::vec3(1, 0, 0.2f));
    // Relative error of the largest component: half of 1/255 of a range of less than twice the value.
    for (float x = 1e-30f; x < 1e30f; x *= 1.37f) {
        const float back = decode_rgbe(encode_rgbe({x, 0, 0})).x;
        REQUIRE(std::fabs(back - x) <= x / 255 * 1.0001f);
    }
}

TEST_CASE("normal8: codes survive; zero has none and comes back as 1/255", "[formats][ISR (22)]") {
    for (int code = 0; code < 256; ++code) {
        const glm::vec3 v = decode_normal8(glm::u8vec3(code));
        REQUIRE(encode_normal8(v) == glm::u8vec3(code));
        REQUIRE(v.x != 0);
    }
    glm::vec4 up(0, 1, 0, 0);
    quantise(Format::normal8, up);
    CHECK(up.y == 1);
    CHECK(up.x == Approx(1. / 255).epsilon(1e-4));
    for (float x = -1; x <= 1; x += 0x1p-12f)
        REQUIRE(std::fabs(decode_normal8(encode_normal8(glm::vec3(x))).x - x) <= 1.0001f / 255);
}

TEST_CASE("formats: quantising twice changes nothing more", "[formats]") {
    for (const FormatInfo& f : formats()) {
        if (f.format == Format::octahedral16 || f.format == Format::octahedral8) continue;  // unit vectors: see above
        std::uint32_t state = 1;
        auto next = [&] { return float((state = state * 1664525 + 1013904223) >> 8) * 0x1p-24f; };
        for (int i = 0; i < 20000; ++i) {
            glm::vec4 once(4 * next() - 2, 2 * next() - 0.5f, next(), 3 * next());
            quantise(f.format, once);
            glm::vec4 twice = once;
            quantise(f.format, twice);
            CAPTURE(f.name);
            REQUIRE(std::memcmp(&once, &twice, sizeof once) == 0);
        }
    }
}

TEST_CASE("formats: components that are not stored read as (0, 0, 0, 1)", "[formats]") {
    auto stored = [](Format f, glm::vec4 v) {
        quantise(f, v);
        return v;
    };
    const glm::vec4 v(0.25f, 0.5f, 0.75f, 0.125f);
    CHECK(stored(Format::rgba32f, v) == v);
    CHECK(stored(Format::rgba16f, v) == v);
    CHECK(stored(Format::r32f, v) == glm::vec4(0.25f, 0, 0, 1));
    CHECK(stored(Format::r16f, v) == glm::vec4(0.25f, 0, 0, 1));
    CHECK(stored(Format::r11g11b10f, v) == glm::vec4(0.25f, 0.5f, 0.75f, 1));
    CHECK(stored(Format::d32f, {7, 0, 0, 0}) == glm::vec4(1, 0, 0, 1));
    CHECK(stored(Format::d24s8, {1, 37, 5, 5}) == glm::vec4(1, 37, 0, 1));
    glm::vec4 truncated(1 + 0x1.8p-10f);
    quantise(Format::rgba16f, truncated, HalfStore::truncate);
    CHECK(truncated == glm::vec4(1 + 0x1p-10f));
}

TEST_CASE("formats: the table is in the order of the enumeration, and names parse", "[formats]") {
    for (std::size_t i = 0; i < formats().size(); ++i) {
        REQUIRE(formats()[i].format == Format(i));
        REQUIRE(parse_format(formats()[i].name, "") == Format(i));
    }
    REQUIRE(info(Format::normal8).name == std::string("normal8"));
    REQUIRE_THROWS_WITH(parse_format("rgb9e5", "layout: normal"),
                        Catch::StartsWith("layout: normal: format \"rgb9e5\""));
}
