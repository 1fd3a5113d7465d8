// Measures core/detmath.h: the distance of a result from the exact value, in units in the last place of the exact value
// (2^-149 for denormal ones), over 2^24 inputs a function; with PLUMB_FULL=1 in the environment over all 2^32 floats,
// and over 2^30 pairs for pow.
//
// The exact value comes from the C library in double, whose error is less than 2^-28 of a float's unit, and MPFR
// decides where that could matter: it judges every input that sets a record above half a unit, and 2^20 others spread
// over the rest, on which the two must agree to 2^-20 units. So the worst error is MPFR's, and the filter is measured.
#include <mpfr.h>

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "core/fp_environment.h"
#include "tests/core/detmath_batch.h"

namespace {

using namespace plumb;
using std::int64_t, std::uint32_t, std::uint64_t;

constexpr int threads = 2, block = 4096;
constexpr double pi = 0x1.921fb54442d18p+1;

bool is_full() {
    const char* full = std::getenv("PLUMB_FULL");
    return full && full[0] == '1';
}

// A counter run through the finaliser of SplitMix64: 64 well-mixed bits for each index.
uint64_t mixed(uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9, x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}
double unit(uint64_t bits) { return double(bits >> 11) * 0x1p-53; }
float any_float(uint64_t bits) { return std::bit_cast<float>(uint32_t(bits >> 32)); }
float between(double low, double high, uint64_t bits) { return float(low + (high - low) * unit(bits)); }

// A float within four steps of x.
float near(double x, uint64_t bits) {
    return std::bit_cast<float>(std::bit_cast<uint32_t>(float(x)) + uint32_t(bits & 7) - 4);
}

// ---- References -----------------------------------------------------------------------------------------------------

double in_double(Elementary f, double x, double y) {
    switch (f) {
        case Elementary::exp: return std::exp(x);
        case Elementary::exp2: return std::exp2(x);
        case Elementary::log: return std::log(x);
        case Elementary::log2: return std::log2(x);
        case Elementary::sin: return std::sin(x);
        case Elementary::cos: return std::cos(x);
        case Elementary::acos: return std::acos(x);
        case Elementary::expm1: return std::expm1(x);
        default: return std::pow(x, y);
    }
}

// What a unit of the last place of x is to a float, as an exponent of two.
int last_place(double x) { return std::clamp(int(std::bit_cast<uint64_t>(x) >> 52 & 0x7ff) - 1023, -126, 127) - 23; }
double power_of_two(int e) { return std::bit_cast<double>(uint64_t(e + 1023) << 52); }

// Infinity counts as the float that would follow the largest. NaN is right where NaN is expected, wrong elsewhere.
double error_in_ulp(float got, double exact) {
    if (std::isnan(got) || std::isnan(exact)) return std::isnan(got) && std::isnan(exact) ? 0 : HUGE_VAL;
    const double limited = std::clamp(exact, -0x1p128, 0x1p128);
    return std::fabs(std::clamp(double(got), -0x1p128, 0x1p128) - limited) * power_of_two(-last_place(limited));
}

class Mpfr {
  public:
    Mpfr() { mpfr_inits2(96, x_, y_, result_, nullptr); }
    ~Mpfr() { mpfr_clears(x_, y_, result_, nullptr); }
    Mpfr(const Mpfr&) = delete;

    double error_in_ulp(Elementary f, float x, float y, float got) {
        mpfr_set_flt(x_, x, MPFR_RNDN), mpfr_set_flt(y_, y, MPFR_RNDN);
        switch (f) {
            case Elementary::exp: mpfr_exp(result_, x_, MPFR_RNDN); break;
            case Elementary::exp2: mpfr_exp2(result_, x_, MPFR_RNDN); break;
            case Elementary::log: mpfr_log(result_, x_, MPFR_RNDN); break;
            case Elementary::log2: mpfr_log2(result_, x_, MPFR_RNDN); break;
            case Elementary::sin: mpfr_sin(result_, x_, MPFR_RNDN); break;
            case Elementary::cos: mpfr_cos(result_, x_, MPFR_RNDN); break;
            case Elementary::acos: mpfr_acos(result_, x_, MPFR_RNDN); break;
            case Elementary::expm1: mpfr_expm1(result_, x_, MPFR_RNDN); break;
            case Elementary::pow: mpfr_pow(result_, x_, y_, MPFR_RNDN); break;
        }
        const double rounded = mpfr_get_d(result_, MPFR_RNDN);
        if (!std::isfinite(got) || !(std::fabs(rounded) < 0x1p128)) return ::error_in_ulp(got, rounded);
        // Towards zero, so that a value just below a power of two keeps the smaller unit.
        const int last = last_place(mpfr_get_d(result_, MPFR_RNDZ));
        mpfr_sub_d(result_, result_, got, MPFR_RNDN);
        return std::fabs(std::ldexp(mpfr_get_d(result_, MPFR_RNDN), -last));
    }

