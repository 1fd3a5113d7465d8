// Measures every function of core/host_math.h against MPFR: the error in units in the last place of the exact result
// (a denormal result has the unit 2^-1074), over inputs of every binary exponent and over the range where the function
// has its features.
#include <mpfr.h>

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "core/host_math.h"

namespace {

using namespace plumb;

// Inputs a function.
long input_count() {
    const char* full = std::getenv("PLUMB_FULL");
    return full && full[0] == '1' ? 1l << 24 : 1l << 22;
}

// A counter run through the finaliser of MurmurHash3: 64 well-mixed bits for each index.
std::uint64_t mixed(std::uint64_t x) {
    x ^= x >> 33, x *= 0xff51afd7ed558ccd;
    x ^= x >> 33, x *= 0xc4ceb9fe1a85ec53;
    return x ^ x >> 33;
}
double unit(std::uint64_t bits) { return double(bits >> 11) * 0x1p-53; }

// A double of any sign and any exponent; denormals and infinity-free.
double any_double(std::uint64_t bits) {
    const double x = std::bit_cast<double>(bits);
    return std::isfinite(x) ? x : std::bit_cast<double>(bits ^ (std::uint64_t(1) << 62));
}

// Half of the inputs spread over all exponents, half uniformly over [low, high].
double spread(long i, double low, double high, std::uint64_t stream = 0) {
    const std::uint64_t bits = mixed(2 * std::uint64_t(i) + 1 + (stream << 40));
    return i % 2 ? any_double(bits) : low + (high - low) * unit(bits);
}

// The largest error seen and the inputs it was seen at.
class Errors {
  public:
    Errors() { mpfr_inits2(96, exact_, difference_, nullptr); }
    ~Errors() { mpfr_clears(exact_, difference_, nullptr); }
    Errors(const Errors&) = delete;

    // Compares `got` with the exact value that evaluate(target) sets.
    template <class Evaluate>
    void add(double got, double x, double y, Evaluate evaluate) {
        evaluate(exact_);
        ++count;
        const double nearest = mpfr_get_d(exact_, MPFR_RNDN);
        if (std::bit_cast<std::uint64_t>(got) == std::bit_cast<std::uint64_t>(nearest)) return;
        if (std::isnan(got) && std::isnan(nearest)) return;
        ++not_nearest;
        double error = HUGE_VAL;
        if (std::isfinite(got) && std::isfinite(nearest) && !mpfr_zero_p(exact_)) {
            const long last_place = std::max(mpfr_get_exp(exact_) - 53, mpfr_exp_t(-1074));
            mpfr_sub_d(difference_, exact_, got, MPFR_RNDN);
            mpfr_abs(difference_, difference_, MPFR_RNDN);
            mpfr_div_2si(difference_, difference_, last_place, MPFR_RNDN);
            error = mpfr_get_d(difference_, MPFR_RNDU);
        }
        if (!(error <= worst)) worst = error, worst_x = x, worst_y = y;
    }

    void report(const char* name) const {
        std::printf("%-6s %9ld inputs  %4ld not the nearest  worst %.6f ulp  at %a %a\n", name, count, not_nearest,
                    worst, worst_x, worst_y);
        CHECK(count >= 1 << 20);
        CHECK(worst <= 0.51);
    }

    long count = 0, not_nearest = 0;
    double worst = 0.5, worst_x = 0, worst_y = 0;

  private:
    mpfr_t exact_, difference_;
};

using Function = double (*)(double);
using Reference = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);

void measure(const char* name, Function function, Reference reference, double low, double high) {
    Errors errors;
    mpfr_t argument;
    mpfr_init2(argument, 53);
    for (long i = 0; i < input_count(); ++i) {
        const double x = spread(i, low, high);
        mpfr_set_d(argument, x, MPFR_RNDN);
        errors.add(function(x), x, 0, [&](mpfr_ptr target) { reference(target, argument, MPFR_RNDN); });
    }
    mpfr_clear(argument);
    errors.report(name);
}

template <class Draw>
void measure2(const char* name, double (*function)(double, double),
              int (*reference)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t), Draw draw) {
    Errors errors;
    mpfr_t a, b;
    mpfr_inits2(53, a, b, nullptr);
    for (long i = 0; i < input_count(); ++i) {
        const auto [x, y] = draw(i);
        mpfr_set_d(a, x, MPFR_RNDN), mpfr_set_d(b, y, MPFR_RNDN);
        errors.add(function(x, y), x, y, [&](mpfr_ptr target) { reference(target, a, b, MPFR_RNDN); });
    }
    mpfr_clears(a, b, nullptr);
    errors.report(name);
}

