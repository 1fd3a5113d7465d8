// A device that keeps Vulkan's precision table and no more: every result is one of the floats that the table allows,
// picked at random or always on one side; products may be contracted to fused multiply-adds, a / b may be a (1 / b),
// denormals may be taken for 0. Kernels run on it with F = Legal.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "core/number.h"

namespace plumb::test {

// PCG (O'Neill 2014), 32 bits a call.
struct Random {
    std::uint64_t state;
    explicit Random(std::uint64_t seed) : state(seed * 2 + 1) { next(), next(); }
    std::uint32_t next() {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const std::uint32_t x = std::uint32_t(((state >> 18) ^ state) >> 27), turn = std::uint32_t(state >> 59);
        return (x >> turn) | (x << ((32 - turn) & 31));
    }
    int below(int n) { return int(next() % std::uint32_t(n)); }
    double between(double low, double high) { return low + (high - low) * (next() * 0x1p-32); }
};

enum class Rounding : int { random, up, down, to_zero, from_zero, nearest };
inline constexpr int roundings = 6;

struct LegalDevice {
    Random random{1};
    Rounding rounding = Rounding::nearest;
    bool contracts = false;      // a * b + c
    bool by_reciprocal = false;  // a / b
    bool flushes = false;
    bool reorders = false;  // other formulas and orders, where an expression offers them
    int half_at = -1;       // the operation whose result is kept in 16 bits: a mistake, not legal
    int operations = 0;

    bool coin() { return random.next() & 1; }
};
inline LegalDevice device;

inline float neighbour(float x, int step) {
    std::int32_t i;
    std::memcpy(&i, &x, 4);
    i = i < 0 ? std::int32_t(0x80000000u) - i : i;  // in order of value
    i += step;
    i = i < 0 ? std::int32_t(0x80000000u) - i : i;
    std::memcpy(&x, &i, 4);
    return x;
}

// Flushed, where the device does.
inline double operand(double x) { return device.flushes && __builtin_fabs(x) < 0x1p-126 ? 0 : x; }

// A float within `grant` units in the last place of `exact`; correctly rounded operations return what is exact, and
// nobody makes more of 0 / b.
inline float legal_result(double exact, double grant) {
    float f = float(exact);
    if (double(f) != exact || (grant > 1 && exact != 0)) {
        std::int64_t bits;
        std::memcpy(&bits, &exact, 8);
        const int exponent = int((bits >> 52) & 2047) - 1023;
        const double unit = exponent < -126 ? 0x1p-149 : __builtin_ldexp(1.0, exponent - 23);
        auto legal = [&](int k) { return __builtin_fabs(double(neighbour(f, k)) - exact) <= grant * unit; };
        int low = 0, high = 0;
        while (legal(low - 1)) --low;
        while (legal(high + 1)) ++high;
        const bool positive = exact > 0;
        switch (device.rounding) {
            case Rounding::random:
                f = neighbour(f, low + device.random.below(high - low + 1));
                break;
            case Rounding::up:
                f = neighbour(f, high);
                break;
            case Rounding::down:
                f = neighbour(f, low);
                break;
            case Rounding::to_zero:
                f = neighbour(f, positive ? low : high);
                break;
            case Rounding::from_zero:
                f = neighbour(f, positive ? high : low);
                break;
            case Rounding::nearest:
                break;
        }
    }
    if (device.operations++ == device.half_at) {
        // 11 significant bits.
        const double scaled = double(f) * (1 + 0x1p42);
        f = float(scaled - (scaled - double(f)));
    }
    return float(operand(f));
}

struct Legal {
    float value = 0;
    double product = 0;  // before it was rounded
    bool is_product = false;

    Legal() = default;
    Legal(float x) : value(x) {}
    explicit Legal(double x) : value(float(x)) {}
    explicit Legal(int x) : value(float(x)) {}
    double read() const { return operand(value); }

    friend Legal operator+(Legal a, Legal b) {
        double x = a.read(), y = b.read();
        if (device.contracts && b.is_product && device.coin())
            y = b.product;
        else if (device.contracts && a.is_product && device.coin())
            x = a.product;
        return legal_result(x + y, 1);
    }
    friend Legal operator-(Legal a, Legal b) { return a + -b; }
    friend Legal operator-(Legal a) {
        a.value = -a.value, a.product = -a.product;
        return a;
    }
    friend Legal operator*(Legal a, Legal b) {
        const double exact = a.read() * b.read();
        Legal r = legal_result(exact, 1);
        r.product = exact, r.is_product = true;
        return r;
    }
    friend Legal operator/(Legal a, Legal b) {
        if (device.by_reciprocal && device.coin()) return a * Legal(legal_result(1 / b.read(), 2.5));
        return legal_result(a.read() / b.read(), 2.5);
    }
    Legal& operator+=(Legal b) { return *this = *this + b; }
    friend bool operator<(Legal a, Legal b) { return a.read() < b.read(); }
};

inline Legal inverse_sqrt(Legal a) { return legal_result(1 / __builtin_sqrt(a.read()), 2); }
inline Legal sqrt(Legal a) {
    if (a.read() == 0) return 0.0f;
    return legal_result(1 / inverse_sqrt(a).read(), 2.5);
}
inline Legal min(Legal a, Legal b) { return plumb::min(a.value, b.value); }
inline Legal max(Legal a, Legal b) { return plumb::max(a.value, b.value); }
inline Legal abs(Legal a) { return plumb::abs(a.value); }
inline Legal floor(Legal a) { return plumb::floor(a.value); }

}  // namespace plumb::test

namespace plumb {
template <>
struct number<test::Legal> {
    using mask = bool;
    using index = std::int32_t;
    static constexpr int width = 1;
    static index truncate_to_index(test::Legal x) { return number<float>::truncate_to_index(x.value); }
};
}  // namespace plumb

template <>
struct std::numeric_limits<plumb::test::Legal> {
    static constexpr bool is_specialized = true, is_iec559 = true, is_signed = true, is_integer = false;
};
