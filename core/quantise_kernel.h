// quantise() of core/formats.h over any number type: what a pass that draws rounds its pixels with, while they are still
// in registers. The bits are those of quantise(), NaN included; formats.cpp stays the definition.
#pragma once

#include "core/formats.h"
#include "core/number.h"

namespace plumb {

// Formats that need double precision are left to quantise(): true where quantised() does the whole work.
inline bool quantised_by_kernel(Format format) {
    return format != Format::rgbe && format != Format::d24s8 && format != Format::d32f;
}

// x >= 0 rounded to 5 exponent bits (without an upper end) and `mantissa_bits`, ties to even.
template <class F>
PLUMB_INLINE F small_float_rounded(F x, int mantissa_bits) {
    using N = number<F>;
    using I = index_t<F>;
    const int dropped = 23 - mantissa_bits;
    // Adding half a unit, less one where the last bit that stays is even, carries into the exponent where it must.
    const I bits = N::bits(x), last = shift_right(bits, dropped) & I(1);
    const F normal = N::from_bits((bits + (last + I((1 << (dropped - 1)) - 1))) & I(-(1 << dropped)));
    // Denormals count units of 2^(-14 - mantissa_bits).
    const F unit(1.0f / float(1 << (14 + mantissa_bits)));
    const F denormal = N::from_index(N::round_to_index(min(x, F(1.0f)) / unit)) * unit;
    return select(x < F(0x1p-14f), denormal, normal);
}

template <class F>
PLUMB_INLINE F half_rounded(F x) {
    using N = number<F>;
    const F magnitude = small_float_rounded(abs(x), 10), infinity(__builtin_inff());
    const F r = select(magnitude < F(0x1p16f), magnitude, infinity);
    const F with_sign = N::from_bits(N::bits(r) | (N::bits(x) & index_t<F>(std::int32_t(0x80000000u))));
    return select(x == x, with_sign, F(__builtin_nanf("")));
}

template <class F>
PLUMB_INLINE F unsigned_small_float_rounded(F x, int mantissa_bits) {
    const F infinity(__builtin_inff()), largest((2.0f - 1.0f / float(1 << mantissa_bits)) * 0x1p15f);
    const F finite = select(x > F(0.0f), min(small_float_rounded(x, mantissa_bits), largest), F(0.0f));
    return select(x == x, select(x == infinity, infinity, finite), F(__builtin_nanf("")));
}

// 0..1, NaN to 0.
template <class F>
PLUMB_INLINE F clamped01(F x) {
    return select(x > F(0.0f), select(x < F(1.0f), x, F(1.0f)), F(0.0f));
}
template <class F>
PLUMB_INLINE F unorm_rounded(F x, float scale) {
    using N = number<F>;
    return N::from_index(N::round_to_index(clamped01(x) * F(scale))) / F(scale);
}
template <class F>
PLUMB_INLINE F snorm_rounded(F x, float scale) {
    using N = number<F>;
    using I = index_t<F>;
    const I code = N::round_to_index(clamped01(abs(x)) * F(scale));
    return N::from_index(select(x < F(0.0f), I(0) - code, code)) / F(scale);
}
// A component in -1..1 stored as unorm, as ISR (22) does in 8 bits.
template <class F>
PLUMB_INLINE F biased_rounded(F x, float scale) {
    using N = number<F>;
    const F code = N::from_index(N::round_to_index(clamped01(x * F(0.5f) + F(0.5f)) * F(scale)));
    return F(2.0f) * code / F(scale) - F(1.0f);
}

// The corners of the square belong to the lower half of the sphere: each is folded over its edge of the diamond.
template <class F>
PLUMB_INLINE vec2<F> folded(const vec2<F>& p) {
    const F x = F(1.0f) - abs(p.y), y = F(1.0f) - abs(p.x), zero(0.0f);
    return {select(p.x >= zero, x, -x), select(p.y >= zero, y, -y)};
}
template <class F>
PLUMB_INLINE vec3<F> octahedral_rounded(const vec3<F>& n, float scale) {
    const F zero(0.0f), sum = abs(n.x) + abs(n.y) + abs(n.z);
    const vec2<F> upper{n.x / sum, n.y / sum}, lower = folded<F>(upper);
    const mask_t<F> up = n.z >= zero, some = sum > zero;
    const F u = select(some, select(up, upper.x, lower.x), zero), v = select(some, select(up, upper.y, lower.y), zero);

    const vec2<F> p{snorm_rounded(u, scale), snorm_rounded(v, scale)};
    const F z = F(1.0f) - abs(p.x) - abs(p.y);
    const vec2<F> below = folded<F>(p);
    const vec3<F> r{select(z < zero, below.x, p.x), select(z < zero, below.y, p.y), z};
    const F length = sqrt(r.x * r.x + r.y * r.y + r.z * r.z);
    return {r.x / length, r.y / length, r.z / length};
}

// decode(encode(v)); v itself for a format that quantised_by_kernel() leaves out.
template <class F>
PLUMB_INLINE vec4<F> quantised(Format format, const vec4<F>& v) {
    const F zero(0.0f), one(1.0f);
    switch (format) {
        case Format::r32f: return {v.x, zero, zero, one};
        case Format::r16f: return {half_rounded(v.x), zero, zero, one};
        case Format::rgba16f: return {half_rounded(v.x), half_rounded(v.y), half_rounded(v.z), half_rounded(v.w)};
        case Format::rgba8:
            return {unorm_rounded(v.x, 255), unorm_rounded(v.y, 255), unorm_rounded(v.z, 255), unorm_rounded(v.w, 255)};
        case Format::r10g10b10a2:
            return {unorm_rounded(v.x, 1023), unorm_rounded(v.y, 1023), unorm_rounded(v.z, 1023),
                    unorm_rounded(v.w, 3)};
        case Format::r11g11b10f:
            return {unsigned_small_float_rounded(v.x, 6), unsigned_small_float_rounded(v.y, 6),
                    unsigned_small_float_rounded(v.z, 5), one};
        case Format::octahedral16: return {octahedral_rounded(xyz<F>(v), 32767), zero};
        case Format::octahedral8: return {octahedral_rounded(xyz<F>(v), 127), zero};
        case Format::normal8:
            return {biased_rounded(v.x, 255), biased_rounded(v.y, 255), biased_rounded(v.z, 255), zero};
        default: return v;
    }
}

}  // namespace plumb
