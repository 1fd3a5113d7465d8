// Places that fill a triangle evenly.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

namespace plumb::radiosity {

// The k-th of a sequence, as weights of the corners; the first is the middle (R2: Roberts 2018, folded).
inline glm::dvec3 triangle_place(int k) {
    double u = 1.0 / 3 + k * 0.7548776662466927, v = 1.0 / 3 + k * 0.5698402909980532;
    u -= std::floor(u), v -= std::floor(v);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    return {1 - u - v, u, v};
}

}  // namespace plumb::radiosity
