// Twin of core/detmath.h: the same operations in the same order, so the same bits. Read the comments there.
//
// Every float is `precise`: nothing may be contracted or rearranged. No built-in function is called but abs, floor,
// roundEven and those that reinterpret bits; min and max are written out, because theirs may do as they like with NaN.
#ifndef PLUMB_CORE_DETMATH_GLSL
#define PLUMB_CORE_DETMATH_GLSL

// ---- Sums of two floats --------------------------------------------------------------------------------------------

struct FloatFloat {
    float hi, lo;
};

FloatFloat det_sum_ordered(float a, float b) {
    precise float s = a + b;
    precise float lo = b - (s - a);
    return FloatFloat(s, lo);
}

float det_upper_half(float a) { return intBitsToFloat(floatBitsToInt(a) & -4096); }

FloatFloat det_product(float a, float b) {
    precise float p = a * b, a_hi = det_upper_half(a), b_hi = det_upper_half(b), a_lo = a - a_hi, b_lo = b - b_hi;
    precise float lo = ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo;
    return FloatFloat(p, lo);
}

FloatFloat det_product(FloatFloat a, FloatFloat b) {
    FloatFloat p = det_product(a.hi, b.hi);
    precise float lo = p.lo + (a.hi * b.lo + a.lo * b.hi);
    return det_sum_ordered(p.hi, lo);
}

float det_clamp(float x, float low, float high) {
    float at_least = x < low ? low : x;
    return high < at_least ? high : at_least;
}

int det_shift_right(int a, int n) { return int(uint(a) >> uint(n)); }

// ---- 2^v and log2 x, on which exp, exp2, log, log2 and pow stand ---------------------------------------------------

float det_power_of_two(int k) { return intBitsToFloat((k + 127) << 23); }

struct Exp2Parts {
    int k;
    float r;
    FloatFloat linear;
    FloatFloat one;
    float quadratic;
    float from_lo;
};

Exp2Parts det_exp2_parts(FloatFloat v) {
    int k = int(roundEven(v.hi));
    precise float nearest = v.hi - float(k);
    FloatFloat rest = det_sum_ordered(nearest, v.lo);
    float r = rest.hi;
    FloatFloat linear = det_product(r, 0.693147182f);
    precise float quadratic =
        r * r *
        (0.240226507f + r * (0.0555041097f + r * (0.00961808953f +
        r * (0.00133333867f + r * (0.000154508918f + r * 1.53310245e-05f)))));
    FloatFloat one = det_sum_ordered(1.0f, linear.hi);
    precise float from_lo = one.hi * (rest.lo * 0.693147182f) + r * -1.90465421e-09f;
    return Exp2Parts(k, r, linear, one, quadratic, from_lo);
}

float det_exp2_of(FloatFloat v) {
    Exp2Parts p = det_exp2_parts(v);
    precise float y = p.one.hi + (p.one.lo + (p.linear.lo + (p.quadratic + p.from_lo)));

    int half_k = p.k >> 1;
    precise float result = y * det_power_of_two(half_k) * det_power_of_two(p.k - half_k);
    return result;
}

FloatFloat det_log2_of(float x) {
    int raw = floatBitsToInt(x);
    bool denormal = raw < 0x00800000;
    int bits = denormal ? floatBitsToInt(float(raw)) : raw;
    int exponent = (bits - 0x3f3504f3) >> 23;
    precise float f = intBitsToFloat(bits - (exponent << 23)) - 1.0f;
    float e = float(exponent - (denormal ? 149 : 0));

    FloatFloat divisor = det_sum_ordered(2.0f, f);
    precise float estimate = 0.500319242f + f * (-0.254992545f + f * 0.116862953f);
    precise float reciprocal = estimate * (2.0f - divisor.hi * estimate);
    precise float quotient = f * reciprocal;
    FloatFloat p = det_product(quotient, divisor.hi);
    precise float left_over = reciprocal * (((f - p.hi) - p.lo) - quotient * divisor.lo);
    FloatFloat s = det_sum_ordered(quotient, left_over);

    FloatFloat s2 = det_product(s, s);
    float t = s2.hi;
    precise float tail = t * (0.577077925f + t * (0.412210763f + t * (0.319850296f + t * 0.283621222f)));
    FloatFloat inner = det_sum_ordered(0.961796701f, tail);
    precise float inner_lo = inner.lo - 6.77034251e-09f;
    FloatFloat outer = det_product(s2, FloatFloat(inner.hi, inner_lo));
    FloatFloat factor = det_sum_ordered(2.88539004f, outer.hi);
    precise float factor_lo = factor.lo + (outer.lo + 3.85191328e-08f);
    FloatFloat log2_m = det_product(s, FloatFloat(factor.hi, factor_lo));
    FloatFloat sum = det_sum_ordered(e, log2_m.hi);
    precise float sum_lo = sum.lo + log2_m.lo;
    return det_sum_ordered(sum.hi, sum_lo);
}

