// Measures every function of core/host_math.h against MPFR: the error in units in the last place (ulp) of the exact
// result (a denormal result has the unit 2^-1074), over inputs of every binary exponent and over the range where the
// function has its features.
//
// MPFR alone would take four times as long, so the C library's long double functions sieve the inputs first. Their
// 64-bit significand is good to about 2^-11 ulp of a double. An input goes on to MPFR, which alone decides, if
//     - by long double the result errs by more than 0.49 ulp, as one in fifty does;
//     - long double cannot tell: either result is infinite or NaN, or its own is zero, below the smallest denormal or
//       above the largest double; or
//     - it belongs to the control, a random 64th of all inputs.
// Wherever both can tell, long double has to agree with MPFR to 2^-9 ulp. So what the sieve lets pass errs by less than
// 0.492 ulp and is the nearest double, unless long double goes wrong where neither the control nor an error near half
// an ulp brings it to light.
#include <mpfr.h>

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "core/host_math.h"

namespace {

using namespace plumb;

static_assert(LDBL_MANT_DIG >= 64, "the sieve needs a long double of at least 64 bits");

// Inputs a function.
long input_count() {
    const char* full = std::getenv("PLUMB_FULL");
    return full && full[0] == '1' ? 1l << 26 : 1l << 22;
}

// The bound on the error, in ulp. Were every result good to 70 bits before it is rounded, it would be 0.50001.
constexpr double max_error = 0.501;

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

struct Pair {
    double x, y;
};

// The largest magnitude seen, in ulp, and the inputs it was seen at. A NaN counts as larger than all.
struct Worst {
    double error = 0;
    Pair at{};
    void add(double e, Pair input) {
        if (!(std::fabs(e) <= error)) error = std::isnan(e) ? HUGE_VAL : std::fabs(e), at = input;
    }
};

struct Tally {
    long count = 0, asked_mpfr = 0, compared = 0, not_nearest = 0;
    Worst result;  // of host_math, where it is not the nearest double
    Worst sieve;   // of long double, where MPFR was asked as well

    void add(const Tally& other) {
        count += other.count, asked_mpfr += other.asked_mpfr, compared += other.compared;
        not_nearest += other.not_nearest;
        result.add(other.result.error, other.result.at);
        sieve.add(other.sieve.error, other.sieve.at);
    }
};

// The error of `got` in ulp if `near` were the exact result; NaN where `near` cannot tell.
double error_by_sieve(double got, long double near) {
    const long double size = std::fabs(near);
    if (!(size >= 0x1p-1074l && size <= DBL_MAX) || !std::isfinite(got)) return NAN;
    return double(std::scalbn(near - got, -std::max(std::ilogb(near) - 52, -1074)));
}

// Compares with MPFR; one for each thread.
class Judge {
  public:
    Judge() { mpfr_inits2(96, exact_, difference_, nullptr); }
    ~Judge() { mpfr_clears(exact_, difference_, nullptr); }
    Judge(const Judge&) = delete;

    // Compares `got` with the exact value that evaluate(target) sets.
    template <class Evaluate>
    void ask_mpfr(double got, Pair input, Evaluate evaluate) {
        evaluate(exact_);
        ++tally.asked_mpfr;
        const double nearest = mpfr_get_d(exact_, MPFR_RNDN);
        if (std::bit_cast<std::uint64_t>(got) == std::bit_cast<std::uint64_t>(nearest)) return;
        if (std::isnan(got) && std::isnan(nearest)) return;
        ++tally.not_nearest;
        const bool finite = std::isfinite(got) && std::isfinite(nearest);
        mpfr_sub_d(difference_, exact_, got, MPFR_RNDN);
        tally.result.add(finite ? difference_in_ulp() : HUGE_VAL, input);
    }

    // Compares `near` with the exact value last asked for.
    void compare_sieve(long double near, Pair input) {
        ++tally.compared;
        mpfr_set_ld(difference_, near, MPFR_RNDN);
        mpfr_sub(difference_, exact_, difference_, MPFR_RNDN);
        tally.sieve.add(difference_in_ulp(), input);
    }

    Tally tally;

  private:
    double difference_in_ulp() {
        if (!mpfr_regular_p(exact_)) return HUGE_VAL;
        const long last_place = std::max(mpfr_get_exp(exact_) - 53, mpfr_exp_t(-1074));
        mpfr_div_2si(difference_, difference_, last_place, MPFR_RNDN);
        return mpfr_get_d(difference_, MPFR_RNDA);
    }

    mpfr_t exact_, difference_;
};

// host_math's function, the same one in long double and in MPFR.
struct Unary {
    double (*got)(double);
    long double (*near)(long double);
    int (*exact)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
};
struct Binary {
    double (*got)(double, double);
    long double (*near)(long double, long double);
    int (*exact)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);
};
double got(const Unary& f, Pair p) { return f.got(p.x); }
double got(const Binary& f, Pair p) { return f.got(p.x, p.y); }
long double near(const Unary& f, Pair p) { return f.near(p.x); }
long double near(const Binary& f, Pair p) { return f.near(p.x, p.y); }
void exact(const Unary& f, mpfr_ptr target, mpfr_srcptr x, mpfr_srcptr) { f.exact(target, x, MPFR_RNDN); }
void exact(const Binary& f, mpfr_ptr target, mpfr_srcptr x, mpfr_srcptr y) { f.exact(target, x, y, MPFR_RNDN); }

