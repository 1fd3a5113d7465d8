// The number layer of every instruction set against plain C++, bit for bit; NaNs count as equal to each other.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/fp_environment.h"
#include "tests/core/number_probe.h"

using namespace plumb;

namespace {

using std::int32_t, std::uint32_t, std::uint64_t;

// A counter run through the finaliser of SplitMix64.
uint64_t mixed(uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9, x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}
float from_bits(uint32_t bits) { return std::bit_cast<float>(bits); }
uint32_t canonical(float x) { return x != x ? 0x7fc00000 : std::bit_cast<uint32_t>(x); }

constexpr int random_count = 1 << 16;
constexpr float sentinel = 12345;

// One float of every kind: zeros, denormals, ties of rounding, the ends of the integers and of the floats, NaNs.
const std::vector<float>& special_floats() {
    static const std::vector<float> values = [] {
        std::vector<float> v;
        for (uint32_t bits : {0x00000000u, 0x00000001u, 0x00000002u, 0x007fffffu, 0x00800000u, 0x00800001u, 0x3f000000u,
                              0x3effffffu, 0x3f800000u, 0x3f7fffffu, 0x3fc00000u, 0x40200000u, 0x4affffffu, 0x4b000001u,
                              0x4b800001u, 0x4effffffu, 0x4f000000u, 0x4f000001u, 0x5f000000u, 0x7f7fffffu, 0x7f800000u,
                              0x7fc00000u, 0x7f800001u, 0x33000000u})
            v.push_back(from_bits(bits)), v.push_back(from_bits(bits | 0x80000000));
        return v;
    }();
    return values;
}

// Every pair of special floats, then random bits.
struct Inputs {
    std::vector<float> a, b, c, texels;
    std::vector<int32_t> at;
    std::vector<uint16_t> halves;
    ProbeInput probe;

