// Elementary functions for kernels, with the same bits for every number type, instruction set, compiler and GPU.
//
// core/detmath.glsl performs the same operations in the same order. Only + - * on floats, comparisons and 32-bit
// integers occur: a GPU rounds those correctly, while its division and square root may be some units off. There is no
// branch; both sides of a condition are computed and select() takes one.
//
// Method: whatever would spoil the last place is carried as a FloatFloat, an unevaluated sum of two floats. The
// polynomials are minimax approximations with float coefficients, computed with Sollya's fpminimax; "to 2^-n" is their
// error relative to the function. Worst errors in units in the last place, as tests/core/detmath_mpfr.cpp measures them
// against MPFR over all floats (pow: 2^30 pairs):
//
//     exp 0.78  exp2 0.78  pow 0.79  (denormal results, which round twice; about 0.65 for normal ones)
//     expm1 0.85  log 0.501  log2 0.501  sin 0.56  cos 0.56  acos 0.64
//
// Special values are those of C Annex F; sin and cos hold for arguments of any size. Which NaN comes out is not told.
// Overloads: double goes to core/host_math.h; Bounded (core/detmath_bounded.h) and Followed (core/detmath_followed.h)
// compute their values as float does.
#pragma once

#include "core/host_math.h"
#include "core/number.h"

