// Bounded: a float beside its double-precision shadow and a bound on what a device may make of it.
//
// The bound grows by what each operation may err (half a unit in the last place here; a device profile will set other
// grants), and a comparison whose operands overlap within their bounds marks its result as ambiguous: another branch
// would be legal too. What a kernel stores tells whether any comparison on its way was ambiguous.
#pragma once

#include "core/number.h"

namespace plumb {

struct BoundedMask {
    bool value, ambiguous;
    BoundedMask(bool v = false, bool a = false) : value(v), ambiguous(a) {}
    friend BoundedMask operator&(BoundedMask a, BoundedMask b) {
        return {a.value && b.value, (a.ambiguous && (b.value || b.ambiguous)) || (b.ambiguous && a.value)};
    }
    friend BoundedMask operator|(BoundedMask a, BoundedMask b) {
        return {a.value || b.value, (a.ambiguous && (!b.value || b.ambiguous)) || (b.ambiguous && !a.value)};
    }
    friend BoundedMask operator!(BoundedMask a) { return {!a.value, a.ambiguous}; }
    friend bool any(BoundedMask a) { return a.value || a.ambiguous; }
};

struct Bounded {
    float value = 0;
    double shadow = 0;
    double bound = 0;  // |any legal result - shadow| is at most this
    bool ambiguous = false;

    Bounded() = default;
    Bounded(float x) : value(x), shadow(x) {}
    explicit Bounded(double x) : value(float(x)), shadow(x), bound(half_ulp(x)) {}
    explicit Bounded(int x) : Bounded(double(x)) {}
    Bounded(float v, double s, double b, bool a) : value(v), shadow(s), bound(b + half_ulp(s)), ambiguous(a) {}

    static double half_ulp(double x) { return __builtin_fabs(x) * 0x1p-24 + 0x1p-150; }

    friend Bounded operator+(Bounded a, Bounded b) {
        return {a.value + b.value, a.shadow + b.shadow, a.bound + b.bound, a.ambiguous || b.ambiguous};
    }
    friend Bounded operator-(Bounded a, Bounded b) {
        return {a.value - b.value, a.shadow - b.shadow, a.bound + b.bound, a.ambiguous || b.ambiguous};
    }
    friend Bounded operator*(Bounded a, Bounded b) {
        const double bound = __builtin_fabs(a.shadow) * b.bound + __builtin_fabs(b.shadow) * a.bound + a.bound * b.bound;
        return {a.value * b.value, a.shadow * b.shadow, bound, a.ambiguous || b.ambiguous};
    }
    friend Bounded operator/(Bounded a, Bounded b) {
        const double q = a.shadow / b.shadow, least = __builtin_fabs(b.shadow) - b.bound;
        const double bound = least > 0 ? (a.bound + __builtin_fabs(q) * b.bound) / least : __builtin_inf();
        return {a.value / b.value, q, bound, a.ambiguous || b.ambiguous};
    }
    friend Bounded operator-(Bounded a) {
        a.value = -a.value, a.shadow = -a.shadow;
        return a;
    }
    Bounded& operator+=(Bounded b) { return *this = *this + b; }
    Bounded& operator-=(Bounded b) { return *this = *this - b; }
    Bounded& operator*=(Bounded b) { return *this = *this * b; }
    Bounded& operator/=(Bounded b) { return *this = *this / b; }

