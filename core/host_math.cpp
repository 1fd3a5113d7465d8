// How: two inverse pairs, each built on one kernel.
//
//     expm1(r) on |r| < 0.36, by its series and repeated squaring; log by one Newton step on it
//     sin, cos on |r| <= pi/4, by their series;                    the angle of a point by one Newton step on them
//
// All carry their value as a DoubleDouble. The Newton steps start from a series in double that is good to 30 bits, so
// the step itself, computed in double, brings it beyond 80.
#include "core/host_math.h"

#include <bit>
#include <cmath>
#include <cstdint>

namespace plumb::host {
namespace {

constexpr double infinity = __builtin_inf(), nan = std::bit_cast<double>(0x7ff8000000000000ull);
constexpr double max_double = 0x1.fffffffffffffp+1023, min_normal = 0x1p-1022;

// ---- Arithmetic on sums of two doubles (Dekker 1971, Knuth 1969) --------------------------------------------------

// hi + lo, where hi is the sum rounded to double.
struct DoubleDouble {
    double hi = 0, lo = 0;
    constexpr DoubleDouble() = default;
    constexpr DoubleDouble(double x) : hi(x) {}
    constexpr DoubleDouble(double h, double l) : hi(h), lo(l) {}
};

// a + b exactly, given |a| >= |b| or a = 0.
constexpr DoubleDouble sum_ordered(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
}

// a + b exactly.
constexpr DoubleDouble sum(double a, double b) {
    const double s = a + b, t = s - a;
    return {s, (a - (s - t)) + (b - t)};
}

// a * b exactly, for factors below 2^996: each is cut into halves of 26 bits, whose products are exact.
constexpr DoubleDouble product(double a, double b) {
    const double a_scaled = a * 0x1.0000002p+27, b_scaled = b * 0x1.0000002p+27;
    const double a_hi = a_scaled - (a_scaled - a), b_hi = b_scaled - (b_scaled - b);
    const double a_lo = a - a_hi, b_lo = b - b_hi, p = a * b;
    return {p, ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo};
}

constexpr DoubleDouble operator-(DoubleDouble a) { return {-a.hi, -a.lo}; }

constexpr DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble s = sum(a.hi, b.hi), t = sum(a.lo, b.lo);
    const DoubleDouble u = sum_ordered(s.hi, s.lo + t.hi);
    return sum_ordered(u.hi, u.lo + t.lo);
}

constexpr DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }

constexpr DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble p = product(a.hi, b.hi);
    return sum_ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

constexpr DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
    const double q = a.hi / b.hi;
    const DoubleDouble rest = a - b * q;
    return sum_ordered(q, (rest.hi + rest.lo) / b.hi);
}

// Multiplies by a power of two, which is exact here: nothing comes near overflow or underflow.
constexpr DoubleDouble scale(DoubleDouble a, double power) { return {a.hi * power, a.lo * power}; }

DoubleDouble sqrt(DoubleDouble a) {
    if (a.hi == 0) return a;
    const double root = std::sqrt(a.hi);
    const DoubleDouble rest = a - product(root, root);
    return sum_ordered(root, rest.hi / (2 * root));
}

constexpr DoubleDouble two_pi{0x1.921fb54442d18p+2, 0x1.1a62633145c07p-52};
constexpr DoubleDouble half_pi = scale(two_pi, 0.25), full_pi = scale(two_pi, 0.5);
constexpr DoubleDouble ln_2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
constexpr DoubleDouble one_over_ln_2 = DoubleDouble(1) / ln_2;

// ---- Bits ---------------------------------------------------------------------------------------------------------

constexpr double power_of_two(int e) { return std::bit_cast<double>(std::uint64_t(e + 1023) << 52); }  // a normal one