namespace plumb::detmath {

// ---- Sums of two floats --------------------------------------------------------------------------------------------

// hi + lo, where hi is the sum rounded to float.
template <class F>
struct FloatFloat {
    F hi, lo;
};

// a + b exactly, given |a| >= |b| or a = 0 (Dekker 1971).
template <class F>
PLUMB_INLINE FloatFloat<F> sum_ordered(F a, F b) {
    const F s = a + b;
    return {s, b - (s - a)};
}

// The upper 12 bits of a significand; the rest has 12 as well, so products of such halves are exact.
template <class F>
PLUMB_INLINE F upper_half(F a) {
    return number<F>::from_bits(number<F>::bits(a) & index_t<F>(-4096));
}

// a * b exactly, while no part underflows (Dekker 1971, with halves cut off by a mask).
template <class F>
PLUMB_INLINE FloatFloat<F> product(F a, F b) {
    const F p = a * b, a_hi = upper_half(a), b_hi = upper_half(b), a_lo = a - a_hi, b_lo = b - b_hi;
    return {p, ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo};
}

// a * b to 2^-45.
template <class F>
PLUMB_INLINE FloatFloat<F> product(FloatFloat<F> a, FloatFloat<F> b) {
    const FloatFloat<F> p = product(a.hi, b.hi);
    return sum_ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

// ---- 2^v and log2 x, on which exp, exp2, log, log2 and pow stand ---------------------------------------------------

// 2^k for -126 <= k <= 127.
template <class F>
PLUMB_INLINE F power_of_two(index_t<F> k) {
    return number<F>::from_bits((k + index_t<F>(127)) << 23);
}

// 2^v = 2^k (1 + linear + quadratic + from_lo), with k the integer nearest to v and |linear| < 0.35.
// 2^r = 1 + r ln 2 + r^2 P(r) for r = v - k, to 2^-31.
template <class F>
struct Exp2Parts {
    index_t<F> k;
    F r;
    FloatFloat<F> linear;  // r ln 2
    FloatFloat<F> one;     // 1 + linear.hi
    F quadratic;           // r^2 P(r)
    F from_lo;             // what the lower parts of v and of ln 2 add
};
template <class F>
PLUMB_INLINE Exp2Parts<F> exp2_parts(FloatFloat<F> v) {
    const index_t<F> k = number<F>::round_to_index(v.hi);
    const FloatFloat<F> rest = sum_ordered(v.hi - number<F>::from_index(k), v.lo);
    const F r = rest.hi;
    const FloatFloat<F> linear = product(r, F(0.693147182f));
    const F quadratic =
        r * r *
        (0.240226507f + r * (0.0555041097f + r * (0.00961808953f +
        r * (0.00133333867f + r * (0.000154508918f + r * 1.53310245e-05f)))));
    const FloatFloat<F> one = sum_ordered(F(1.0f), linear.hi);
    const F from_lo = one.hi * (rest.lo * 0.693147182f) + r * -1.90465421e-09f;
    return {k, r, linear, one, quadratic, from_lo};
}

// 2^v for |v| <= 220.
template <class F>
PLUMB_INLINE F exp2_of(FloatFloat<F> v) {
    const Exp2Parts<F> p = exp2_parts(v);
    const F y = p.one.hi + (p.one.lo + (p.linear.lo + (p.quadratic + p.from_lo)));

    // Scales in two steps, of which only the second can round, overflow or underflow.
    const index_t<F> half = p.k >> 1;
    return y * power_of_two<F>(half) * power_of_two<F>(p.k - half);
}

// log2 x to 2^-36 for finite x > 0; some finite number for others. x = 2^e m with m in [sqrt(1/2), sqrt(2)), and
// log2 m = 2 / ln 2 artanh s = s (c0 + s^2 (c1 + s^2 P(s^2))), to 2^-44, for s = (m - 1) / (m + 1).
template <class F>
PLUMB_INLINE FloatFloat<F> log2_of(F x) {
    using I = index_t<F>;
    // Splits x. A denormal is its own bits times 2^-149, said with integers so that flushing denormals does no harm.
    const I raw = number<F>::bits(x);
    const mask_t<F> denormal = raw < I(0x00800000);
    const I bits = select(denormal, number<F>::bits(number<F>::from_index(raw)), raw);
    const I exponent = (bits - I(0x3f3504f3)) >> 23;
    const F f = number<F>::from_bits(bits - (exponent << 23)) - 1.0f;
    const F e = number<F>::from_index(exponent - select(denormal, I(149), I(0)));

    // Divides f by m + 1 = 2 + f: a reciprocal to 2^-19, the quotient by it, and what that leaves over.
    const FloatFloat<F> divisor = sum_ordered(F(2.0f), f);
    const F estimate = 0.500319242f + f * (-0.254992545f + f * 0.116862953f);
    const F reciprocal = estimate * (2.0f - divisor.hi * estimate);
    const F quotient = f * reciprocal;
    const FloatFloat<F> p = product(quotient, divisor.hi);
    const FloatFloat<F> s = sum_ordered(quotient, reciprocal * (((f - p.hi) - p.lo) - quotient * divisor.lo));

    // Sums the series, its first two coefficients to twice the precision.
    const FloatFloat<F> s2 = product(s, s);
    const F t = s2.hi;
    const F tail = t * (0.577077925f + t * (0.412210763f + t * (0.319850296f + t * 0.283621222f)));
    const FloatFloat<F> inner = sum_ordered(F(0.961796701f), tail);
    const FloatFloat<F> outer = product(s2, {inner.hi, inner.lo - 6.77034251e-09f});
    const FloatFloat<F> factor = sum_ordered(F(2.88539004f), outer.hi);
    const FloatFloat<F> log2_m = product(s, {factor.hi, factor.lo + (outer.lo + 3.85191328e-08f)});
    const FloatFloat<F> sum = sum_ordered(e, log2_m.hi);
    return sum_ordered(sum.hi, sum.lo + log2_m.lo);
}

template <class F>
PLUMB_INLINE F infinity() {
    return number<F>::from_bits(index_t<F>(0x7f800000));
}
template <class F>
PLUMB_INLINE F nan() {
    return number<F>::from_bits(index_t<F>(0x7fc00000));
}

// The logarithm of x, given its value `finite` for finite x > 0.
template <class F>
PLUMB_INLINE F logarithm(F x, F finite) {
    const F otherwise = select(x == F(0.0f), -infinity<F>(), select(x < F(0.0f), nan<F>(), x));
    return select((x > F(0.0f)) & (x < infinity<F>()), finite, otherwise);
}

template <class F>
PLUMB_INLINE F exp2(F x) {
    return exp2_of<F>({clamp(x, F(-200.0f), F(200.0f)), F(0.0f)});
}

// x log2 e for |x| <= 150, to twice the precision.
template <class F>
PLUMB_INLINE FloatFloat<F> times_log2_e(F x) {
    const FloatFloat<F> v = product(x, F(1.44269502f));
    return {v.hi, v.lo + x * 1.92596303e-08f};
}

// e^x = 2^(x log2 e).
template <class F>
PLUMB_INLINE F exp(F x) {
    return exp2_of(times_log2_e(clamp(x, F(-150.0f), F(150.0f))));
}

// e^x - 1 = (2^k - 1) + 2^k (linear + ...): where k = 0, nothing cancels. Below 2^-24 it is x, above 20 it is e^x.
template <class F>
PLUMB_INLINE F expm1(F x) {
    using I = index_t<F>;
    const F bounded = clamp(x, F(-150.0f), F(150.0f));
    const FloatFloat<F> v = times_log2_e(bounded);
    const Exp2Parts<F> p = exp2_parts(v);
    const F scale = power_of_two<F>(min(max(p.k, I(-126)), I(30)));
    const F of_square = product(p.r, p.r).lo * 0.240226507f;  // what rounding r^2 lost
    const FloatFloat<F> whole = {scale - 1.0f, (scale - (scale - 1.0f)) - 1.0f};
    const FloatFloat<F> s = sum_ordered(whole.hi, scale * p.linear.hi);
    const F rest = p.quadratic + (p.linear.lo + (p.from_lo + of_square));
    const F near = s.hi + (s.lo + (whole.lo + scale * rest));
    return select(abs(x) < F(0x1p-24f), x, select(x > F(20.0f), exp2_of(v), near));
}

template <class F>
PLUMB_INLINE F log2(F x) {
    return logarithm(x, log2_of(x).hi);
}

// log x = ln 2 log2 x.
template <class F>
PLUMB_INLINE F log(F x) {
    return logarithm(x, product(log2_of(x), {F(0.693147182f), F(-1.90465421e-09f)}).hi);
}

// |x|^y = 2^(y log2 |x|), the exponent to 2^-28 absolute; then the sign, and the cases that C Annex F.10.4.4 lists.
template <class F>
PLUMB_INLINE F pow(F x, F y) {
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f), magnitude = abs(x);

    // Beyond 2^40 every y gives what 2^40 gives, and beyond 200 every exponent what 200 gives.
    const F bounded = clamp(y, F(-0x1p40f), F(0x1p40f));
    const FloatFloat<F> log2_x = log2_of(magnitude);
    const FloatFloat<F> p = product(log2_x.hi, bounded);
    const FloatFloat<F> v = sum_ordered(p.hi, p.lo + log2_x.lo * bounded);
    const F exponent = clamp(v.hi, F(-200.0f), F(200.0f));
    const F finite = exp2_of<F>({exponent, select(exponent == v.hi, v.lo, zero)});

    // 0 and infinity to the power y, which is not 0 here.
    const mask_t<F> vanishes = magnitude == zero, diverges = magnitude == infinity<F>();
    const F limit = select(y < zero, select(vanishes, infinity<F>(), zero), select(vanishes, zero, infinity<F>()));
    const F positive = select((vanishes | diverges) & (y == y), limit, finite);

    // A negative base needs an integer exponent; an odd one keeps the sign.
    const mask_t<F> negative = number<F>::bits(x) < I(0), whole = floor(y) == y;
    const mask_t<F> odd = whole & !(floor(0.5f * y) == 0.5f * y);
    const F with_sign = select(negative & odd, -positive, positive);
    const F real = select((x < zero) & !whole & !vanishes & !diverges, nan<F>(), with_sign);
    return select((x == one) | (y == zero), one, select(x == x, real, x));
}

// ---- sin and cos ---------------------------------------------------------------------------------------------------

// The binary digits of 2/pi, after 32 zeros.
constexpr std::int32_t two_over_pi[] = {0x00000000,  -0x5d067c92, 0x4e441529,  -0x03d8a82f,
                                        -0x0acb2240, -0x249d6a67, 0x3c439041, -0x01ae9c55};

// The upper 32 bits of the unsigned product of a < 2^24 and b.
template <class I>
PLUMB_INLINE I upper_product(I a, I b) {
    const I a_lo = a & I(0xffff), a_hi = shift_right(a, 16), b_lo = b & I(0xffff), b_hi = shift_right(b, 16);
    const I first = a_hi * b_lo + shift_right(a_lo * b_lo, 16);
    const I second = a_lo * b_hi + (first & I(0xffff));
    return a_hi * b_hi + shift_right(first, 16) + shift_right(second, 16);
}

// |x| = quadrant pi/2 + angle, |angle| <= pi/4, quadrant modulo 4.
template <class F>
struct Reduced {
    index_t<F> quadrant;
    FloatFloat<F> angle;
};

// Word `word + j` of two_over_pi, where 0 <= word <= 4.
template <class I>
PLUMB_INLINE I digits(I word, int j) {
    I d(two_over_pi[j]);
    for (int k = 1; k <= 4; ++k) d = select(word == I(k), I(two_over_pi[j + k]), d);
    return d;
}

// The 32 digits that begin `shift` digits after the first of `a`; `b` are the 32 that follow a.
template <class I>
PLUMB_INLINE I window(I a, I b, I shift) {
    return (a << shift) | shift_right(shift_right(b, 1), I(31) - shift);
}

// Payne and Hanek 1983, "Radian reduction for trigonometric functions": x = M 2^n is multiplied by those digits of 2/pi
// that matter modulo 4, 96 of them. The product keeps 62 bits of the fraction of a quarter turn; the float closest
// to a multiple of pi/2 leaves 30 of them zero. So the angle is good to 2^-31 relative.
template <class F>
PLUMB_INLINE Reduced<F> reduce(F magnitude) {
    using I = index_t<F>;
    // Takes the digits of weight 2^(1 - n) and below.
    const I bits = number<F>::bits(magnitude), M = (bits & I(0x007fffff)) | I(0x00800000);
    const I first = (bits >> 23) - I(120), word = first >> 5, shift = first & I(31);
    const I d0 = digits(word, 0), d1 = digits(word, 1), d2 = digits(word, 2), d3 = digits(word, 3);
    const I w0 = window(d0, d1, shift), w1 = window(d1, d2, shift), w2 = window(d2, d3, shift);

    // Multiplies; high and low hold quarter turns modulo 4, in units of 2^-30 and 2^-62.
    const I a = M * w1, b = upper_product(M, w2), low = a + b;
    const I carry = shift_right((a & b) | ((a | b) & ~low), 31);
    const I high = M * w0 + upper_product(M, w1) + carry;

    // Rounds to the nearest quadrant and turns the signed fraction into floats of 24, 24 and 16 bits.
    const I quadrant = shift_right(high + I(0x20000000), 30);
    const I fraction = (high << 2) | shift_right(low, 30), rest = low << 2;
    const F top = number<F>::from_index(fraction >> 8) * 0x1p-24f;
    const F middle = number<F>::from_index(((fraction & I(0xff)) << 16) | shift_right(rest, 16)) * 0x1p-48f;
    const F bottom = number<F>::from_index(rest & I(0xffff)) * 0x1p-64f;
    const FloatFloat<F> s = sum_ordered(top, middle);
    const FloatFloat<F> turn = sum_ordered(s.hi, s.lo + bottom);
    const FloatFloat<F> angle = product(turn, {F(1.57079637f), F(-4.37113883e-08f)});

    // An argument of less than pi/4 is its own angle.
    const mask_t<F> small = magnitude <= F(0.785398126f);
    return {select(small, I(0), quadrant),
            {select(small, magnitude, angle.hi), select(small, F(0.0f), angle.lo)}};
}

// sin r = r + r^3 (c0 + r^2 P(r^2)), to 2^-35, and cos r = 1 - r^2/2 + r^4 P(r^2), to 2^-33, for |r| <= pi/4.
template <class F>
PLUMB_INLINE F sin_of(FloatFloat<F> r, FloatFloat<F> r2) {
    const F u = r2.hi;
    const F tail = u * (0.00833333191f + u * (-0.000198400987f + u * 2.72511397e-06f));
    const FloatFloat<F> inner = sum_ordered(F(-0.166666672f), tail);
    const FloatFloat<F> bend = product(r, product(r2, {inner.hi, inner.lo + 4.99386843e-09f}));
    const FloatFloat<F> s = sum_ordered(r.hi, bend.hi);
    return s.hi + (s.lo + (bend.lo + r.lo));
}
template <class F>
PLUMB_INLINE F cos_of(FloatFloat<F> r2) {
    const F u = r2.hi;
    const F quartic = u * u * (0.0416666679f + u * (-0.00138890487f + u * (2.48527704e-05f + u * -3.21313764e-07f)));
    const FloatFloat<F> s = sum_ordered(F(1.0f), -0.5f * u);
    return s.hi + (s.lo + (quartic - 0.5f * r2.lo));
}

// The sine `quadrant` quarter turns after r, times -1 where the sign bit of `sign` is set.
template <class F>
PLUMB_INLINE F sin_after(index_t<F> quadrant, FloatFloat<F> r, index_t<F> sign) {
    using I = index_t<F>;
    const FloatFloat<F> r2 = product(r, r);
    const F value = select((quadrant & I(1)) == I(1), cos_of(r2), sin_of(r, r2));
    const I flip = (((quadrant & I(2)) << 30) ^ sign) & I(-0x7fffffff - 1);
    return number<F>::from_bits(number<F>::bits(value) ^ flip);
}

template <class F>
PLUMB_INLINE F sin(F x) {
    const F magnitude = abs(x);
    const Reduced<F> r = reduce(magnitude);
    return select(magnitude < infinity<F>(), sin_after(r.quadrant, r.angle, number<F>::bits(x)), x - x);
}

template <class F>
PLUMB_INLINE F cos(F x) {
    const F magnitude = abs(x);
    const Reduced<F> r = reduce(magnitude);
    const index_t<F> next = r.quadrant + index_t<F>(1);
    return select(magnitude < infinity<F>(), sin_after(next, r.angle, index_t<F>(0)), x - x);
}

// ---- acos ----------------------------------------------------------------------------------------------------------

// sqrt(t) to 2^-34, for t = 0 and 2^-100 < t < 2^100: 1/sqrt(t) estimated from the bits of t and improved by two Newton
// steps, the root by it, and what that leaves over.
template <class F>
PLUMB_INLINE FloatFloat<F> sqrt_of(F t) {
    const F half = 0.5f * t;
    F r = number<F>::from_bits(index_t<F>(0x5f3759df) - (number<F>::bits(t) >> 1));
    for (int i = 0; i < 2; ++i) r = r * (1.5f - half * r * r);
    const F root = t * r;
    const FloatFloat<F> square = product(root, root);
    return sum_ordered(root, ((t - square.hi) - square.lo) * (0.5f * r));
}

// acos x = pi/2 - asin x for |x| <= 1/2, else 2 asin sqrt((1 - x) / 2), and acos(-x) = pi - acos x.
// asin s = s + s^3 P(s^2), to 2^-30, for 0 <= s <= 1/2.
template <class F>
PLUMB_INLINE F acos(F x) {
    const F magnitude = abs(x), t = 0.5f * (1.0f - magnitude), zero(0.0f);
    const mask_t<F> small = magnitude <= F(0.5f), negative = x < zero;
    const FloatFloat<F> root = sqrt_of(t);
    const F s_hi = select(small, magnitude, root.hi), s_lo = select(small, zero, root.lo);
    const F u = select(small, magnitude * magnitude, t);
    const F bend =
        u * (0.166666657f + u * (0.0750015303f + u * (0.0445854440f +
        u * (0.0312341619f + u * (0.0165968481f + u * 0.0345158055f)))));
    const F tail = s_lo + s_hi * bend;

    // The result is base - factor asin s.
    const F factor = select(small, select(negative, F(-1.0f), F(1.0f)), select(negative, F(2.0f), F(-2.0f)));
    const F base_hi = select(small, F(1.57079637f), select(negative, F(3.14159274f), zero));
    const F base_lo = select(small, F(-4.37113883e-08f), select(negative, F(-8.74227766e-08f), zero));
    const FloatFloat<F> sum = sum_ordered(base_hi, -(factor * s_hi));
    return select(magnitude <= F(1.0f), sum.hi + (sum.lo + (base_lo - factor * tail)), nan<F>());
}

// ---- double --------------------------------------------------------------------------------------------------------

PLUMB_INLINE double exp(double x) { return host::exp(x); }
PLUMB_INLINE double exp2(double x) { return host::exp2(x); }
PLUMB_INLINE double expm1(double x) { return host::expm1(x); }
PLUMB_INLINE double log(double x) { return host::log(x); }
PLUMB_INLINE double log2(double x) { return host::log2(x); }
PLUMB_INLINE double pow(double x, double y) { return host::pow(x, y); }
PLUMB_INLINE double sin(double x) { return host::sin(x); }
PLUMB_INLINE double cos(double x) { return host::cos(x); }
PLUMB_INLINE double acos(double x) { return host::acos(x); }

}  // namespace plumb::detmath

// Here, so that a kernel's template sees these overloads wherever it sees the others.
#include "core/detmath_bounded.h"
#include "core/detmath_followed.h"
