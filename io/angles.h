// Angles in degrees. Private to io/.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

#include "core/host_math.h"

namespace plumb::io {

// Sine and cosine of degrees, exact at multiples of a right angle.
inline glm::dvec2 sin_cos_deg(double degrees) {
    const double turn = degrees - 360 * std::floor(degrees / 360);
    if (turn == 0) return {0, 1};
    if (turn == 90) return {1, 0};
    if (turn == 180) return {0, -1};
    if (turn == 270) return {-1, 0};
    const double radians = turn * (host::pi / 180);
    return {host::sin(radians), host::cos(radians)};
}

}  // namespace plumb::io