float det_infinity() { return intBitsToFloat(0x7f800000); }
float det_nan() { return intBitsToFloat(0x7fc00000); }

float det_logarithm(float x, float finite) {
    float otherwise = x == 0.0f ? -det_infinity() : x < 0.0f ? det_nan() : x;
    return x > 0.0f && x < det_infinity() ? finite : otherwise;
}

float det_exp2(float x) { return det_exp2_of(FloatFloat(det_clamp(x, -200.0f, 200.0f), 0.0f)); }

FloatFloat det_times_log2_e(float x) {
    FloatFloat v = det_product(x, 1.44269502f);
    precise float lo = v.lo + x * 1.92596303e-08f;
    return FloatFloat(v.hi, lo);
}

float det_exp(float x) { return det_exp2_of(det_times_log2_e(det_clamp(x, -150.0f, 150.0f))); }

float det_expm1(float x) {
    FloatFloat v = det_times_log2_e(det_clamp(x, -150.0f, 150.0f));
    Exp2Parts p = det_exp2_parts(v);
    float scale = det_power_of_two(min(max(p.k, -126), 30));
    precise float of_square = det_product(p.r, p.r).lo * 0.240226507f;
    precise float whole = scale - 1.0f;
    precise float whole_lo = (scale - whole) - 1.0f;
    precise float part = scale * p.linear.hi;
    FloatFloat s = det_sum_ordered(whole, part);
    precise float rest = p.quadratic + (p.linear.lo + (p.from_lo + of_square));
    precise float near = s.hi + (s.lo + (whole_lo + scale * rest));
    return abs(x) < 5.9604644775390625e-08f ? x : x > 20.0f ? det_exp2_of(v) : near;
}

float det_log2(float x) { return det_logarithm(x, det_log2_of(x).hi); }

float det_log(float x) {
    return det_logarithm(x, det_product(det_log2_of(x), FloatFloat(0.693147182f, -1.90465421e-09f)).hi);
}

float det_pow(float x, float y) {
    float magnitude = abs(x);

    float bounded = det_clamp(y, -1099511627776.0f, 1099511627776.0f);
    FloatFloat log2_x = det_log2_of(magnitude);
    FloatFloat p = det_product(log2_x.hi, bounded);
    precise float p_lo = p.lo + log2_x.lo * bounded;
    FloatFloat v = det_sum_ordered(p.hi, p_lo);
    float exponent = det_clamp(v.hi, -200.0f, 200.0f);
    float finite = det_exp2_of(FloatFloat(exponent, exponent == v.hi ? v.lo : 0.0f));

    bool vanishes = magnitude == 0.0f, diverges = magnitude == det_infinity();
    float limit = y < 0.0f ? (vanishes ? det_infinity() : 0.0f) : (vanishes ? 0.0f : det_infinity());
    float positive = (vanishes || diverges) && y == y ? limit : finite;

    precise float half_y = 0.5f * y;
    bool negative = floatBitsToInt(x) < 0, whole = floor(y) == y;
    bool odd = whole && !(floor(half_y) == half_y);
    float with_sign = negative && odd ? -positive : positive;
    float real = x < 0.0f && !whole && !vanishes && !diverges ? det_nan() : with_sign;
    return x == 1.0f || y == 0.0f ? 1.0f : x == x ? real : x;
}

// ---- sin and cos ---------------------------------------------------------------------------------------------------

const int det_two_over_pi[8] = int[8](0x00000000, -0x5d067c92, 0x4e441529, -0x03d8a82f,
                                      -0x0acb2240, -0x249d6a67, 0x3c439041, -0x01ae9c55);

int det_upper_product(int a, int b) {
    int a_lo = a & 0xffff, a_hi = det_shift_right(a, 16), b_lo = b & 0xffff, b_hi = det_shift_right(b, 16);
    int first = a_hi * b_lo + det_shift_right(a_lo * b_lo, 16);
    int second = a_lo * b_hi + (first & 0xffff);
    return a_hi * b_hi + det_shift_right(first, 16) + det_shift_right(second, 16);
}

struct Reduced {
    int quadrant;
    FloatFloat angle;
};

int det_digits(int word, int j) {
    int d = det_two_over_pi[j];
    for (int k = 1; k <= 4; ++k) d = word == k ? det_two_over_pi[j + k] : d;
    return d;
}

int det_window(int a, int b, int shift) { return (a << shift) | det_shift_right(det_shift_right(b, 1), 31 - shift); }

