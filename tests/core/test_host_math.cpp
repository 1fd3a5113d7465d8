#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/content_hash.h"
#include "core/host_math.h"

using namespace plumb;

namespace {

const double infinity = HUGE_VAL, no_number = std::nan("");

// Equal to the bit, so that -0 is not 0 and the one NaN that is allowed has its bits checked.
void require_bits(double got, double expected) {
    CAPTURE(got, expected);
    const std::uint64_t canonical_nan = 0x7ff8000000000000;
    REQUIRE(std::bit_cast<std::uint64_t>(got) ==
            (std::isnan(expected) ? canonical_nan : std::bit_cast<std::uint64_t>(expected)));
}

}  // namespace

TEST_CASE("host_math: exp and log treat special values as C Annex F.6.3 says", "[host_math]") {
    require_bits(host::exp(0.0), 1), require_bits(host::exp(-0.0), 1);
    require_bits(host::exp(infinity), infinity), require_bits(host::exp(-infinity), 0);
    require_bits(host::exp2(infinity), infinity), require_bits(host::exp2(-infinity), 0);
    require_bits(host::expm1(0.0), 0), require_bits(host::expm1(-0.0), -0.0);
    require_bits(host::expm1(infinity), infinity), require_bits(host::expm1(-infinity), -1);
    require_bits(host::expm1(-1e-300), -1e-300), require_bits(host::expm1(no_number), no_number);
    require_bits(host::log(0.0), -infinity), require_bits(host::log(-0.0), -infinity);
    require_bits(host::log(1), 0), require_bits(host::log2(1), 0);
    require_bits(host::log(-1), no_number), require_bits(host::log2(-0x1p-1074), no_number);
    require_bits(host::log(infinity), infinity), require_bits(host::log2(infinity), infinity);
    require_bits(host::log2(0.0), -infinity);
    for (auto f : {host::exp, host::exp2, host::log, host::log2}) require_bits(f(-no_number), no_number);
}

TEST_CASE("host_math: exp2 and log2 are exact at every power of two", "[host_math]") {
    for (int e = -1074; e < 1024; ++e) {
        require_bits(host::exp2(e), std::ldexp(1, e));
        require_bits(host::log2(std::ldexp(1, e)), e);
    }
    require_bits(host::exp2(1024), infinity), require_bits(host::exp2(-1076), 0);
}

TEST_CASE("host_math: pow treats special values as C Annex F.10.4.4 says", "[host_math]") {
    for (double y : {-3.0, -2.0, -0.5, 2.5, -infinity}) {
        const bool odd = y == -3;
        require_bits(host::pow(0.0, y), y < 0 ? infinity : 0);
        require_bits(host::pow(-0.0, y), y > 0 ? 0 : odd ? -infinity : infinity);
        require_bits(host::pow(-infinity, y), y > 0 ? infinity : odd ? -0.0 : 0);
        require_bits(host::pow(infinity, y), y > 0 ? infinity : 0);
    }
    require_bits(host::pow(-0.0, 3), -0.0), require_bits(host::pow(-infinity, 5), -infinity);
    require_bits(host::pow(-1, infinity), 1), require_bits(host::pow(-1, -infinity), 1);
    require_bits(host::pow(0.5, infinity), 0), require_bits(host::pow(0.5, -infinity), infinity);
    require_bits(host::pow(-2, infinity), infinity), require_bits(host::pow(-2, -infinity), 0);
    require_bits(host::pow(no_number, 0), 1), require_bits(host::pow(1, no_number), 1);
    require_bits(host::pow(no_number, 1), no_number), require_bits(host::pow(2, no_number), no_number);
    require_bits(host::pow(-2, 0.5), no_number), require_bits(host::pow(-1, 0x1p53), 1);
    require_bits(host::pow(-1, 0x1.fffffffffffffp52), -1);
    require_bits(host::pow(-2, 1e300), infinity), require_bits(host::pow(-0.5, 1e300), 0);
    require_bits(host::pow(1 + 0x1p-52, 1e300), infinity), require_bits(host::pow(2, 1e-300), 1);
    require_bits(host::pow(2, 1025), infinity), require_bits(host::pow(-2, -1077), -0.0);
}

TEST_CASE("host_math: pow is exact where the result is a double", "[host_math]") {
    for (int base = -30; base <= 30; ++base)
        for (double exact = 1, n = 0; std::fabs(exact) < 0x1p53; exact *= base, ++n) {
            require_bits(host::pow(base, n), exact);
            if (n > 40 || base == 0) break;
        }
    for (int n = 1; n < 1000; ++n) require_bits(host::pow(double(n) * n, 0.5), n);
}