struct Pair {
    double x, y;
};

}  // namespace

TEST_CASE("host_math: exp and exp2 err by at most 0.51 ulp", "[host_math][mpfr]") {
    measure("exp", host::exp, mpfr_exp, -750, 712);
    measure("exp2", host::exp2, mpfr_exp2, -1080, 1026);
}

TEST_CASE("host_math: log and log2 err by at most 0.51 ulp", "[host_math][mpfr]") {
    measure("log", host::log, mpfr_log, 0, 4);
    measure("log2", host::log2, mpfr_log2, 0, 4);
}

TEST_CASE("host_math: sin, cos and tan err by at most 0.51 ulp for arguments of any size", "[host_math][mpfr]") {
    measure("sin", host::sin, mpfr_sin, -1e5, 1e5);
    measure("cos", host::cos, mpfr_cos, -1e5, 1e5);
    measure("tan", host::tan, mpfr_tan, -10, 10);
}

TEST_CASE("host_math: asin, acos and atan err by at most 0.51 ulp", "[host_math][mpfr]") {
    measure("asin", host::asin, mpfr_asin, -1, 1);
    measure("acos", host::acos, mpfr_acos, -1, 1);
    measure("atan", host::atan, mpfr_atan, -20, 20);
}

TEST_CASE("host_math: atan2 errs by at most 0.51 ulp", "[host_math][mpfr]") {
    measure2("atan2", host::atan2, mpfr_atan2, [](long i) { return Pair{spread(i, -2, 2), spread(i, -2, 2, 1)}; });
}

TEST_CASE("host_math: pow errs by at most 0.51 ulp", "[host_math][mpfr]") {
    measure2("pow", host::pow, mpfr_pow, [](long i) {
        // A positive base of any size, and an exponent that brings the result anywhere in the range, or near one.
        const double x = std::fabs(spread(i / 2, 0, 4));
        if (i % 8 == 7) return Pair{spread(i, -4, 4), std::floor(spread(2 * i, -40, 40, 1))};
        const double reach = 760 / std::fmax(1e-300, std::fabs(std::log(x)));
        return Pair{x, i % 2 ? spread(2 * i, -reach, reach, 1) : spread(i, -8, 8, 1)};
    });
}

TEST_CASE("host_math: the table of 2/pi has the digits of 2/pi", "[host_math][mpfr]") {
    mpfr_t digits;
    mpfr_init2(digits, 2000);
    mpfr_const_pi(digits, MPFR_RNDN);
    mpfr_ui_div(digits, 2, digits, MPFR_RNDN);
    CHECK(host::two_over_pi[0] == 0);
    for (int word = 1; word < 20; ++word) {
        std::uint64_t expected = 0;
        for (int bit = 0; bit < 64; ++bit) {
            mpfr_mul_2ui(digits, digits, 1, MPFR_RNDN);
            const unsigned long digit = mpfr_get_ui(digits, MPFR_RNDZ);
            mpfr_sub_ui(digits, digits, digit, MPFR_RNDN);
            expected = expected << 1 | digit;
        }
        CAPTURE(word);
        CHECK(host::two_over_pi[word] == expected);
    }
    mpfr_clear(digits);
}

TEST_CASE("host_math: the reduction by pi/2 uses the right digits at every exponent", "[host_math][mpfr]") {
    // The doubles nearest to multiples of pi/2 need the most digits: the closest of all is 6381956970095103 * 2^797.
    Errors errors;
    mpfr_t argument;
    mpfr_init2(argument, 53);
    auto check = [&](double x) {
        mpfr_set_d(argument, x, MPFR_RNDN);
        errors.add(host::sin(x), x, 0, [&](mpfr_ptr target) { mpfr_sin(target, argument, MPFR_RNDN); });
        errors.add(host::cos(x), x, 0, [&](mpfr_ptr target) { mpfr_cos(target, argument, MPFR_RNDN); });
    };
    for (int e = -1074; e < 1024; ++e)
        for (int k = 0; k < 256; ++k) check(std::ldexp(1 + unit(mixed(std::uint64_t(e + 2000) * 256 + k)), e));
    check(0x1.6ac5b262ca1ffp+849);
    mpfr_t multiple;
    mpfr_init2(multiple, 1200);
    for (int k = 1; k < 20000; ++k) {
        mpfr_const_pi(multiple, MPFR_RNDN);
        mpfr_mul_si(multiple, multiple, k, MPFR_RNDN);
        mpfr_div_2si(multiple, multiple, 1, MPFR_RNDN);
        check(mpfr_get_d(multiple, MPFR_RNDN));
    }
    mpfr_clears(argument, multiple, nullptr);
    errors.report("pi/2");
}
