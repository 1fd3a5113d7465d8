// Values, special values and hashes of core/detmath.h; its errors are measured by detmath_mpfr.cpp.
#include "core/detmath.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "core/fp_environment.h"
#include "tests/core/detmath_batch.h"

using namespace plumb;

namespace {

using std::uint32_t, std::uint64_t;

const float inf = HUGE_VALF, no_number = std::nanf("");

uint32_t canonical(float x) { return x != x ? 0x7fc00000 : std::bit_cast<uint32_t>(x); }

// Equal to the bit: -0 is not 0. Every NaN counts as the same.
void require_bits(float got, float expected) {
    CAPTURE(got, expected);
    REQUIRE(canonical(got) == canonical(expected));
}

// A counter run through the finaliser of SplitMix64.
uint64_t mixed(uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9, x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}

// 2^16 arguments a function: half of them any bits, half small numbers.
struct Arguments {
    std::vector<float> x, y;
    explicit Arguments(int function) : x(1 << 16), y(1 << 16) {
        for (uint64_t i = 0; i < x.size(); ++i) {
            const uint64_t h = mixed(8 * i + function);
            x[i] = std::bit_cast<float>(uint32_t(h)), y[i] = std::bit_cast<float>(uint32_t(h >> 32));
            if (i % 2) {
                x[i] = float(int(h & 0xffffff) - 0x600000) * 0x1p-19f;
                y[i] = float(int(h >> 40) - 0x800000) * 0x1p-18f;
            }
            if (function == int(Elementary::acos) && i % 2) x[i] *= 0.0625f;
            if (function == int(Elementary::pow) && i % 4 == 3) y[i] = std::floor(y[i]);
        }
    }
};

// FNV-1a of the results, byte by byte, NaNs made equal.
uint64_t hash_of(Isa isa, int function) {
    const FpEnvironment environment;
    const Arguments arguments(function);
    std::vector<float> result(arguments.x.size());
    detmath_batch(isa, Elementary(function), arguments.x.data(), arguments.y.data(), result.data(), int(result.size()));
    uint64_t hash = 0xcbf29ce484222325;
    for (float value : result)
        for (int byte = 0; byte < 4; ++byte) hash = (hash ^ (canonical(value) >> 8 * byte & 255)) * 0x100000001b3;
    return hash;
}

std::string text_of(const std::string& path) {
    std::ifstream file(PLUMB_SOURCE_DIR "/" + path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

}  // namespace

TEST_CASE("detmath: exp and exp2 treat special values as C Annex F.10.3 says", "[detmath]") {
    using namespace detmath;
    require_bits(exp(0.0f), 1), require_bits(exp(-0.0f), 1), require_bits(exp2(-0.0f), 1);
    require_bits(exp(inf), inf), require_bits(exp(-inf), 0);
    require_bits(exp2(inf), inf), require_bits(exp2(-inf), 0);
    require_bits(exp(no_number), no_number), require_bits(exp2(-no_number), no_number);
    require_bits(exp2(128.0f), inf), require_bits(exp2(-151.0f), 0), require_bits(exp(-1e30f), 0);
    for (int k = -149; k <= 127; ++k) require_bits(exp2(float(k)), std::ldexp(1.0f, k));
    // The largest float whose exponential is finite, and the next: ln(2^128 (1 - 2^-25)) = 88.72283908...
    require_bits(exp(88.72283f), std::bit_cast<float>(0x7f7fff84)), require_bits(exp(88.72284f), inf);
}

TEST_CASE("detmath: expm1 treats special values as C Annex F.10.3.3 says, and loses nothing near 0", "[detmath]") {
    using namespace detmath;
    require_bits(expm1(0.0f), 0), require_bits(expm1(-0.0f), -0.0f);
    require_bits(expm1(inf), inf), require_bits(expm1(-inf), -1), require_bits(expm1(no_number), no_number);
    require_bits(expm1(-1e30f), -1), require_bits(expm1(0x1p-149f), 0x1p-149f), require_bits(expm1(-1e-30f), -1e-30f);
    // Rounded from 40 digits: e^x - 1 for x = 2^-12, -2^-12, 1, -1.
    require_bits(expm1(0x1p-12f), 0x1.0008p-12f), require_bits(expm1(-0x1p-12f), -0x1.fffp-13f);
    require_bits(expm1(1.0f), 0x1.b7e152p+0f), require_bits(expm1(-1.0f), -0x1.43a54ep-1f);
    require_bits(expm1(88.72283f), std::bit_cast<float>(0x7f7fff84)), require_bits(expm1(88.72284f), inf);
}

TEST_CASE("detmath: log and log2 treat special values as C Annex F.10.3 says", "[detmath]") {
    using namespace detmath;
    for (auto f : {log<float>, log2<float>}) {
        require_bits(f(0), -inf), require_bits(f(-0.0f), -inf), require_bits(f(1), 0);
        require_bits(f(-1), no_number), require_bits(f(-0x1p-149f), no_number), require_bits(f(-inf), no_number);
        require_bits(f(inf), inf), require_bits(f(no_number), no_number);
    }
    for (int k = -149; k <= 127; ++k) require_bits(log2(std::ldexp(1.0f, k)), float(k));
}

TEST_CASE("detmath: pow treats special values as C Annex F.10.4.4 says", "[detmath]") {
    using detmath::pow;
    for (float y : {-3.0f, -2.0f, -0.5f, -1e20f, -0x1p-149f, 0x1p-149f, 0.5f, 2.0f, 3.0f, 1e20f}) {
        const bool odd = y == -3 || y == 3;
        require_bits(pow(0.0f, y), y < 0 ? inf : 0);
        require_bits(pow(-0.0f, y), y < 0 ? (odd ? -inf : inf) : odd ? -0.0f : 0);
        require_bits(pow(inf, y), y > 0 ? inf : 0);
        require_bits(pow(-inf, y), y > 0 ? (odd ? -inf : inf) : odd ? -0.0f : 0);
    }
    for (float x : {0.0f, -0.0f, 0.5f, -0.5f, inf, -inf, 2.0f, -2.0f}) {
        const bool below = std::fabs(x) < 1;
        require_bits(pow(x, inf), below ? 0 : inf), require_bits(pow(x, -inf), below ? inf : 0);
        require_bits(pow(x, 0.0f), 1), require_bits(pow(x, -0.0f), 1), require_bits(pow(x, no_number), no_number);
    }
    require_bits(pow(-1.0f, inf), 1), require_bits(pow(-1.0f, -inf), 1);
    require_bits(pow(1.0f, no_number), 1), require_bits(pow(1.0f, inf), 1), require_bits(pow(no_number, 0.0f), 1);
    require_bits(pow(no_number, 2.0f), no_number), require_bits(pow(-2.0f, 0.5f), no_number);
    require_bits(pow(-2.0f, 3.0f), -8), require_bits(pow(-2.0f, -2.0f), 0.25f);
    require_bits(pow(-1.0f, 16777215.0f), -1);
    require_bits(pow(-1.0f, 16777216.0f), 1), require_bits(pow(-2.0f, 1e30f), inf);
    require_bits(pow(-1.5f, 16777215.0f), -inf), require_bits(pow(-0.5f, 16777215.0f), -0.0f);
    require_bits(pow(2.0f, -149.0f), 0x1p-149f), require_bits(pow(10.0f, 10.0f), 1e10f);
}

TEST_CASE("detmath: sin, cos and acos treat special values as C Annex F.10.1 says", "[detmath]") {
    using namespace detmath;
    require_bits(sin(0.0f), 0), require_bits(sin(-0.0f), -0.0f), require_bits(cos(-0.0f), 1);
    for (float x : {inf, -inf, no_number})
        require_bits(sin(x), no_number), require_bits(cos(x), no_number), require_bits(acos(x), no_number);
    require_bits(sin(-0x1p-149f), -0x1p-149f), require_bits(cos(0x1p-149f), 1);
    require_bits(acos(1.0f), 0), require_bits(acos(-1.0f), 0x1.921fb6p+1f), require_bits(acos(0.0f), 0x1.921fb6p+0f);
    require_bits(acos(0x1.000002p0f), no_number), require_bits(acos(-2.0f), no_number);
}

TEST_CASE("detmath: sine of the float closest to a multiple of pi/2, and of the largest", "[detmath]") {
    // Values by MPFR at 300 bits.
    require_bits(detmath::cos(16367173 * 0x1p72f), -0x1.bbdd52p-30f);
    require_bits(detmath::sin(0x1.fffffep127f), -0x1.0b3366p-1f);
    require_bits(detmath::cos(0x1.fffffep127f), 0x1.b4bf2cp-1f);
}

TEST_CASE("detmath: every instruction set gives the golden hashes", "[detmath][golden]") {
    // Made by: test_core "[write_golden_detmath]"
    const uint64_t golden[] = {
#include "tests/core/golden_detmath.inc"
    };
    for (Isa isa : supported_isas())
        for (int f = 0; f < elementary_count; ++f) {
            INFO(isa_name(isa) << " " << elementary_names[f]);
            CHECK(hash_of(isa, f) == golden[f]);
        }
}

// Rewrites the golden hashes; hidden, so that only its name runs it.
TEST_CASE("detmath: write the golden hashes", "[.][write_golden_detmath]") {
    std::ofstream file(PLUMB_SOURCE_DIR "/tests/core/golden_detmath.inc");
    for (int f = 0; f < elementary_count; ++f) {
        char line[80];
        std::snprintf(line, sizeof line, "0x%016llx,  // %s\n", (unsigned long long)hash_of(Isa::scalar, f),
                      elementary_names[f]);
        file << line;
    }
    REQUIRE(file.good());
}

TEST_CASE("detmath: the twin has the same constants in the same order", "[detmath][twin]") {
    // Fractions with a point and five digits or more; powers of two are written differently in GLSL.
    const std::regex constant("[0-9]+\\.[0-9]{5,}(e-[0-9]+)?f|-?0x[0-9a-f]{8}");
    auto constants = [&](const std::string& path) {
        const std::string text = text_of(path);
        std::vector<std::string> found;
        for (std::sregex_iterator i(text.begin(), text.end(), constant), end; i != end; ++i)
            if (i->str().size() < 16) found.push_back(i->str());
        return found;
    };
    const auto ours = constants("core/detmath.h"), theirs = constants("core/detmath.glsl");
    REQUIRE(ours.size() > 40);
    REQUIRE(ours == theirs);
}

TEST_CASE("detmath: double is host_math", "[detmath]") {
    REQUIRE(detmath::exp(1.0) == host::exp(1.0));
    REQUIRE(detmath::pow(2.0, 0.5) == host::pow(2.0, 0.5));
    REQUIRE(detmath::acos(0.3) == host::acos(0.3));
}

TEST_CASE("detmath: Bounded holds what any argument within its bound gives", "[detmath][bounded]") {
    using namespace detmath;
    struct Case {
        Bounded (*bounded)(const Bounded&);
        double (*exact)(double);
        double low, high;
    };
    const Case cases[] = {{exp, host::exp, -20, 20}, {exp2, host::exp2, -20, 20}, {expm1, host::expm1, -20, 20}, {log, host::log, 0.01, 9},
                          {log2, host::log2, 0.01, 9}, {sin, host::sin, -9, 9},   {cos, host::cos, -9, 9},
                          {acos, host::acos, -1, 1}};
    for (const Case& c : cases)
        for (uint64_t i = 0; i < 20000; ++i) {
            const double x = c.low + (c.high - c.low) * double(mixed(i) >> 11) * 0x1p-53;
            const double bound = 0.009 * double(mixed(~i) >> 11) * 0x1p-53;
            const Bounded r = c.bounded(Bounded::within(float(x), double(float(x)), bound));
            for (double step : {-1.0, -0.5, 0.0, 0.3, 1.0}) {
                const double other = double(float(x)) + step * bound;
                if (c.exact == host::acos && std::fabs(other) > 1) continue;
                const double off = std::fabs(c.exact(other) - r.shadow);
                if (!(off <= r.bound)) FAIL("at " << x << " bound " << bound << " off " << off << " > " << r.bound);
            }
            if (!(std::fabs(double(r.value) - r.shadow) <= r.bound)) FAIL("value at " << x);
            if (!(r.bound < 1.1 * 100 * bound * (1 + std::fabs(r.shadow)) + 1e-6 + 1e-5 * std::fabs(r.shadow)) &&
                c.exact != host::acos)
                FAIL("the bound is loose at " << x << ": " << r.bound);
        }
    // The corner of the rectangle of arguments that is farthest: 2.1^3.1 against 2^3.
    const Bounded p = pow(Bounded::within(2, 2.0, 0.1), Bounded::within(3, 3.0, 0.1));
    REQUIRE(p.value == 8);
    REQUIRE(p.bound >= host::pow(2.1 + 0x1p-23, 3.1) - 8);
    REQUIRE(p.bound <= host::pow(2.1 + 0x1p-19, 3.1 + 0x1p-19) - 8);
}