    static bool overlap(const Bounded& a, const Bounded& b) {
        return !(__builtin_fabs(a.shadow - b.shadow) > a.bound + b.bound) && (a.bound + b.bound) > 0;
    }
    friend BoundedMask operator<(Bounded a, Bounded b) { return {a.value < b.value, overlap(a, b)}; }
    friend BoundedMask operator<=(Bounded a, Bounded b) { return {a.value <= b.value, overlap(a, b)}; }
    friend BoundedMask operator>(Bounded a, Bounded b) { return b < a; }
    friend BoundedMask operator>=(Bounded a, Bounded b) { return b <= a; }
    friend BoundedMask operator==(Bounded a, Bounded b) { return {a.value == b.value, overlap(a, b)}; }
};

PLUMB_INLINE Bounded select(BoundedMask m, Bounded a, Bounded b) {
    Bounded r = m.value ? a : b;
    r.ambiguous = r.ambiguous || m.ambiguous;
    return r;
}
PLUMB_INLINE std::int32_t select(BoundedMask m, std::int32_t a, std::int32_t b) { return m.value ? a : b; }

// min and max are continuous: whichever operand a device takes, the results differ by no more than the bounds.
PLUMB_INLINE Bounded min(Bounded a, Bounded b) {
    return {min(a.value, b.value), min(a.shadow, b.shadow), max(a.bound, b.bound), a.ambiguous || b.ambiguous};
}
PLUMB_INLINE Bounded max(Bounded a, Bounded b) {
    return {max(a.value, b.value), max(a.shadow, b.shadow), max(a.bound, b.bound), a.ambiguous || b.ambiguous};
}
PLUMB_INLINE Bounded abs(Bounded a) { return {abs(a.value), abs(a.shadow), a.bound, a.ambiguous}; }
PLUMB_INLINE Bounded sqrt(Bounded a) {
    const double root = sqrt(a.shadow);
    // sqrt(s + b) - sqrt(s) <= min(b / (2 sqrt(s - b)), sqrt(b))
    const double least = a.shadow - a.bound;
    const double bound = least > 0 ? min(a.bound / (2 * sqrt(least)), sqrt(a.bound)) : sqrt(2 * a.bound);
    return {sqrt(a.value), root, bound, a.ambiguous};
}
PLUMB_INLINE Bounded floor(Bounded a) {
    const bool crosses = floor(a.shadow - a.bound) != floor(a.shadow + a.bound);
    Bounded r(floor(a.value));
    r.shadow = floor(a.shadow), r.ambiguous = a.ambiguous || crosses;
    return r;
}

template <>
struct number<Bounded> {
    using mask = BoundedMask;
    using index = std::int32_t;
    static constexpr int width = 1;

    static index iota(int first) { return first; }
    static Bounded from_index(index i) { return Bounded(i); }
    static index round_to_index(Bounded x) { return number<float>::round_to_index(x.value); }
    static index truncate_to_index(Bounded x) { return number<float>::truncate_to_index(x.value); }
    static index bits(Bounded x) { return number<float>::bits(x.value); }
    static Bounded from_bits(index i) { return Bounded(number<float>::from_bits(i)); }
    static Bounded fetch(const float* p, index i) { return Bounded(p[i]); }
    static index fetch(const std::int32_t* p, index i) { return p[i]; }
    template <class Component>
    static vec4<Bounded> fetch4(const Component* p, index i) {
        const vec4<float> t = number<float>::fetch4(p, i);
        return {Bounded(t.x), Bounded(t.y), Bounded(t.z), Bounded(t.w)};
    }
    template <class Component>
    static Record<Bounded> fetch_record(const Component* p, index i) {
        const Record<float> r = number<float>::fetch_record(p, i);
        auto widen = [](const vec4<float>& t) -> vec4<Bounded> {
            return {Bounded(t.x), Bounded(t.y), Bounded(t.z), Bounded(t.w)};
        };
        return {widen(r.a), widen(r.b), widen(r.c)};
    }
    static void store(float* p, index i, Bounded value, mask active) {
        number<float>::store(p, i, value.value, active.value);
    }
    static void store4(float* p, index i, const vec4<Bounded>& v, mask active) {
        if (active.value) number<float>::store4(p, i, {v.x.value, v.y.value, v.z.value, v.w.value}, true);
    }
};

}  // namespace plumb

template <>
struct std::numeric_limits<plumb::Bounded> {
    static constexpr bool is_specialized = true, is_iec559 = true, is_signed = true, is_integer = false;
};