TEST_CASE("host_math: sin, cos and tan of zero and of no number", "[host_math]") {
    require_bits(host::sin(-0.0), -0.0), require_bits(host::tan(-0.0), -0.0), require_bits(host::cos(-0.0), 1);
    for (auto f : {host::sin, host::cos, host::tan})
        for (double x : {infinity, -infinity, -no_number}) require_bits(f(x), no_number);
}

TEST_CASE("host_math: sin, cos and tan are odd and even to the bit", "[host_math]") {
    for (double x = 1e-300; x < 1e300; x *= 1.7) {
        require_bits(host::sin(-x), -host::sin(x)), require_bits(host::cos(-x), host::cos(x));
        require_bits(host::tan(-x), -host::tan(x));
    }
}

TEST_CASE("host_math: cos of the double nearest to pi/2 is the rest of pi/2", "[host_math]") {
    // cos of it is its distance from pi/2, which two doubles do not tell exactly.
    require_bits(host::cos(0x1.921fb54442d18p0), 6.12323399573676588613032966137500146e-17);
}

TEST_CASE("host_math: the inverse functions treat special values as C Annex F.10.1 says", "[host_math]") {
    const double pi = host::pi;
    require_bits(host::asin(-0.0), -0.0), require_bits(host::asin(1), pi / 2), require_bits(host::asin(-1), -pi / 2);
    require_bits(host::acos(1), 0), require_bits(host::acos(-1), pi), require_bits(host::acos(-0.0), pi / 2);
    require_bits(host::asin(1 + 0x1p-52), no_number), require_bits(host::acos(-infinity), no_number);
    require_bits(host::atan(-0.0), -0.0), require_bits(host::atan(-infinity), -pi / 2);
    require_bits(host::atan(1), pi / 4);
    require_bits(host::asin(-no_number), no_number), require_bits(host::acos(-no_number), no_number),
        require_bits(host::atan(-no_number), no_number);
    for (double sign : {1.0, -1.0}) {
        require_bits(host::atan2(sign * 0.0, -0.0), sign * pi), require_bits(host::atan2(sign * 0.0, 0.0), sign * 0.0);
        require_bits(host::atan2(sign * 0.0, -3), sign * pi), require_bits(host::atan2(sign * 0.0, 3), sign * 0.0);
        require_bits(host::atan2(sign, 0.0), sign * pi / 2), require_bits(host::atan2(sign, -0.0), sign * pi / 2);
        require_bits(host::atan2(sign, -infinity), sign * pi), require_bits(host::atan2(sign, infinity), sign * 0.0);
        require_bits(host::atan2(sign * infinity, -1), sign * pi / 2);
        // 3 pi / 4 rounded is not 3 times pi/4 rounded.
        require_bits(host::atan2(sign * infinity, -infinity), sign * 2.35619449019234492884698253745962716);
        require_bits(host::atan2(sign * infinity, infinity), sign * pi / 4);
    }
    require_bits(host::atan2(no_number, 1), no_number), require_bits(host::atan2(1, -no_number), no_number);
    require_bits(host::atan2(0x1p-1074, 0x1p1023), 0), require_bits(host::atan2(0x1p1023, -0x1p-1074), pi / 2);
}

TEST_CASE("host_math: results keep their bits", "[host_math][golden]") {
    // Each is the nearest double to a value that mpmath prints to 40 digits.
    require_bits(host::exp(1), 2.718281828459045235360287471352662497757);
    require_bits(host::log(10), 2.302585092994045684017991454684364207601);
    require_bits(host::log2(3), 1.584962500721156181453738943947816508759);
    require_bits(host::sin(1), 0.8414709848078965066525023216302989996226);
    require_bits(host::cos(1), 0.5403023058681397174009366074429766037323);
    require_bits(host::tan(1), 1.557407724654902230506974807458360173087);
    require_bits(host::sin(1e22), -0.8522008497671888017727058937530293682618);
    require_bits(host::atan(2), 1.107148717794090503017065460178537040070);
    require_bits(host::pow(2, 0.5), 1.414213562373095048801688724209698078570);
}

TEST_CASE("host_math: a hundred thousand results have the same hash everywhere", "[host_math][golden]") {
    // Golden: printed by this test; equal for gcc and clang, at -O0 and -O2, with and without -mavx2 -mfma.
    std::vector<double> results;
    for (int i = 0; i < 10000; ++i) {
        const double x = (i - 5000) * 0x1.3p-9, large = x * 0x1p70, unit = i / 10000.;
        for (double r :
             {host::exp(x), host::exp2(x), host::log(x * x), host::log2(unit), host::pow(unit, x), host::sin(x),
              host::cos(large), host::tan(large), host::asin(unit), host::acos(unit), host::atan2(x, unit)})
            results.push_back(r);
    }
    CHECK(hash_text(content_hash(results.data(), results.size() * sizeof(double))) == "2f366384ae1a3f0d");
}
