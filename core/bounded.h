// Bounded: a float beside its double-precision shadow and a bound on what any legal device may make of it.
//
//     value   what the float kernel computes, to the bit
//     shadow  the same expression in double precision, along the branches of `value` or those that Decisions names
//     bound   >= |r - shadow| for every r that a device may compute, and for r = value
//
// Legal is: every rounding that the precision table grants (core/device_profile.h; PrecisionScope), fused
// multiply-adds, sums in any order, products in any order that meets no denormal, (a + b) c as a c + b c, a / b as
// a (1 / b), v / |v| as v * inversesqrt(v.v), mixes as a (1 - c) + b c for a + c (b - a), and denormals taken for 0.
// README.md derives the rules and says which forms are other formulas. Infinities and NaN have no precision on a GPU
// (Vulkan 1.3, SignedZeroInfNanPreserve), so what may overflow or divide by 0 has an infinite bound, and a NaN may be
// anything.
#pragma once

#include "core/decisions.h"
#include "core/number.h"

namespace plumb {

// The result of a comparison. Where it is undecided, it stays so until a select() or a branch asks for it.
struct BoundedMask {
    bool value;             // as the float kernel has it
    std::int32_t slot = 0;  // 0: decided; > 0: of Decisions; < 0: either, nobody enumerates

    BoundedMask(bool v = false) : value(v) {}
    static BoundedMask undecided(bool own) {
        BoundedMask m(own);
        const Decisions* d = bounded_state.decisions;
        m.slot = d && !d->widen ? bounded_state.decisions->slot() : -1;
        return m;
    }
    // As the current path has it; its own where nobody enumerates.
    bool resolved() const { return slot > 0 ? value != bounded_state.decisions->flipped(slot) : value; }

    friend BoundedMask operator!(BoundedMask a) {
        a.value = !a.value;
        return a;
    }
    friend BoundedMask operator&(BoundedMask a, BoundedMask b) {
        if (a.slot == 0) return a.value ? b : a;
        if (b.slot == 0) return b.value ? a : b;
        if (a.slot > 0) return a.resolved() ? b : BoundedMask(false);
        a.value = a.value && b.value;
        return a;
    }
    friend BoundedMask operator|(BoundedMask a, BoundedMask b) { return !((!a) & (!b)); }
    friend bool any(BoundedMask a) { return a.slot < 0 || a.resolved(); }
};

struct Bounded {
    float value = 0;
    // How the value came about, for the rules of sums (README.md): a sum of terms of that total magnitude, with so many
    // additions, or its product with one factor; a blend is a product with a difference, as c (b - a) is.
    std::uint16_t additions = 0;
    bool blend = false;
    bool ambiguous = false;  // an undecided comparison went into it while nobody enumerated
    double shadow = 0;
    double bound = 0;
    double magnitude = 0;  // read where additions > 0

    Bounded() = default;
    Bounded(float x) : value(x), shadow(x) {}
    explicit Bounded(double x) : Bounded(within(float(x), x, 0)) {}
    explicit Bounded(int x)
        : Bounded(within(float(x), x, double(float(x)) == x ? 0 : ulp_ratio * __builtin_fabs(double(x)))) {}
    // What is known to lie within `bound` of `shadow`: an attribute that a rasteriser interpolated, a dumped input that
    // was rounded.
    static Bounded within(float value, double shadow, double bound, bool ambiguous = false) {
        Bounded r;
        const double off = __builtin_fabs(double(value) - shadow);
        r.value = value, r.shadow = shadow, r.bound = off > bound ? off : bound, r.ambiguous = ambiguous;
        return r;
    }

    // Ends of the interval; a NaN may be anything.
    double low() const { return end(shadow - slack(), -__builtin_inf()); }
    double high() const { return end(shadow + slack(), __builtin_inf()); }
    bool exact() const { return bound == 0; }
    bool zero() const { return bound == 0 && shadow == 0; }
    // |a device's value| is at most this.
    double size() const { return __builtin_fabs(shadow) + bound; }
    double terms() const { return additions ? magnitude : size(); }