// |x| = fraction * 2^exponent, fraction in [1, 2); x finite and not 0.
struct Split {
    double fraction;
    int exponent;
};
Split split(double x) {
    const int shift = std::fabs(x) < min_normal ? 54 : 0;
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(shift ? x * 0x1p54 : x) & 0x7fffffffffffffff;
    return {std::bit_cast<double>((bits & 0xfffffffffffff) | 0x3ff0000000000000), int(bits >> 52) - 1023 - shift};
}

// The integer nearest to x, |x| < 2^51: the sum with 1.5 * 2^52 has no room for a fraction.
double round_to_integer(double x) { return (x + 0x1.8p52) - 0x1.8p52; }

// a * 2^k rounded once, a in [0.5, 2]; infinity and 0 where it leaves the range.
double assemble(DoubleDouble a, int k) {
    if (k > 1025) return infinity;
    if (k < -1080) return 0;
    if (k > 1000) return a.hi * power_of_two(k - 30) * 0x1p30;
    if (k > -1022 || (k == -1022 && a.hi >= 1)) return a.hi * power_of_two(k);
    // Rounds to a multiple of the smallest denormal, u after scaling, by adding a number whose last place is u.
    const double anchor = 0x1p52 * power_of_two(-1074 - k);
    const DoubleDouble s = sum_ordered(anchor, a.hi);
    return ((s.hi + (s.lo + a.lo)) - anchor) * power_of_two(k + 80) * 0x1p-80;
}

bool is_nan(double x) { return x != x; }
bool is_infinite(double x) { return std::fabs(x) > max_double; }
double with_sign_of(double magnitude, double sign) { return std::copysign(magnitude, sign); }

// ---- exp and log --------------------------------------------------------------------------------------------------

// e^r - 1 for |r| < 0.36, to a relative error of 2^-70.
DoubleDouble expm1_kernel(DoubleDouble r) {
    // Sums the series at s = r / 64 < 0.006, where terms from s^4 on are a 2^-27th and double precision is enough.
    constexpr DoubleDouble sixth = DoubleDouble(1) / DoubleDouble(6);
    const DoubleDouble s = scale(r, 0x1p-6);
    const double t = s.hi;
    const double tail =
        1. / 24 + t * (1. / 120 + t * (1. / 720 + t * (1. / 5040 + t * (1. / 40320 + t * (1. / 362880)))));
    DoubleDouble m = s + s * s * (DoubleDouble(0.5) + s * (sixth + s * tail));

    // Doubles the argument six times: (1 + m)^2 - 1 = m (2 + m).
    for (int i = 0; i < 6; ++i) m = m * (DoubleDouble(2) + m);
    return m;
}

// e^x for |x| < 1100.
double exp_rounded(DoubleDouble x) {
    const double k = round_to_integer(x.hi * one_over_ln_2.hi);
    return assemble(DoubleDouble(1) + expm1_kernel(x - ln_2 * k), int(k));
}

// The logarithm of x = m 2^exponent as that of m, in [sqrt(1/2), sqrt(2)), and the exponent; to a relative error of
// 2^-70.
struct Logarithm {
    DoubleDouble of_fraction;
    int exponent;
};
Logarithm log_kernel(double x) {
    auto [m, exponent] = split(x);
    if (m > 0x1.6a09e667f3bcdp0) m *= 0.5, ++exponent;

    // Estimates log m = 2 artanh((m - 1) / (m + 1)).
    const double f = (m - 1) / (m + 1), f2 = f * f;
    const double y = 2 * f * (1 + f2 * (1. / 3 + f2 * (1. / 5 + f2 * (1. / 7 + f2 * (1. / 9 + f2 * (1. / 11))))));

    // log m = y + log(1 + d) with d = m e^-y - 1, free of cancellation in m - 1.
    const DoubleDouble d = DoubleDouble(m - 1) + expm1_kernel(-y) * m;
    return {sum_ordered(y, d.hi - d.hi * d.hi * 0.5), exponent};
}
DoubleDouble natural(Logarithm l) { return ln_2 * double(l.exponent) + l.of_fraction; }

}  // namespace