    Inputs() : texels(1 << 16), halves(1 << 16) {
        const std::vector<float>& special = special_floats();
        for (float x : special)
            for (float y : special) {
                a.push_back(x), b.push_back(y);
                c.push_back(special[mixed(a.size()) % special.size()]);
            }
        for (uint64_t i = 0; i < random_count; ++i)
            a.push_back(from_bits(mixed(3 * i))), b.push_back(from_bits(mixed(3 * i + 1))),
                c.push_back(from_bits(mixed(3 * i + 2)));
        const int count = int(a.size());
        // 40503 is prime and does not divide count.
        for (int i = 0; i < count; ++i) at.push_back(int32_t(int64_t(i) * 40503 % count));
        for (uint32_t i = 0; i < 1 << 16; ++i) texels[i] = from_bits(mixed(i + 77)), halves[i] = uint16_t(i * 40503);
        probe = {count, a.data(), b.data(), c.data(), at.data(), texels.data(),
                 reinterpret_cast<const Half*>(halves.data()), count - 5};
    }
};

// A half as IEEE 754 defines it, by its fields.
float half_by_definition(uint16_t h) {
    const int exponent = h >> 10 & 31, fraction = h & 1023;
    const float sign = h & 0x8000 ? -1.0f : 1.0f;
    if (exponent == 31) return fraction ? std::nanf("") : sign * HUGE_VALF;
    return sign * float(exponent ? std::ldexp(1024 + fraction, exponent - 25) : std::ldexp(fraction, -24));
}

// What lies outside the integers, NaN too, becomes the smallest one, as the processor has it.
int32_t to_index(double rounded) {
    return rounded >= -0x1p31 && rounded < 0x1p31 ? int32_t(rounded) : int32_t(0x80000000);
}

float plain(int row, const Inputs& in, int i) {
    const float a = in.a[i], b = in.b[i], c = in.c[i];
    const int texel = in.at[i] & 16383, record = in.at[i] & 4095;
    auto component = [&](int k) { return in.texels[k]; };
    auto half = [&](int k) { return half_by_definition(in.halves[k]); };
    if (row >= row_half_record) return half(16 * record + row - row_half_record);
    if (row >= row_half_texel) return half(4 * texel + row - row_half_texel);
    if (row >= row_record) return component(16 * record + row - row_record);
    if (row >= row_texel) return component(4 * texel + row - row_texel);
    switch (row) {
        case row_add: return a + b;
        case row_subtract: return a - b;
        case row_multiply: return a * b;
        case row_divide: return a / b;
        case row_negate: return from_bits(std::bit_cast<uint32_t>(a) ^ 0x80000000);
        case row_assign: return ((a + b) * c - a) / b;
        case row_min: return b < a ? b : a;
        case row_max: return a < b ? b : a;
        case row_abs: return from_bits(std::bit_cast<uint32_t>(a) & 0x7fffffff);
        case row_sqrt: return std::sqrt(a);
        case row_floor: return std::floor(a);
        case row_clamp: {
            const float at_least = a < b ? b : a;
            return c < at_least ? c : at_least;
        }
        case row_select: return a < b ? a : c;
        case row_dot3: return a * c + b * a + c * b;
        case row_normalize3: return b / std::sqrt(a * a + b * b + c * c);
        case row_from_index: return float(std::bit_cast<int32_t>(a));
        case row_from_bits: return from_bits(std::bit_cast<uint32_t>(a) ^ 1);
        case row_fetch: return in.a[in.at[i]];
        default: return std::fma(a, b, c);
    }
}

int32_t plain_integer(int row, const Inputs& in, int i) {
    const float a = in.a[i], b = in.b[i], c = in.c[i];
    const uint32_t u = std::bit_cast<uint32_t>(a), v = std::bit_cast<uint32_t>(b);
    const int32_t m = int32_t(u), n = int32_t(v);
    switch (row) {
        case row_round: return to_index(std::nearbyint(double(a)));
        case row_truncate: return to_index(std::trunc(double(a)));
        case row_bits: return m;
        case row_less: return a < b;
        case row_less_equal: return a <= b;
        case row_greater: return a > b;
        case row_greater_equal: return a >= b;
        case row_equal: return a == b;
        case row_and: return a < b && b < c;
        case row_or: return a < b || b < c;
        case row_not: return !(a < b);
        case row_any: return 1;
        case row_iota: return i;
        case row_int_add: return int32_t(u + v);
        case row_int_subtract: return int32_t(u - v);
        case row_int_multiply: return int32_t(u * v);
        case row_int_and: return int32_t(u & v);
        case row_int_or: return int32_t(u | v);
        case row_int_xor: return int32_t(u ^ v);
        case row_int_not: return int32_t(~u);
        case row_shift_left: return int32_t(u * 128);
        case row_shift_right: return int32_t(std::floor(double(m) / 32));
        case row_shift_right_logical: return int32_t(u / 32);
        case row_shift_left_by_lane: return int32_t(uint64_t(u) << (v % 32));
        case row_shift_right_by_lane: return int32_t(uint64_t(u) >> (v % 32));
        case row_int_less: return m < n;
        case row_int_greater: return m > n;
        case row_int_less_equal: return m <= n;
        case row_int_greater_equal: return m >= n;
        case row_int_equal: return m == n;
        case row_int_select: return m < n ? n : in.at[i];
        case row_int_min: return std::min(m, n);
        case row_int_max: return std::max(m, n);
        default: return in.at[in.at[i]];
    }
}

struct Outputs {
    std::vector<float> reals;
    std::vector<int32_t> integers;
    Outputs(Isa isa, const Inputs& in)
        : reals(std::size_t(real_rows) * in.probe.count, sentinel),
          integers(std::size_t(integer_rows) * in.probe.count, -7) {
        const FpEnvironment environment;
        ProbeOutput out{reals.data(), integers.data()};
        dispatch(isa, [&](auto set) { number_probe<set.value>(in.probe, out); });
    }
};

const Inputs& inputs() {
    static const Inputs in;
    return in;
}

}  // namespace