    friend Bounded operator+(const Bounded& a, const Bounded& b) { return sum(a, b, a.value + b.value, b.shadow); }
    friend Bounded operator-(const Bounded& a, const Bounded& b) { return sum(a, b, a.value - b.value, -b.shadow); }
    friend Bounded operator-(Bounded a) {
        a.value = -a.value, a.shadow = -a.shadow;
        return a;
    }
    friend Bounded operator*(const Bounded& a, const Bounded& b) {
        Bounded r;
        r.value = a.value * b.value, r.shadow = a.shadow * b.shadow, r.ambiguous = a.ambiguous || b.ambiguous;
        r.bound = __builtin_fabs(a.shadow) * b.bound + __builtin_fabs(b.shadow) * a.bound + a.bound * b.bound;
        // (x + y) b may be x b + y b: a sum of products, each of which rounds.
        const bool of_sum = (a.additions > 0) != (b.additions > 0);
        const double terms = of_sum ? a.terms() * b.terms() : 0;
        // Every device has the exact product by 0; and by a power of two, while all stays normal.
        const bool exact = a.zero() || b.zero() ||
                           ((a.scales() || b.scales()) && a.normal() && b.normal() && r.normal());
        if (!exact) {
            const BoundedState& s = bounded_state;
            r.bound += s.multiply * (of_sum ? terms : r.size()) + (a.size() + b.size() + s.flushed) * s.flushed +
                       s.underflow;
        }
        r.blend = a.additions || b.additions;
        const int additions = of_sum ? a.additions + b.additions : 0;
        if (additions > 0 && additions <= long_sum) {
            r.additions = std::uint16_t(additions);
            r.magnitude = terms + bounded_state.multiply * terms;
        }
        return r.checked();
    }
    friend Bounded operator/(const Bounded& a, const Bounded& b) {
        const BoundedState& s = bounded_state;
        Bounded r;
        r.value = a.value / b.value, r.shadow = a.shadow / b.shadow, r.ambiguous = a.ambiguous || b.ambiguous;
        const double least = __builtin_fabs(b.shadow) - b.bound, size = __builtin_fabs(r.shadow);
        r.bound = __builtin_inf();
        if (!(least >= 0x1p-126)) return r;  // a denormal divisor may count as 0
        r.bound = 0;
        if (a.zero()) return r.checked();
        r.bound = (a.bound + size * b.bound + s.flushed) / least;
        r.bound += s.divide * (size + r.bound) + s.underflow;
        if (b.size() > 0x1p126) r.bound += size;  // 1/b may be denormal
        return r.checked();
    }
    Bounded& operator+=(const Bounded& b) { return *this = *this + b; }
    Bounded& operator-=(const Bounded& b) { return *this = *this - b; }
    Bounded& operator*=(const Bounded& b) { return *this = *this * b; }
    Bounded& operator/=(const Bounded& b) { return *this = *this / b; }

    friend BoundedMask operator<(const Bounded& a, const Bounded& b) {
        const bool own = a.value < b.value;
        if (a.high() < b.low() || a.low() >= b.high()) return own;
        return BoundedMask::undecided(own);
    }
    friend BoundedMask operator<=(const Bounded& a, const Bounded& b) {
        const bool own = a.value <= b.value;
        if (a.high() <= b.low() || a.low() > b.high()) return own;
        return BoundedMask::undecided(own);
    }
    friend BoundedMask operator>(const Bounded& a, const Bounded& b) { return b < a; }
    friend BoundedMask operator>=(const Bounded& a, const Bounded& b) { return b <= a; }
    friend BoundedMask operator==(const Bounded& a, const Bounded& b) {
        const bool own = a.value == b.value;
        if (a.high() < b.low() || a.low() > b.high() ||
            (a.low() == a.high() && b.low() == a.low() && b.high() == a.low()))
            return own;
        return BoundedMask::undecided(own);
    }

    // Overflow and NaN.
    Bounded checked() {
        if (!(__builtin_fabs(shadow) + bound <= 0x1.fffffep127)) bound = __builtin_inf();
        return *this;
    }

  private:
    static double end(double x, double otherwise) { return x == x ? x : otherwise; }
    double slack() const {
        return shadow != 0 && __builtin_fabs(shadow) < 0x1p-126 ? bound + bounded_state.flushed : bound;
    }
    bool normal() const { return __builtin_fabs(shadow) - bound >= 0x1p-126 || zero(); }
    // 0 or a power of two, exactly.
    bool scales() const {
        std::uint64_t bits;
        std::memcpy(&bits, &shadow, 8);
        return bound == 0 && (bits << 12) == 0;
    }

