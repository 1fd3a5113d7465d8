// What mutants may call: other precisions and roundings than a twin's own.
#ifndef PLUMB_MUTANTS_PRELUDE_GLSL
#define PLUMB_MUTANTS_PRELUDE_GLSL

// The nearest half, ties to even. Rounds the bits themselves: a compiler takes unpackHalf2x16(packHalf2x16(x)) for x, and
// the error is gone.
float half_of(float x) {
    int sign = floatBitsToInt(x) & -0x7fffffff - 1, bits = floatBitsToInt(x) & 0x7fffffff;
    int kept = bits + 0xfff + (bits >> 13 & 1) & ~0x1fff;  // 10 bits of the fraction
    if (bits < 0x38800000) kept = floatBitsToInt(roundEven(intBitsToFloat(bits) * 16777216.0) / 16777216.0);
    if (bits >= 0x477ff000) kept = max(bits, 0x7f800000);  // 65520 and beyond; a NaN stays
    return intBitsToFloat(kept | sign);
}
vec3 half_of(vec3 v) { return vec3(half_of(v.x), half_of(v.y), half_of(v.z)); }
float byte_of(float x) { return unpackUnorm4x8(packUnorm4x8(vec4(x, 0.0, 0.0, 0.0))).x; }

// What a b loses by being rounded (Dekker 1971, A floating-point technique for extending the available precision), and
// what a + b does (Knuth).
float upper_half(float a) { return intBitsToFloat(floatBitsToInt(a) & -4096); }
float lost_by_product(float a, float b) {
    precise float p = a * b, a_hi = upper_half(a), b_hi = upper_half(b), a_lo = a - a_hi, b_lo = b - b_hi;
    precise float lo = ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo;
    return lo;
}
float lost_by_sum(float a, float b) {
    precise float s = a + b, of_b = s - a, of_a = s - of_b;
    precise float lo = (a - of_a) + (b - of_b);
    return lo;
}

// a b + c, rounded once, as processors with such an instruction have it: software drivers take two roundings for fma().
float fused(float a, float b, float c) {
    precise float p = a * b, s = p + c;
    precise float result = s + (lost_by_sum(p, c) + lost_by_product(a, b));
    return result;
}
vec3 fused(vec3 a, vec3 b, vec3 c) {
    return vec3(fused(a.x, b.x, c.x), fused(a.y, b.y, c.y), fused(a.z, b.z, c.z));
}
float fused_dot(vec3 a, vec3 b) {
    precise float x = a.x * b.x;
    return fused(a.z, b.z, fused(a.y, b.y, x));
}

// Rounded towards zero, as the specification also allows.
float towards_zero(float nearest, float lost) {
    bool beyond = nearest > 0.0 && lost < 0.0 || nearest < 0.0 && lost > 0.0;
    return beyond ? intBitsToFloat(floatBitsToInt(nearest) - 1) : nearest;
}
float truncated_sum(float a, float b) {
    precise float s = a + b;
    return towards_zero(s, lost_by_sum(a, b));
}
float truncated_product(float a, float b) {
    precise float p = a * b;
    return towards_zero(p, lost_by_product(a, b));
}
float truncated_dot(vec3 a, vec3 b) {
    return truncated_sum(truncated_sum(truncated_product(a.x, b.x), truncated_product(a.y, b.y)),
                         truncated_product(a.z, b.z));
}

// The next float away from zero: what a division or a root may also give, for it may err by more than an ulp.
float next(float x) { return x == 0.0 ? x : intBitsToFloat(floatBitsToInt(x) + 1); }
vec3 next(vec3 v) { return vec3(next(v.x), next(v.y), next(v.z)); }

#endif
