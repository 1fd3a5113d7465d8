// Rotations by angles in degrees.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

#include "core/host_math.h"

namespace plumb {

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

// By `degrees`, taking axis a towards axis b.
inline glm::dmat4 rotation_deg(double degrees, int a, int b) {
    const glm::dvec2 sc = sin_cos_deg(degrees);
    glm::dmat4 m(1);
    m[a][a] = m[b][b] = sc.y;
    m[a][b] = sc.x;
    m[b][a] = -sc.x;
    return m;
}

// By `degrees` about a unit axis, counter-clockwise as seen against it (Rodrigues).
inline glm::dmat3 rotation_about(const glm::dvec3& axis, double degrees) {
    const glm::dvec2 sc = sin_cos_deg(degrees);
    glm::dmat3 m(0);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) m[column][row] = axis[column] * axis[row] * (1 - sc.y);
    for (int i = 0; i < 3; ++i) {
        const int next = (i + 1) % 3, last = (i + 2) % 3;
        m[i][i] += sc.y;
        m[next][last] += axis[i] * sc.x;
        m[last][next] -= axis[i] * sc.x;
    }
    return m;
}

// Rolls about z by angles.z, pitches about x by angles.y, then turns by yaw about y by angles.x.
inline glm::dmat4 rotation_deg(const glm::dvec3& angles) {
    return rotation_deg(angles.x, 2, 0) * rotation_deg(angles.y, 1, 2) * rotation_deg(angles.z, 0, 1);
}

}  // namespace plumb