// Measures `f` at the inputs draw(begin) to draw(end - 1).
template <class Function, class Draw>
Tally measure_part(const Function& f, const Draw& draw, long begin, long end) {
    Judge judge;
    mpfr_t x, y;
    mpfr_inits2(53, x, y, nullptr);
    for (long i = begin; i < end; ++i) {
        const Pair input = draw(i);
        const double result = got(f, input);
        const long double reference = near(f, input);
        const double error = error_by_sieve(result, reference);
        const bool control = mixed(~std::uint64_t(i)) % 64 == 0;
        ++judge.tally.count;
        if (std::fabs(error) <= 0.49 && !control) continue;

        mpfr_set_d(x, input.x, MPFR_RNDN), mpfr_set_d(y, input.y, MPFR_RNDN);
        judge.ask_mpfr(result, input, [&](mpfr_ptr target) { exact(f, target, x, y); });
        if (!std::isnan(error)) judge.compare_sieve(reference, input);
    }
    mpfr_clears(x, y, nullptr);
    mpfr_free_cache2(MPFR_FREE_LOCAL_CACHE);
    return judge.tally;
}

// One result in a million may fail to be the nearest double, which allows a mean error of 2^-20 ulp before rounding.
void report(const char* name, const Tally& tally) {
    CAPTURE(name);
    std::printf("%-6s %9ld inputs  %8ld to MPFR  %3ld not the nearest", name, tally.count, tally.asked_mpfr,
                tally.not_nearest);
    if (tally.not_nearest > 0)
        std::printf("  worst %.8f ulp at %a %a", tally.result.error, tally.result.at.x, tally.result.at.y);
    if (tally.compared > 0)
        std::printf("  long double errs by 2^%.2f ulp at %a %a", std::log2(tally.sieve.error), tally.sieve.at.x,
                    tally.sieve.at.y);
    std::printf("\n");
    CHECK(tally.result.error <= max_error);
    CHECK(tally.not_nearest <= tally.count >> 20);
}

// Measures `f` on two threads, half of the inputs each, and adds up in the order of the inputs.
template <class Function, class Draw>
void measure(const char* name, const Function& f, const Draw& draw) {
    REQUIRE(mpfr_buildopt_tls_p());
    const long n = input_count();
    std::array<Tally, 2> parts;
    std::thread second([&] { parts[1] = measure_part(f, draw, n / 2, n); });
    parts[0] = measure_part(f, draw, 0, n / 2);
    second.join();
    Tally tally = parts[0];
    tally.add(parts[1]);

    report(name, tally);
    CAPTURE(name);
    CHECK(tally.count == n);
    CHECK(tally.compared >= n / 128);
    CHECK(tally.sieve.error <= 0x1p-9);
}

void measure(const char* name, const Unary& f, double low, double high) {
    measure(name, f, [=](long i) { return Pair{spread(i, low, high), 0}; });
}

}  // namespace

TEST_CASE("host_math: exp and exp2 err by at most 0.501 ulp", "[host_math][mpfr]") {
    measure("exp", Unary{host::exp, expl, mpfr_exp}, -750, 712);
    measure("exp2", Unary{host::exp2, exp2l, mpfr_exp2}, -1080, 1026);
    measure("expm1", Unary{host::expm1, expm1l, mpfr_expm1}, -40, 712);
    measure("expm1", Unary{host::expm1, expm1l, mpfr_expm1}, -0.4, 0.4);
}

TEST_CASE("host_math: log and log2 err by at most 0.501 ulp", "[host_math][mpfr]") {
    measure("log", Unary{host::log, logl, mpfr_log}, 0, 4);
    measure("log2", Unary{host::log2, log2l, mpfr_log2}, 0, 4);
}

TEST_CASE("host_math: sin, cos and tan err by at most 0.501 ulp for arguments of any size", "[host_math][mpfr]") {
    measure("sin", Unary{host::sin, sinl, mpfr_sin}, -1e5, 1e5);
    measure("cos", Unary{host::cos, cosl, mpfr_cos}, -1e5, 1e5);
    measure("tan", Unary{host::tan, tanl, mpfr_tan}, -10, 10);
}

TEST_CASE("host_math: asin, acos and atan err by at most 0.501 ulp", "[host_math][mpfr]") {
    measure("asin", Unary{host::asin, asinl, mpfr_asin}, -1, 1);
    measure("acos", Unary{host::acos, acosl, mpfr_acos}, -1, 1);
    measure("atan", Unary{host::atan, atanl, mpfr_atan}, -20, 20);
}

TEST_CASE("host_math: atan2 errs by at most 0.501 ulp", "[host_math][mpfr]") {
    measure("atan2", Binary{host::atan2, atan2l, mpfr_atan2}, [](long i) {
        return Pair{spread(i, -2, 2), spread(i, -2, 2, 1)};
    });
}

TEST_CASE("host_math: pow errs by at most 0.501 ulp", "[host_math][mpfr]") {
    measure("pow", Binary{host::pow, powl, mpfr_pow}, [](long i) {
        // A positive base of any size, and an exponent that brings the result anywhere in the range, or near one.
        const double x = std::fabs(spread(i / 2, 0, 4));
        if (i % 8 == 7) return Pair{spread(i, -4, 4), std::floor(spread(2 * i, -40, 40, 1))};
        const double reach = 760 / std::fmax(1e-300, std::fabs(host::log(x)));
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
    Judge judge;
    mpfr_t argument;
    mpfr_init2(argument, 53);
    auto check = [&](double x) {
        judge.tally.count += 2;
        mpfr_set_d(argument, x, MPFR_RNDN);
        judge.ask_mpfr(host::sin(x), {x, 0}, [&](mpfr_ptr target) { mpfr_sin(target, argument, MPFR_RNDN); });
        judge.ask_mpfr(host::cos(x), {x, 0}, [&](mpfr_ptr target) { mpfr_cos(target, argument, MPFR_RNDN); });
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
    report("pi/2", judge.tally);
    CHECK(judge.tally.asked_mpfr > 1 << 20);
}
