// core/detmath.h for Bounded: the value as float has it, the shadow in double, and as bound how far the function moves
// while its argument moves within its own bound, plus what its own computation may err. Part of core/detmath.h.
//
// A twin calls our functions (core/detmath.glsl), which err by less than one unit in the last place. A shader of one's
// own calls its driver's exp, exp2, log, log2 and pow, so those are granted what the precision table says.
#pragma once

#include "core/bounded.h"
#include "core/detmath.h"

namespace plumb::detmath {

// `reach` is how far the result moves with the argument, `grant` what computing it may err.
PLUMB_INLINE Bounded bounded(float value, double shadow, double reach, double grant, bool ambiguous) {
    Bounded r = Bounded::within(value, shadow, reach + grant + bounded_state.underflow, ambiguous);
    return r.checked();
}

// How far f gets from `middle` at the ends of an interval; a monotone f gets no farther inside.
PLUMB_INLINE double farther(double middle, double a, double b) {
    const double to_a = abs(a - middle), to_b = abs(b - middle);
    return to_a >= to_b || to_a != to_a ? to_a : to_b;
}

// Of 2^e. Another base takes a product with a rounded constant, before or after: one unit and a half.
PLUMB_INLINE double exp2_grant(double size, double e) {
    return size * (bounded_state.exp2 + bounded_state.exp2_slope * abs(e));
}
PLUMB_INLINE double log2_grant(double size) { return max(size * bounded_state.log2, bounded_state.log2_absolute); }

// A bound of zero says that the argument is exact, also where f(x) - f(x) would be infinity - infinity.
#define PLUMB_MONOTONE(f, grant)                                                                     \
    PLUMB_INLINE Bounded f(const Bounded& x) {                                                       \
        const double shadow = host::f(x.shadow);                                                     \
        const double reach = x.bound > 0 ? farther(shadow, host::f(x.low()), host::f(x.high())) : 0; \
        const double size = abs(shadow) + reach;                                                     \
        return bounded(f(x.value), shadow, reach, grant, x.ambiguous);                               \
    }
PLUMB_MONOTONE(exp, exp2_grant(size, 1.4427 * x.size()) + 1.5 * bounded_state.multiply * x.size() * size)
PLUMB_MONOTONE(exp2, exp2_grant(size, x.size()))
// A shader of one's own may say exp(x) - 1: the exponential errs at its own size, and the difference rounds.
PLUMB_MONOTONE(expm1, exp2_grant(size + 1, 1.4427 * x.size()) +
                          1.5 * bounded_state.multiply * x.size() * (size + 1) + bounded_state.add * (size + 1))
PLUMB_MONOTONE(log, log2_grant(size) + 1.5 * bounded_state.multiply * size)
PLUMB_MONOTONE(log2, log2_grant(size))
#undef PLUMB_MONOTONE

PLUMB_INLINE Bounded acos(const Bounded& x) {
    // No argument beyond -1 or 1 gives an angle beyond theirs.
    const double shadow = host::acos(clamp(x.shadow, -1.0, 1.0));
    const double low = host::acos(clamp(x.low(), -1.0, 1.0));
    const double high = host::acos(clamp(x.high(), -1.0, 1.0));
    return bounded(acos(x.value), shadow, farther(shadow, low, high), ulp_ratio * shadow, x.ambiguous);
}

// The slope of sine and cosine is at most 1, and their values lie at most 2 apart.
PLUMB_INLINE Bounded sin(const Bounded& x) {
    return bounded(sin(x.value), host::sin(x.shadow), min(x.bound, 2.0), ulp_ratio, x.ambiguous);
}
PLUMB_INLINE Bounded cos(const Bounded& x) {
    return bounded(cos(x.value), host::cos(x.shadow), min(x.bound, 2.0), ulp_ratio, x.ambiguous);
}

// For x >= 0 the power is monotone in x and in y: the corners of the rectangle of arguments hold the extremes. The
// device's exponent y log2 x errs by its logarithm and its product, and 2^e moves by 2^e ln 2 times that.
PLUMB_INLINE Bounded pow(const Bounded& x, const Bounded& y) {
    const bool ambiguous = x.ambiguous || y.ambiguous;
    const double shadow = host::pow(x.shadow, y.shadow);
    const double x_low = x.low() > 0 || y.low() <= 0 ? x.low() : max(x.low(), 0.0);
    double reach = 0;
    if (x.bound > 0 || y.bound > 0) {
        const double low = farther(shadow, host::pow(x_low, y.low()), host::pow(x_low, y.high()));
        const double high = farther(shadow, host::pow(x.high(), y.low()), host::pow(x.high(), y.high()));
        reach = x_low >= 0 ? max(low, high) : __builtin_inf();
    }
    if (x.zero() && y.low() > 0) return bounded(pow(x.value, y.value), shadow, 0, 0, ambiguous);
    const double size = abs(shadow) + reach;
    // Of the smallest float where there is 0, whose power is 0 whatever its logarithm is.
    const double logarithm = max(abs(host::log2(max(abs(x.shadow), 0x1p-149))), abs(host::log2(max(x_low, 0x1p-149))));
    const double exponent = y.size() * logarithm;
    const double off = y.size() * log2_grant(logarithm) + bounded_state.multiply * exponent;
    return bounded(pow(x.value, y.value), shadow, reach, exp2_grant(size, exponent) + size * 0.6932 * off * (1 + off),
                   ambiguous);
}

}  // namespace plumb::detmath
