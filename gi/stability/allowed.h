// Bounds the error of float, for evaluate.cpp and unbound_look.cpp. See README.md.
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb::stability {

inline constexpr double eps = 0x1p-23, largest_float = 0x1.fffffep127, least_normal = 0x1p-126, least_step = 0x1p-149;

inline bool is_float(double x) { return std::abs(x) <= largest_float; }

// The unit of C: the error that the inputs explain. Never less than what makes C of it 2^-126: a device may
// flush any denormal to 0, so an error up to there is no error of the stage.
inline double allowed_error(double explained, double budget) { return std::max(explained, least_normal / budget); }
inline bool by_the_floor(double explained, double budget) { return explained < least_normal / budget; }

// Half the spacing of floats about x.
inline double half_ulp(double x) {
    return std::max(least_step, std::ldexp(eps, std::ilogb(std::max(x, least_normal)))) / 2;
}

}  // namespace plumb::stability
