#include "gi/reference/form_factors.h"

#include <cmath>

#include "core/host_math.h"

namespace plumb::reference {

using host::atan;
using host::log;
using host::pi;

double opposed_rectangles(double a, double b, double c) {
    const double x = a / c, y = b / c, p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
    const double logarithm = 0.5 * log(p * p * q * q / (1 + x * x + y * y));
    return 2 / (pi * x * y) * (logarithm + x * q * atan(x / q) + y * p * atan(y / p) - x * atan(x) - y * atan(y));
}

double perpendicular_rectangles(double shared, double depth, double height) {
    const double w = depth / shared, h = height / shared, w2 = w * w, h2 = h * h, r2 = w2 + h2, r = std::sqrt(r2);
    const double logarithm = log((1 + w2) * (1 + h2) / (1 + r2)) + w2 * log(w2 * (1 + r2) / ((1 + w2) * r2)) +
                             h2 * log(h2 * (1 + r2) / ((1 + h2) * r2));
    return (w * atan(1 / w) + h * atan(1 / h) - r * atan(1 / r) + 0.25 * logarithm) / (pi * w);
}

double patch_to_disc(double radius, double distance) {
    return radius * radius / (radius * radius + distance * distance);
}

double patch_to_disc_aside(double radius, double distance, double aside) {
    const double r2 = radius * radius, d2 = distance * distance + aside * aside, z = d2 + r2;
    return 0.5 * (1 - (d2 - r2) / std::sqrt(z * z - 4 * aside * aside * r2));
}

double upright_patch_to_disc(double radius, double distance, double aside) {
    const double r2 = radius * radius, z = distance * distance + aside * aside + r2;
    return 0.5 * distance / aside * (z / std::sqrt(z * z - 4 * aside * aside * r2) - 1);
}

double tilted_patch_to_disc(double radius, double distance, double angle) {
    const double share = patch_to_disc(radius, distance), sine = std::sqrt(share), half_angle = host::asin(sine);
    if (angle <= 0.5 * pi - half_angle) return host::cos(angle) * share;
    if (angle >= 0.5 * pi + half_angle) return 0;
    // h = 1 / sine is a sphere's distance over its radius.
    const double k = std::sqrt(1 / share - 1), c = host::cos(angle), s = host::sin(angle);
    const double edge = std::sqrt(std::fmax(1 - c * c / share, 0));
    const double within = std::fmin(std::fmax(k * sine / s, -1), 1), turn = std::fmin(std::fmax(-k * c / s, -1), 1);
    return 0.5 - host::asin(within) / pi + share / pi * (c * host::acos(turn) - k * edge);
}

double coaxial_discs(double from, double to, double distance) {
    const double x = 1 + (distance * distance + to * to) / (from * from), ratio = to / from;
    return 2 * ratio * ratio / (x + std::sqrt(x * x - 4 * ratio * ratio));  // 1/2 (x - sqrt(..)), without cancellation
}

double sphere_to_coaxial_disc(double disc, double distance) {
    return 0.5 * (1 - distance / std::sqrt(distance * distance + disc * disc));
}

}  // namespace plumb::reference