TEST_CASE("number: every instruction set computes what plain C++ computes", "[number]") {
    const Inputs& in = inputs();
    const int count = in.probe.count;
    for (Isa isa : supported_isas()) {
        const Outputs out(isa, in);
        for (int row = 0; row < row_stored4; ++row) {
            if (row == row_stored) continue;
            int wrong = 0, where = -1;
            for (int i = 0; i < count; ++i)
                if (canonical(out.reals[row * count + i]) != canonical(plain(row, in, i))) ++wrong, where = i;
            INFO(isa_name(isa) << ": real row " << row << " at " << where);
            CHECK(wrong == 0);
        }
        for (int row = 0; row < integer_rows; ++row) {
            int wrong = 0, where = -1;
            for (int i = 0; i < count; ++i)
                if (out.integers[row * count + i] != plain_integer(row, in, i)) ++wrong, where = i;
            INFO(isa_name(isa) << ": integer row " << row << " at " << where);
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("number: stores write active lanes alone, each at its own place", "[number]") {
    const Inputs& in = inputs();
    const int count = in.probe.count;
    std::vector<float> expected(count, sentinel), expected4(4 * count, sentinel), whole(4 * count, sentinel);
    for (int i = 0; i < count; ++i) {
        const int at = in.at[i];
        whole[4 * at] = whole[4 * at + 3] = in.c[i], whole[4 * at + 1] = in.a[i], whole[4 * at + 2] = in.b[i];
        if (at >= in.probe.active || in.a[i] < in.b[i]) continue;
        expected[at] = in.a[i];
        expected4[4 * at] = expected4[4 * at + 3] = in.a[i];
        expected4[4 * at + 1] = in.b[i], expected4[4 * at + 2] = in.c[i];
    }
    REQUIRE(expected[in.probe.active] == sentinel);
    for (Isa isa : supported_isas()) {
        const Outputs out(isa, in);
        int wrong = 0;
        for (int i = 0; i < count; ++i) wrong += canonical(out.reals[row_stored * count + i]) != canonical(expected[i]);
        for (int i = 0; i < 4 * count; ++i)
            wrong += canonical(out.reals[row_stored4 * count + i]) != canonical(expected4[i]);
        for (int i = 0; i < 4 * count; ++i)
            wrong += canonical(out.reals[row_stored4_whole * count + i]) != canonical(whole[i]);
        INFO(isa_name(isa));
        CHECK(wrong == 0);
    }
}

TEST_CASE("number: the inputs hold what they claim", "[number]") {
    const Inputs& in = inputs();
    REQUIRE(in.probe.count % 16 == 0);
    std::vector<bool> place(in.probe.count), half(1 << 16);
    for (int32_t at : in.at) place[at] = true;
    for (uint16_t h : in.halves) half[h] = true;
    REQUIRE(std::count(place.begin(), place.end(), true) == in.probe.count);
    REQUIRE(std::count(half.begin(), half.end(), true) == 65536);
}

TEST_CASE("number: a half converts to the float of the same value, all 65536 of them", "[number]") {
    int wrong = 0;
    for (uint32_t h = 0; h < 65536; ++h)
        wrong += canonical(half_to_float({uint16_t(h)})) != canonical(half_by_definition(uint16_t(h)));
    CHECK(wrong == 0);
}

TEST_CASE("number: fused() is fma, also on ties, beside them, and for denormals", "[number]") {
    const FpEnvironment environment;
    int wrong = 0, ties = 0, denormals = 0;
    for (uint64_t i = 0; i < 1 << 21; ++i) {
        const uint64_t h = mixed(5 * i), g = mixed(5 * i + 1);
        float a = from_bits(uint32_t(h)), b = from_bits(uint32_t(h >> 32)), c = from_bits(uint32_t(g));
        const int spread = int(g >> 32 & 63);
        switch (i % 4) {
            case 1:  // a tie half of the time: c has a last place of 2, the product is a small integer
                a = float(h >> 40 & 4095), b = float(h & 4095), c = float(0x1000000 + 2 * (g & 0xfffff));
                if (g >> 63) b += 0x1p-10f;
                if (g >> 62 & 1) a = -a;
                if (g >> 61 & 1) {  // less than a unit of double below a tie of odd c: 1 - x^2, x just below 2^-14
                    const float x = float(512 - int(h % 100 + 1)) * 0x1p-23f;
                    a = 1 + x, b = 1 - x;
                }
                break;
            case 2:  // near cancellation, and addends of any smaller size
                a = 1 + float(h >> 40) * 0x1p-24f, b = 1 + float(h & 0xffffff) * 0x1p-24f, c = -a * b;
                c = std::ldexp(c, spread < 8 ? 0 : spread - 32);
                break;
            case 3:  // a denormal result
                a = std::ldexp(float(h >> 40), -90), b = std::ldexp(float(h & 0xffffff), -80 - spread % 8);
                c = from_bits(uint32_t(g) & 0x80ffffff);
        }
        const float expected = std::fma(a, b, c);
        ties += i % 4 == 1 && std::fabs(std::fmod(std::fabs(double(a) * double(b) + double(c)), 2.0) - 1) == 0;
        denormals += expected != 0 && std::fabs(expected) < 0x1p-126f;
        wrong += canonical(fused(a, b, c)) != canonical(expected);
    }
    CHECK(wrong == 0);
    CHECK(ties > 30000);
    CHECK(denormals > 100000);
}