Reduced det_reduce(float magnitude) {
    int bits = floatBitsToInt(magnitude), M = (bits & 0x007fffff) | 0x00800000;
    int first = (bits >> 23) - 120, word = first >> 5, shift = first & 31;
    int d0 = det_digits(word, 0), d1 = det_digits(word, 1), d2 = det_digits(word, 2), d3 = det_digits(word, 3);
    int w0 = det_window(d0, d1, shift), w1 = det_window(d1, d2, shift), w2 = det_window(d2, d3, shift);

    int a = M * w1, b = det_upper_product(M, w2), low = a + b;
    int carry = det_shift_right((a & b) | ((a | b) & ~low), 31);
    int high = M * w0 + det_upper_product(M, w1) + carry;

    int quadrant = det_shift_right(high + 0x20000000, 30);
    int fraction = (high << 2) | det_shift_right(low, 30), rest = low << 2;
    precise float top = float(fraction >> 8) * 5.9604644775390625e-08f;
    precise float middle = float(((fraction & 0xff) << 16) | det_shift_right(rest, 16)) * 3.5527136788005009e-15f;
    precise float bottom = float(rest & 0xffff) * 5.4210108624275222e-20f;
    FloatFloat s = det_sum_ordered(top, middle);
    precise float s_lo = s.lo + bottom;
    FloatFloat turn = det_sum_ordered(s.hi, s_lo);
    FloatFloat angle = det_product(turn, FloatFloat(1.57079637f, -4.37113883e-08f));

    bool small = magnitude <= 0.785398126f;
    return Reduced(small ? 0 : quadrant, FloatFloat(small ? magnitude : angle.hi, small ? 0.0f : angle.lo));
}

float det_sin_of(FloatFloat r, FloatFloat r2) {
    float u = r2.hi;
    precise float tail = u * (0.00833333191f + u * (-0.000198400987f + u * 2.72511397e-06f));
    FloatFloat inner = det_sum_ordered(-0.166666672f, tail);
    precise float inner_lo = inner.lo + 4.99386843e-09f;
    FloatFloat bend = det_product(r, det_product(r2, FloatFloat(inner.hi, inner_lo)));
    FloatFloat s = det_sum_ordered(r.hi, bend.hi);
    precise float result = s.hi + (s.lo + (bend.lo + r.lo));
    return result;
}

float det_cos_of(FloatFloat r2) {
    float u = r2.hi;
    precise float quartic =
        u * u * (0.0416666679f + u * (-0.00138890487f + u * (2.48527704e-05f + u * -3.21313764e-07f)));
    precise float minus_half = -0.5f * u;
    FloatFloat s = det_sum_ordered(1.0f, minus_half);
    precise float result = s.hi + (s.lo + (quartic - 0.5f * r2.lo));
    return result;
}

float det_sin_after(int quadrant, FloatFloat r, int sign) {
    FloatFloat r2 = det_product(r, r);
    float value = (quadrant & 1) == 1 ? det_cos_of(r2) : det_sin_of(r, r2);
    int flip = (((quadrant & 2) << 30) ^ sign) & (-0x7fffffff - 1);
    return intBitsToFloat(floatBitsToInt(value) ^ flip);
}

float det_sin(float x) {
    float magnitude = abs(x);
    Reduced r = det_reduce(magnitude);
    return magnitude < det_infinity() ? det_sin_after(r.quadrant, r.angle, floatBitsToInt(x)) : det_nan();
}

float det_cos(float x) {
    float magnitude = abs(x);
    Reduced r = det_reduce(magnitude);
    return magnitude < det_infinity() ? det_sin_after(r.quadrant + 1, r.angle, 0) : det_nan();
}

// ---- acos ----------------------------------------------------------------------------------------------------------

FloatFloat det_sqrt_of(float t) {
    precise float half_t = 0.5f * t;
    precise float r = intBitsToFloat(0x5f3759df - (floatBitsToInt(t) >> 1));
    for (int i = 0; i < 2; ++i) r = r * (1.5f - half_t * r * r);
    precise float root = t * r;
    FloatFloat square = det_product(root, root);
    precise float left_over = ((t - square.hi) - square.lo) * (0.5f * r);
    return det_sum_ordered(root, left_over);
}

float det_acos(float x) {
    precise float magnitude = abs(x), t = 0.5f * (1.0f - magnitude);
    bool small = magnitude <= 0.5f, negative = x < 0.0f;
    FloatFloat root = det_sqrt_of(t);
    float s_hi = small ? magnitude : root.hi, s_lo = small ? 0.0f : root.lo;
    precise float u = small ? magnitude * magnitude : t;
    precise float bend =
        u * (0.166666657f + u * (0.0750015303f + u * (0.0445854440f +
        u * (0.0312341619f + u * (0.0165968481f + u * 0.0345158055f)))));
    precise float tail = s_lo + s_hi * bend;

    float factor = small ? (negative ? -1.0f : 1.0f) : (negative ? 2.0f : -2.0f);
    float base_hi = small ? 1.57079637f : negative ? 3.14159274f : 0.0f;
    float base_lo = small ? -4.37113883e-08f : negative ? -8.74227766e-08f : 0.0f;
    precise float minus_asin = -(factor * s_hi);
    FloatFloat sum = det_sum_ordered(base_hi, minus_asin);
    precise float result = sum.hi + (sum.lo + (base_lo - factor * tail));
    return magnitude <= 1.0f ? result : det_nan();
}

#endif