    // A sum of n terms t_i in any order errs by at most n - 1 roundings of sum |t_i|. Ours is charged for that: sums
    // of m and n additions, of total magnitudes M and N, have been charged m M + n N; both together need
    // (m + n + 1) (M + N).
    static Bounded sum(const Bounded& a, const Bounded& b, float value, double b_shadow) {
        const BoundedState& s = bounded_state;
        const bool ambiguous = a.ambiguous || b.ambiguous;
        if (b.zero()) return same(a, value, a.shadow, ambiguous);
        if (a.zero()) return same(b, value, b_shadow, ambiguous);
        Bounded r;
        r.value = value, r.shadow = a.shadow + b_shadow, r.ambiguous = ambiguous;
        const double of_a = a.terms(), of_b = b.terms();
        double m = a.additions, n = b.additions;
        // A sum of long sums is not taken apart: of the two, the longer counts as one term.
        if (m > 0 && n > 0 && (m > long_sum || n > long_sum)) (m < n ? n : m) = 0;
        double charge = of_a + of_b + m * of_b + n * of_a;
        // a + c (b - a) may be a (1 - c) + b c: 1 - c, its product and the sum round at the size of a. Of a blend that
        // is taken apart two are charged already.
        r.blend = a.blend && b.blend;
        if (a.blend != b.blend) charge += ((a.blend ? m : n) > 0 ? 1 : 3) * (a.blend ? of_b : of_a);
        const double rounding = s.add * charge + 2 * s.flushed + s.underflow;
        r.bound = a.bound + b.bound + rounding;
        r.magnitude = of_a + of_b + rounding;
        r.additions = std::uint16_t(m + n + 1 < 65535 ? m + n + 1 : 65535);
        return r.checked();
    }
    static constexpr double long_sum = 16;

    // a + 0, which no device rounds.
    static Bounded same(Bounded a, float value, double shadow, bool ambiguous) {
        a.value = value, a.shadow = shadow, a.ambiguous = ambiguous;
        if (a.shadow != 0 && __builtin_fabs(a.shadow) < 0x1p-126) a.bound += bounded_state.flushed;
        return a;
    }
};
static_assert(sizeof(Bounded) == 32);

Bounded undecided_select(BoundedMask m, const Bounded& a, const Bounded& b);
PLUMB_INLINE Bounded select(BoundedMask m, const Bounded& a, const Bounded& b) {
    if (m.slot == 0) [[likely]]
        return m.value ? a : b;
    return undecided_select(m, a, b);
}
PLUMB_INLINE std::int32_t select(BoundedMask m, std::int32_t a, std::int32_t b) {
    if (m.slot < 0 && a != b && bounded_state.decisions) bounded_state.decisions->ambiguous = true;
    return m.resolved() ? a : b;
}

// An index of which the options are first .. last: the float kernel's own or, while Decisions enumerates, another.
std::int32_t undecided_index(double first, double last, std::int32_t own);
PLUMB_INLINE std::int32_t decided_index(double first, double last, std::int32_t own) {
    return first == last && first >= -0x1p31 && first < 0x1p31 ? own : undecided_index(first, last, own);
}
// floor(x) as an index that picks what is read: a device may have dumped its choice, and Decisions prescribe it.
std::int32_t chosen(const Bounded& x);

// [low, high] around shadow, for the operations that are monotone in their operands.
PLUMB_INLINE Bounded within_ends(float value, double shadow, double low, double high, bool ambiguous) {
    double bound = low == high ? 0 : max(high - shadow, shadow - low);
    if (!(bound < __builtin_inf())) bound = __builtin_inf();
    Bounded r;
    r.value = value, r.shadow = shadow, r.bound = bound, r.ambiguous = ambiguous;
    return r;
}
PLUMB_INLINE Bounded min(const Bounded& a, const Bounded& b) {
    return within_ends(min(a.value, b.value), min(a.shadow, b.shadow), min(a.low(), b.low()), min(a.high(), b.high()),
                       a.ambiguous || b.ambiguous);
}
PLUMB_INLINE Bounded max(const Bounded& a, const Bounded& b) {
    return within_ends(max(a.value, b.value), max(a.shadow, b.shadow), max(a.low(), b.low()), max(a.high(), b.high()),
                       a.ambiguous || b.ambiguous);
}
// One step, so that both ends of what may be infinite are cut.
PLUMB_INLINE Bounded clamp(const Bounded& x, const Bounded& a, const Bounded& b) {
    return within_ends(clamp(x.value, a.value, b.value), clamp(x.shadow, a.shadow, b.shadow),
                       clamp(x.low(), a.low(), b.low()), clamp(x.high(), a.high(), b.high()),
                       x.ambiguous || a.ambiguous || b.ambiguous);
}
PLUMB_INLINE Bounded abs(Bounded a) {
    a.value = abs(a.value), a.shadow = abs(a.shadow), a.additions = 0, a.blend = false;
    return a;
}
// Of an interval that reaches below 0 the part above counts: a device's root of a negative number is no number.
PLUMB_INLINE Bounded sqrt(const Bounded& a) {
    const BoundedState& s = bounded_state;
    Bounded r;
    r.value = sqrt(a.value), r.shadow = sqrt(a.shadow), r.ambiguous = a.ambiguous;
    if (a.zero()) return r;
    const double low = sqrt(max(a.low(), 0.0));
    // sqrt(s) - sqrt(s - b) = b / (sqrt(s) + sqrt(s - b)), more than towards the other side
    r.bound = low > 0 ? a.bound / (r.shadow + low) : max(r.shadow, sqrt(a.high()) - r.shadow);
    r.bound += s.sqrt * (r.shadow + r.bound);
    if (a.low() < 0x1p-126) r.bound += sqrt(s.flushed);
    return r.checked();
}
Bounded undecided_floor(const Bounded& a, double first, double last);
PLUMB_INLINE Bounded floor(const Bounded& a) {
    const double first = floor(a.low()), last = floor(a.high());
    if (first != last) return undecided_floor(a, first, last);
    return within_ends(floor(a.value), first, first, first, a.ambiguous);
}

template <>
struct number<Bounded> {
    using mask = BoundedMask;
    using index = std::int32_t;
    static constexpr int width = 1;

