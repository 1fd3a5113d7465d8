// core/detmath.h for Bounded: the value as float has it, the shadow in double, and as bound how far the function moves
// while its argument moves within its own bound, plus one unit in the last place. Part of core/detmath.h.
#pragma once

#include "core/bounded.h"
#include "core/detmath.h"

namespace plumb::detmath {

// The constructor adds half a unit for a rounded operation; this adds the other half, and gives up where nothing holds.
PLUMB_INLINE Bounded bounded(float value, double shadow, double reach, bool ambiguous) {
    return {value, shadow, reach == reach ? reach + Bounded::half_ulp(shadow) : __builtin_inf(), ambiguous};
}

// How far f gets from `middle` at the ends of an interval; a monotone f gets no farther inside.
PLUMB_INLINE double farther(double middle, double a, double b) {
    const double to_a = abs(a - middle), to_b = abs(b - middle);
    return to_a >= to_b || to_a != to_a ? to_a : to_b;
}

// A bound of zero says that the argument is exact, also where f(x) - f(x) would be infinity - infinity.
#define PLUMB_MONOTONE(f)                                                                                        \
    PLUMB_INLINE Bounded f(Bounded x) {                                                                          \
        const double shadow = host::f(x.shadow);                                                                 \
        const double reach =                                                                                     \
            x.bound > 0 ? farther(shadow, host::f(x.shadow - x.bound), host::f(x.shadow + x.bound)) : 0;         \
        return bounded(f(x.value), shadow, reach, x.ambiguous);                                                  \
    }
PLUMB_MONOTONE(exp)
PLUMB_MONOTONE(exp2)
PLUMB_MONOTONE(log)
PLUMB_MONOTONE(log2)
#undef PLUMB_MONOTONE

PLUMB_INLINE Bounded acos(Bounded x) {
    // No argument beyond -1 or 1 gives an angle beyond theirs.
    const double shadow = host::acos(clamp(x.shadow, -1.0, 1.0));
    const double low = host::acos(clamp(x.shadow - x.bound, -1.0, 1.0));
    const double high = host::acos(clamp(x.shadow + x.bound, -1.0, 1.0));
    return bounded(acos(x.value), shadow, farther(shadow, low, high), x.ambiguous);
}

// The slope of sine and cosine is at most 1, and their values lie at most 2 apart.
PLUMB_INLINE Bounded sin(Bounded x) {
    return bounded(sin(x.value), host::sin(x.shadow), min(x.bound, 2.0), x.ambiguous);
}
PLUMB_INLINE Bounded cos(Bounded x) {
    return bounded(cos(x.value), host::cos(x.shadow), min(x.bound, 2.0), x.ambiguous);
}

// For x > 0 the power is monotone in x and in y: the corners of the rectangle of arguments hold the extremes.
PLUMB_INLINE Bounded pow(Bounded x, Bounded y) {
    const double shadow = host::pow(x.shadow, y.shadow), x_low = x.shadow - x.bound, x_high = x.shadow + x.bound;
    double reach = 0;
    if (x.bound > 0 || y.bound > 0) {
        const double low = farther(shadow, host::pow(x_low, y.shadow - y.bound), host::pow(x_low, y.shadow + y.bound));
        const double high =
            farther(shadow, host::pow(x_high, y.shadow - y.bound), host::pow(x_high, y.shadow + y.bound));
        reach = x_low > 0 ? max(low, high) : __builtin_inf();
    }
    return bounded(pow(x.value, y.value), shadow, reach, x.ambiguous || y.ambiguous);
}

}  // namespace plumb::detmath