double exp(double x) {
    if (is_nan(x)) return nan;
    if (x > 710) return infinity;
    if (x < -746) return 0;
    if (std::fabs(x) < 0x1p-60) return 1;
    return exp_rounded(x);
}

double exp2(double x) {
    if (is_nan(x)) return nan;
    if (x > 1025) return infinity;
    if (x < -1076) return 0;
    if (std::fabs(x) < 0x1p-60) return 1;
    const double k = round_to_integer(x);
    return assemble(DoubleDouble(1) + expm1_kernel(ln_2 * (x - k)), int(k));
}

double expm1(double x) {
    if (is_nan(x)) return nan;
    if (x > 710) return infinity;
    if (x < -60) return -1;
    if (std::fabs(x) < 0x1p-60) return x;
    // e^x - 1 = 2^k m + (2^k - 1); above 60, 1 is less than half a unit of the last place.
    if (x > 60) return exp_rounded(x);
    const double k = round_to_integer(x * one_over_ln_2.hi), power = power_of_two(int(k));
    const DoubleDouble m = scale(expm1_kernel(DoubleDouble(x) - ln_2 * k), power);
    const DoubleDouble result = DoubleDouble(power) - DoubleDouble(1) + m;
    return result.hi + result.lo;
}

double log(double x) {
    if (x == 0) return -infinity;
    if (!(x > 0)) return nan;
    if (is_infinite(x)) return infinity;
    return natural(log_kernel(x)).hi;
}

double log2(double x) {
    if (x == 0) return -infinity;
    if (!(x > 0)) return nan;
    if (is_infinite(x)) return infinity;
    const Logarithm l = log_kernel(x);
    return (DoubleDouble(double(l.exponent)) + l.of_fraction * one_over_ln_2).hi;
}

double pow(double x, double y) {
    // Settles what holds even for NaN, then NaN.
    if (y == 0 || x == 1) return 1;
    if (is_nan(x) || is_nan(y)) return nan;

    // Infinite y: only |x| matters.
    const double magnitude = std::fabs(x);
    if (is_infinite(y)) return magnitude == 1 ? 1 : (magnitude > 1) == (y > 0) ? infinity : 0;

    // A negative base needs an integer exponent; an odd one keeps the sign.
    const bool whole = std::fabs(y) >= 0x1p52 || std::floor(y) == y;
    const bool odd = whole && std::fabs(y) < 0x1p53 && std::floor(y * 0.5) != y * 0.5;
    const double sign = odd && std::signbit(x) ? -1 : 1;
    if (magnitude == 0 || is_infinite(x)) return sign * ((magnitude > 1) == (y > 0) ? infinity : 0);
    if (x < 0 && !whole) return nan;
    if (magnitude == 1) return sign;

    // |log |x|| >= 2^-53, so a larger y than this overflows or underflows.
    if (std::fabs(y) > 0x1p64) return sign * ((magnitude > 1) == (y > 0) ? infinity : 0);
    if (std::fabs(y) < 0x1p-70) return sign;
    const DoubleDouble exponent = natural(log_kernel(magnitude)) * y;
    if (exponent.hi > 710) return sign * infinity;
    if (exponent.hi < -746) return sign * 0.0;
    return sign * exp_rounded(exponent);
}

// ---- sin, cos, tan ------------------------------------------------------------------------------------------------

// Digit i, of weight 2^(63 - i), is bit 63 - i % 64 of word i / 64.
const std::uint64_t two_over_pi[20] = {
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
    0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab,
};

