// Followed: a float beside a double that takes the same way through a kernel.
//
//     value   what the float kernel computes, to the bit
//     exact   the same formulas in double precision, from the same inputs, along float's decisions
//
// Decisions are comparisons, floors, truncations, roundings to an index and bits(): each goes through the thread's
// DecisionTape (FollowScope). While it records, `value` decides; while it follows, what was recorded: the inputs may
// then have been moved, and `exact` tells what that changes. min, max, abs and clamp are continuous and decide nothing.
//
// One type does both, so that recording and following run the same code: compilers may evaluate the two sides of `&`,
// or a function's arguments, in an order that differs between types.
#pragma once

#include "core/decision_tape.h"
#include "core/number.h"

namespace plumb {

// The thread's tape. Whoever computes with Followed sets one.
inline constinit thread_local DecisionTape* followed_tape = nullptr;

class FollowScope {
  public:
    explicit FollowScope(DecisionTape& tape) : saved_(followed_tape) { followed_tape = &tape; }
    ~FollowScope() { followed_tape = saved_; }
    FollowScope(const FollowScope&) = delete;
    FollowScope& operator=(const FollowScope&) = delete;

  private:
    DecisionTape* saved_;
};

struct Followed {
    float value = 0;
    double exact = 0;

    Followed() = default;
    Followed(float x) : value(x), exact(x) {}
    explicit Followed(double x) : value(float(x)), exact(x) {}
    explicit Followed(int x) : value(float(x)), exact(x) {}
    Followed(float v, double e) : value(v), exact(e) {}

    friend Followed operator+(const Followed& a, const Followed& b) { return {a.value + b.value, a.exact + b.exact}; }
    friend Followed operator-(const Followed& a, const Followed& b) { return {a.value - b.value, a.exact - b.exact}; }
    friend Followed operator*(const Followed& a, const Followed& b) { return {a.value * b.value, a.exact * b.exact}; }
    friend Followed operator/(const Followed& a, const Followed& b) { return {a.value / b.value, a.exact / b.exact}; }
    friend Followed operator-(const Followed& a) { return {-a.value, -a.exact}; }
    Followed& operator+=(const Followed& b) { return *this = *this + b; }
    Followed& operator-=(const Followed& b) { return *this = *this - b; }
    Followed& operator*=(const Followed& b) { return *this = *this * b; }
    Followed& operator/=(const Followed& b) { return *this = *this / b; }

    friend bool operator<(const Followed& a, const Followed& b) {
        return decided(a.value < b.value, a.exact < b.exact);
    }
    friend bool operator>(const Followed& a, const Followed& b) {
        return decided(a.value > b.value, a.exact > b.exact);
    }
    friend bool operator<=(const Followed& a, const Followed& b) {
        return decided(a.value <= b.value, a.exact <= b.exact);
    }
    friend bool operator>=(const Followed& a, const Followed& b) {
        return decided(a.value >= b.value, a.exact >= b.exact);
    }
    friend bool operator==(const Followed& a, const Followed& b) {
        return decided(a.value == b.value, a.exact == b.exact);
    }

  private:
    static bool decided(bool of_float, bool of_double) { return followed_tape->decide(of_float, of_double) != 0; }
};

PLUMB_INLINE Followed select(bool m, const Followed& a, const Followed& b) { return m ? a : b; }
PLUMB_INLINE Followed min(const Followed& a, const Followed& b) {
    return {min(a.value, b.value), min(a.exact, b.exact)};
}
PLUMB_INLINE Followed max(const Followed& a, const Followed& b) {
    return {max(a.value, b.value), max(a.exact, b.exact)};
}
PLUMB_INLINE Followed abs(const Followed& a) { return {abs(a.value), abs(a.exact)}; }
PLUMB_INLINE Followed sqrt(const Followed& a) { return {sqrt(a.value), sqrt(a.exact)}; }

// The whole number that float took, for both: a double that lies on its other side is told by how far it is from it.
PLUMB_INLINE Followed floor(const Followed& a) {
    using N = number<float>;
    const float own = floor(a.value);
    // + 0: a floor of -0 is no other decision than one of 0.
    const std::int32_t taken = followed_tape->decide(N::bits(own + 0.0f), N::bits(float(floor(a.exact)) + 0.0f));
    return {own, double(N::from_bits(taken))};
}

template <>
struct number<Followed> {
    using mask = bool;
    using index = std::int32_t;
    static constexpr int width = 1;

    static index iota(int first) { return first; }
    static Followed from_index(index i) { return Followed(i); }
    static index round_to_index(const Followed& x) {
        return followed_tape->decide(number<float>::round_to_index(x.value), number<double>::round_to_index(x.exact));
    }
    static index truncate_to_index(const Followed& x) {
        return followed_tape->decide(number<float>::truncate_to_index(x.value),
                                     number<double>::truncate_to_index(x.exact));
    }
    static index bits(const Followed& x) {
        return followed_tape->decide(number<float>::bits(x.value), number<float>::bits(float(x.exact)));
    }
    static Followed from_bits(index i) { return Followed(number<float>::from_bits(i)); }
    static Followed fetch(const float* p, index i) { return Followed(p[i]); }
    static index fetch(const std::int32_t* p, index i) { return p[i]; }
    template <class Component>
    static vec4<Followed> fetch4(const Component* p, index i) {
        return both(number<float>::fetch4(p, i));
    }
    template <class Component>
    static Record<Followed> fetch_record(const Component* p, index i) {
        const Record<float> r = number<float>::fetch_record(p, i);
        return {both(r.a), both(r.b), both(r.c)};
    }
    static void store(float* p, index i, const Followed& value, mask active) {
        number<float>::store(p, i, value.value, active);
    }
    static void store4(float* p, index i, const vec4<Followed>& v, mask active) {
        number<float>::store4(p, i, {v.x.value, v.y.value, v.z.value, v.w.value}, active);
    }

  private:
    static vec4<Followed> both(const vec4<float>& t) {
        return {Followed(t.x), Followed(t.y), Followed(t.z), Followed(t.w)};
    }
};

}  // namespace plumb

template <>
struct std::numeric_limits<plumb::Followed> {
    static constexpr bool is_specialized = true, is_iec559 = true, is_signed = true, is_integer = false;
};