    static index iota(int first) { return first; }
    static Bounded from_index(index i) { return Bounded(i); }
    static index round_to_index(const Bounded& x) {
        return decided_index(__builtin_rint(x.low()), __builtin_rint(x.high()), number<float>::round_to_index(x.value));
    }
    static index truncate_to_index(const Bounded& x) {
        return decided_index(__builtin_trunc(x.low()), __builtin_trunc(x.high()),
                             number<float>::truncate_to_index(x.value));
    }
    // The bits of what is not exact could be any.
    static index bits(const Bounded& x) {
        if (!x.exact() && bounded_state.decisions) bounded_state.decisions->ambiguous = true;
        return number<float>::bits(x.value);
    }
    static Bounded from_bits(index i) { return Bounded(number<float>::from_bits(i)); }
    template <class Component>
    static Bounded fetch(const Component* p, index i) {
        return Bounded(p[i]);
    }
    static index fetch(const std::int32_t* p, index i) { return p[i]; }
    template <class Component>
    static vec4<Bounded> fetch4(const Component* p, index i) {
        return exact(number<float>::fetch4(p, i));
    }
    template <class Component>
    static Record<Bounded> fetch_record(const Component* p, index i) {
        const Record<float> r = number<float>::fetch_record(p, i);
        return {exact(r.a), exact(r.b), exact(r.c)};
    }
    static void store(float* p, index i, const Bounded& value, mask active) {
        number<float>::store(p, i, value.value, active.resolved());
    }
    static void store4(float* p, index i, const vec4<Bounded>& v, mask active) {
        if (active.resolved()) number<float>::store4(p, i, {v.x.value, v.y.value, v.z.value, v.w.value}, true);
    }

  private:
    static vec4<Bounded> exact(const vec4<float>& t) {
        return {Bounded(t.x), Bounded(t.y), Bounded(t.z), Bounded(t.w)};
    }
};

}  // namespace plumb

template <>
struct std::numeric_limits<plumb::Bounded> {
    static constexpr bool is_specialized = true, is_iec559 = true, is_signed = true, is_integer = false;
};