namespace {

struct SinCos {
    DoubleDouble sin, cos;
};

// |r| < 0.79, to a relative error of 2^-70. The first terms of each series need two doubles, the others one.
SinCos sincos_kernel(DoubleDouble r) {
    const DoubleDouble r2 = r * r;
    auto step = [&](DoubleDouble inner, double divisor) { return DoubleDouble(1) - r2 * inner / divisor; };
    // 1 - t/(n(n+1)) (1 - t/((n+2)(n+3)) (...)), from the inside out, t = r^2
    double s = 1, c = 1;
    for (int n = 22; n >= 10; n -= 2) s = 1 - r2.hi * s / (n * (n + 1)), c = 1 - r2.hi * c / (n * (n - 1));
    DoubleDouble sin_over_r = s, cos = c;
    for (int n = 8; n >= 2; n -= 2) sin_over_r = step(sin_over_r, n * (n + 1)), cos = step(cos, n * (n - 1));
    return {r * sin_over_r, cos};
}

// x = quadrant * pi/2 + angle, |angle| <= pi/4, quadrant modulo 4. For finite x >= 0.
struct Reduced {
    int quadrant;
    DoubleDouble angle;
};

// Payne and Hanek 1983: multiplies x = M 2^e by those digits of 2/pi alone that reach below 4 and above 2^-137.
Reduced reduce(double x) {
    if (x <= 0x1.921fb54442d18p-1) return {0, x};
    const auto [fraction, exponent] = split(x);
    const std::uint64_t M = std::uint64_t(fraction * 0x1p52);
    const int e = exponent - 52, first = e + 62;  // digits before it contribute multiples of 4

    // The product of M with the 192 digits that start there, modulo 4: its top two bits are the quadrant.
    auto word = [&](int i) {
        const int at = first + 64 * i, w = at / 64, b = at % 64;
        return b == 0 ? two_over_pi[w] : two_over_pi[w] << b | two_over_pi[w + 1] >> (64 - b);
    };
    using Wide = unsigned __int128;
    const Wide low = Wide(M) * word(2), middle = Wide(M) * word(1) + (low >> 64);
    std::uint64_t p0 = std::uint64_t(low), p1 = std::uint64_t(middle), p2 = M * word(0) + std::uint64_t(middle >> 64);

    // The fraction of a quarter turn in [-1/2, 1/2) as a sign and 190 bits; the quadrant rounds with it.
    const int quadrant = int((p2 + (std::uint64_t(1) << 61)) >> 62);
    p2 = p2 << 2 | p1 >> 62, p1 = p1 << 2 | p0 >> 62, p0 <<= 2;
    const bool negative = p2 >> 63;
    if (negative) p0 = ~p0, p1 = ~p1, p2 = ~p2;  // minus one unit of 2^-192, far below what is kept

    // Normalises, so that 106 bits are left even where x is closest to a multiple of pi/2 (2^-61).
    int shift = 0;
    if (p2 == 0) p2 = p1, p1 = p0, p0 = 0, shift = 64;
    const int zeros = std::countl_zero(p2);
    if (zeros > 0) p2 = p2 << zeros | p1 >> (64 - zeros), p1 = p1 << zeros | p0 >> (64 - zeros);
    const double hi = double(p2 >> 11) * 0x1p-53;
    const double lo = double((p2 & 0x7ff) << 42 | p1 >> 22) * 0x1p-106;
    const DoubleDouble turn = scale(sum_ordered(hi, lo), power_of_two(-shift - zeros));
    return {quadrant & 3, half_pi * (negative ? -turn : turn)};
}

}  // namespace

double sin(double x) {
    if (!(std::fabs(x) <= max_double)) return nan;
    if (std::fabs(x) < 0x1p-27) return x;
    const Reduced r = reduce(std::fabs(x));
    const SinCos k = sincos_kernel(r.angle);
    const double value = r.quadrant & 1 ? k.cos.hi : k.sin.hi;
    const bool lower_half = r.quadrant & 2;
    return lower_half != (x < 0) ? -value : value;
}