  private:
    mpfr_t x_, y_, result_;
};

// ---- Inputs ---------------------------------------------------------------------------------------------------------

// The range over which a function has its features, and a place in it that is hard.
struct Spots {
    double low, high, hard;
};
Spots spots(Elementary f) {
    switch (f) {
        case Elementary::exp: return {-104.5, 89, -87.4};
        case Elementary::exp2: return {-150.5, 128.5, -126};
        case Elementary::expm1: return {-18, 89, -0.35};
        case Elementary::acos: return {-1, 1, 0.5};
        case Elementary::sin:
        case Elementary::cos: return {-7, 7, pi / 4};
        default: return {0, 3, 1};
    }
}

struct Input {
    float x, y;
};

// Half of the inputs run through all floats in equal steps (all of them in full), the others lie where it is hard.
Input draw(Elementary f, int64_t i, int64_t count) {
    const uint64_t bits = mixed(uint64_t(i)), more = mixed(~bits);
    if (count == int64_t(1) << 32) return {std::bit_cast<float>(uint32_t(i)), 0};
    if (f == Elementary::pow) {
        // Bases of any size or near 1; exponents that reach any result, small ones, integers, and just anything.
        const float base = i & 1 ? any_float(bits) : near(1, bits) * (bits & 8 ? 1 : between(0.5, 2, more));
        const double reach = 152 / std::fmax(1e-7, std::fabs(std::log2(std::fabs(base))));
        switch (i >> 1 & 3) {
            case 0: return {std::fabs(base), between(-reach, reach, more)};
            case 1: return {std::fabs(base), between(-5, 5, more)};
            case 2: return {base, std::floor(between(-50, 50, more))};
            default: return {base, any_float(more)};
        }
    }
    const int64_t steps = count / 2;
    if (i < steps) return {std::bit_cast<float>(uint32_t(i * ((int64_t(1) << 32) / steps) + int64_t(bits % 256))), 0};
    const Spots s = spots(f);
    const bool angle = f == Elementary::sin || f == Elementary::cos;
    switch (bits & 3) {
        case 0: return {between(s.low, s.high, more), 0};
        case 1: return {float(s.hard + (unit(more) - 0.5) * std::exp2(-30 * unit(bits))), 0};
        case 2: return {angle ? near(pi / 2 * double(more >> (34 + (bits >> 8 & 15))), more) : near(s.high, more), 0};
        default: return {between(s.hard / 2, s.hard * 2, more), 0};
    }
}

// ---- Measurement ----------------------------------------------------------------------------------------------------

struct Measured {
    double worst = 0, disagreement = 0;
    Input at{};
    int64_t judged = 0, above_half = 0;
};

Measured measure_part(Elementary f, int64_t first, int64_t last, int64_t count) {
    const FpEnvironment environment;
    Mpfr mpfr;
    Measured m;
    double record = 0.5;
    float x[block], y[block], got[block];
    const uint64_t sample = uint64_t(count >> 20) - 1;
    for (int64_t start = first; start < last; start += block) {
        for (int k = 0; k < block; ++k) {
            const Input input = draw(f, start + k, count);
            x[k] = input.x, y[k] = input.y;
        }
        detmath_batch(best_isa(), f, x, y, got, block);
        for (int k = 0; k < block; ++k) {
            const double error = error_in_ulp(got[k], in_double(f, x[k], y[k]));
            m.above_half += error > 0.5;
            const bool sets_record = !(error <= record);
            if (!sets_record && (mixed(uint64_t(start + k)) & sample) != 0) continue;
            record = std::max(record, error), ++m.judged;
            const double judged = mpfr.error_in_ulp(f, x[k], y[k], got[k]);
            if (!(judged <= m.worst)) m.worst = judged, m.at = {x[k], y[k]};
            if (error != judged) m.disagreement = std::max(m.disagreement, std::fabs(error - judged));
        }
    }
    mpfr_free_cache();
    return m;
}

Measured measure(Elementary f) {
    const int64_t count = int64_t(1) << (!is_full() ? 24 : f == Elementary::pow ? 30 : 32);
    Measured parts[threads];
    std::vector<std::thread> workers;
    const int64_t share = count / threads;
    for (int t = 0; t < threads; ++t)
        workers.emplace_back([&, t] { parts[t] = measure_part(f, share * t, share * (t + 1), count); });
    for (std::thread& worker : workers) worker.join();

    Measured all = parts[0];
    for (const Measured& part : {parts[1]}) {
        if (!(part.worst <= all.worst)) all.worst = part.worst, all.at = part.at;
        all.disagreement = std::max(all.disagreement, part.disagreement);
        all.judged += part.judged, all.above_half += part.above_half;
    }
    std::printf("%-5s %11ld inputs  worst %.6f ulp at %.9g, %.9g  not nearest %.5f %%  "
                "MPFR judged %ld, differs by %.1e\n",
                elementary_names[int(f)], long(count), all.worst, double(all.at.x), double(all.at.y),
                100.0 * double(all.above_half) / double(count), long(all.judged), all.disagreement);
    std::fflush(stdout);
    return all;
}

}  // namespace

TEST_CASE("detmath: every function errs by at most 1 ulp", "[detmath][mpfr]") {
    for (int f = 0; f < elementary_count; ++f) {
        CAPTURE(elementary_names[f]);
        const Measured m = measure(Elementary(f));
        CHECK(m.worst <= 1);
        CHECK(m.disagreement <= 0x1p-20);
        CHECK(m.judged >= 1 << 19);
    }
}