double cos(double x) {
    if (!(std::fabs(x) <= max_double)) return nan;
    const Reduced r = reduce(std::fabs(x));
    const SinCos k = sincos_kernel(r.angle);
    const double value = r.quadrant & 1 ? k.sin.hi : k.cos.hi;
    return r.quadrant == 1 || r.quadrant == 2 ? -value : value;
}

double tan(double x) {
    if (!(std::fabs(x) <= max_double)) return nan;
    if (std::fabs(x) < 0x1p-27) return x;
    const Reduced r = reduce(std::fabs(x));
    const SinCos k = sincos_kernel(r.angle);
    const double value = r.quadrant & 1 ? -(k.cos / k.sin).hi : (k.sin / k.cos).hi;
    return x < 0 ? -value : value;
}

// ---- asin, acos, atan, atan2 --------------------------------------------------------------------------------------

namespace {

// The angle of (x, y) above the x axis, for 0 <= y <= x, x > 0: in [0, pi/4].
DoubleDouble octant_angle(DoubleDouble y, DoubleDouble x) {
    // Estimates it as four times the angle of a tangent below 0.2: tan(a/2) = tan a / (1 + sqrt(1 + tan^2 a)).
    double t = y.hi / x.hi;
    for (int i = 0; i < 2; ++i) t = t / (1 + std::sqrt(1 + t * t));
    const double t2 = t * t;
    const double estimate =
        4 * t * (1 - t2 * (1. / 3 - t2 * (1. / 5 - t2 * (1. / 7 - t2 * (1. / 9 - t2 * (1. / 11 - t2 * (1. / 13)))))));

    // Turns the point back by the estimate; what is left is small enough for angle = tangent.
    const auto [s, c] = sincos_kernel(estimate);
    const DoubleDouble across = y * c - x * s, along = x * c + y * s;
    return sum_ordered(estimate, across.hi / along.hi);
}

// The same for any x and y >= 0: in [0, pi].
DoubleDouble angle(DoubleDouble y, DoubleDouble x) {
    const bool left = std::signbit(x.hi);
    if (left) x = -x;
    const DoubleDouble a = y.hi <= x.hi ? octant_angle(y, x) : half_pi - octant_angle(x, y);
    return left ? full_pi - a : a;
}

// sqrt(1 - x^2), |x| <= 1.
DoubleDouble other_leg(double x) { return sqrt(DoubleDouble(1) - product(x, x)); }

}  // namespace

double asin(double x) {
    if (!(std::fabs(x) <= 1)) return nan;
    if (std::fabs(x) < 0x1p-27) return x;
    return with_sign_of(angle(std::fabs(x), other_leg(x)).hi, x);
}

double acos(double x) {
    if (!(std::fabs(x) <= 1)) return nan;
    if (std::fabs(x) < 0x1p-60) return half_pi.hi;
    return angle(other_leg(x), x).hi;
}

double atan(double x) { return atan2(x, 1); }

double atan2(double y, double x) {
    if (is_nan(x) || is_nan(y)) return nan;

    // Infinities count as equal to each other and zeros as equal to each other; then only ratios matter.
    const bool left = std::signbit(x);
    if (is_infinite(x) && is_infinite(y)) y = with_sign_of(1, y), x = with_sign_of(1, x);
    if (y == 0 || is_infinite(x)) return with_sign_of(left ? full_pi.hi : 0, y);
    if (x == 0 || is_infinite(y)) return with_sign_of(half_pi.hi, y);

    // Beyond a ratio of 2^60 the angle is the ratio, pi or pi/2 to the last bit.
    const Split sy = split(y), sx = split(x);
    const int difference = sy.exponent - sx.exponent;
    if (difference > 60) return with_sign_of(half_pi.hi, y);
    if (difference < -60) return left ? with_sign_of(full_pi.hi, y) : y / x;
    const double height = sy.fraction * power_of_two(difference);
    return with_sign_of(angle(height, with_sign_of(sx.fraction, x)).hi, y);
}

}  // namespace plumb::host
