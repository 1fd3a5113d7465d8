#include "core/sequences.h"

#include <algorithm>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"

namespace plumb {
namespace {

constexpr double pi = host::pi, two_pi = 2 * host::pi;
constexpr double below_one = 0x1.fffffffffffffp-1;

std::uint32_t reversed_bits(std::uint32_t v) {
    v = v << 16 | v >> 16;
    v = (v & 0x00ff00ff) << 8 | (v >> 8 & 0x00ff00ff);
    v = (v & 0x0f0f0f0f) << 4 | (v >> 4 & 0x0f0f0f0f);
    v = (v & 0x33333333) << 2 | (v >> 2 & 0x33333333);
    return (v & 0x55555555) << 1 | (v >> 1 & 0x55555555);
}

glm::dvec2 on_circle(double radius, double turn) {
    return {radius * host::cos(two_pi * turn), radius * host::sin(two_pi * turn)};
}
// The part of a full turn at which (x, y) lies, in [0, 1).
double turn_of(double x, double y) {
    const double turn = host::atan2(y, x) / two_pi;
    return std::min(turn < 0 ? turn + 1 : turn, below_one);
}
double square(double x) { return x * x; }
double clamp_unit(double x) { return std::min(std::max(x, 0.0), below_one); }

// A direction of height z, its sine from (1 - z)(1 + z) given apart: exact near the pole.
glm::dvec3 direction(double z, double sine_squared, double turn) {
    return {on_circle(std::sqrt(std::max(sine_squared, 0.0)), turn), z};
}
glm::dvec2 height_and_turn(double height, const glm::dvec3& d) { return {clamp_unit(height), turn_of(d.x, d.y)}; }

// Distance squared on the square whose opposite edges meet.
double wrapped_distance_squared(const glm::dvec2& a, const glm::dvec2& b) {
    const double x = std::fabs(a.x - b.x), y = std::fabs(a.y - b.y);
    return square(std::min(x, 1 - x)) + square(std::min(y, 1 - y));
}

}  // namespace

// ---- Points -------------------------------------------------------------------------------------------------------

double van_der_corput(std::uint64_t i, std::uint32_t base) {
    // Collects the mirrored digits as an integer, so that one division rounds once.
    std::uint64_t mirrored = 0, scale = 1;
    for (; i > 0 && scale < (std::uint64_t(1) << 53) / base; i /= base) {
        mirrored = mirrored * base + i % base;
        scale *= base;
    }
    return double(mirrored) / double(scale);
}

glm::dvec2 halton(std::uint64_t i) { return {van_der_corput(i, 2), van_der_corput(i, 3)}; }

glm::dvec2 hammersley(std::uint64_t i, std::uint64_t n) { return {(double(i) + 0.5) / double(n), van_der_corput(i)}; }

glm::dvec2 r2(std::uint64_t i) {
    // 1/g and 1/g^2 in units of 2^-64, so that the multiples wrap exactly. g = 1.32471795724474602596...
    constexpr std::uint64_t a = 0xc13fa9a902a6328f, b = 0x91e10da5c79e7b1d;
    constexpr std::uint64_t half = std::uint64_t(1) << 63;
    return {double((half + i * a) >> 11) * 0x1p-53, double((half + i * b) >> 11) * 0x1p-53};
}

glm::dvec2 sobol(std::uint32_t i) {
    // The second dimension's direction numbers are v_{k+1} = v_k ^ (v_k >> 1): the polynomial x + 1.
    std::uint32_t y = 0;
    std::uint32_t v = 1u << 31;
    for (std::uint32_t bits = i; bits; bits >>= 1, v ^= v >> 1)
        if (bits & 1) y ^= v;
    return {reversed_bits(i) * 0x1p-32, y * 0x1p-32};
}

std::vector<glm::dvec2> best_candidates(int n, std::uint32_t seed, int candidates) {
    std::vector<glm::dvec2> points;
    std::int32_t draw = 0;
    for (int k = 0; k < n; ++k) {
        // Draws candidates and keeps the one whose nearest neighbour is farthest; the first of equals.
        glm::dvec2 best(0);
        double best_distance = -1;
        for (int c = 0; c < std::max(1, candidates * k); ++c) {
            const auto h = pixel_hash<std::int32_t>(k, c, draw++, std::int32_t(seed));
            const glm::dvec2 p(unit_float<double>(h.x), unit_float<double>(h.y));
            double nearest = 4;
            for (const glm::dvec2& q : points) nearest = std::min(nearest, wrapped_distance_squared(p, q));
            if (nearest > best_distance) best = p, best_distance = nearest;
        }
        points.push_back(best);
    }
    return points;
}

// ---- Mappings -----------------------------------------------------------------------------------------------------

glm::dvec2 sample_disc(const glm::dvec2& u) { return on_circle(std::sqrt(u.x), u.y); }
double pdf_disc(const glm::dvec2& p) { return square(p.x) + square(p.y) <= 1 ? 1 / pi : 0; }
glm::dvec2 inverse_disc(const glm::dvec2& p) { return {clamp_unit(square(p.x) + square(p.y)), turn_of(p.x, p.y)}; }

glm::dvec2 sample_disc_concentric(const glm::dvec2& u) {
    const double x = 2 * u.x - 1, y = 2 * u.y - 1;
    if (x == 0 && y == 0) return {0, 0};
    // Each quarter of the square, between its diagonals, becomes a quarter of the disc.
    if (std::fabs(x) > std::fabs(y)) return on_circle(x, 0.125 * (y / x));
    return on_circle(y, 0.25 - 0.125 * (x / y));
}
glm::dvec2 inverse_disc_concentric(const glm::dvec2& p) {
    const double radius = std::sqrt(square(p.x) + square(p.y));
    if (radius == 0) return {0.5, 0.5};
    double x, y;
    if (std::fabs(p.x) > std::fabs(p.y)) {
        x = std::copysign(radius, p.x);
        y = x * 8 * host::atan2(p.y / p.x, 1) / two_pi;
    } else {
        y = std::copysign(radius, p.y);
        x = y * 8 * host::atan2(p.x / p.y, 1) / two_pi;
    }
    return {clamp_unit((x + 1) / 2), clamp_unit((y + 1) / 2)};
}

glm::dvec2 sample_disc_linear(const glm::dvec2& u) { return on_circle(u.x, u.y); }
double pdf_disc_linear(const glm::dvec2& p) {
    const double radius = std::sqrt(square(p.x) + square(p.y));
    return radius <= 1 ? 1 / (two_pi * radius) : 0;
}
glm::dvec2 inverse_disc_linear(const glm::dvec2& p) {
    return {clamp_unit(std::sqrt(square(p.x) + square(p.y))), turn_of(p.x, p.y)};
}

glm::dvec3 sample_sphere(const glm::dvec2& u) { return direction(1 - 2 * u.x, 4 * u.x * (1 - u.x), u.y); }
double pdf_sphere() { return 1 / (4 * pi); }
glm::dvec2 inverse_sphere(const glm::dvec3& d) { return height_and_turn((1 - d.z) / 2, d); }

glm::dvec3 sample_hemisphere(const glm::dvec2& u) { return direction(1 - u.x, u.x * (2 - u.x), u.y); }
double pdf_hemisphere(const glm::dvec3& d) { return d.z >= 0 ? 1 / two_pi : 0; }
glm::dvec2 inverse_hemisphere(const glm::dvec3& d) { return height_and_turn(1 - d.z, d); }

glm::dvec3 sample_cosine_hemisphere(const glm::dvec2& u) { return direction(std::sqrt(1 - u.x), u.x, u.y); }
double pdf_cosine_hemisphere(const glm::dvec3& d) { return d.z > 0 ? d.z / pi : 0; }
glm::dvec2 inverse_cosine_hemisphere(const glm::dvec3& d) { return height_and_turn(square(d.x) + square(d.y), d); }

glm::dvec3 sample_cosine_power(const glm::dvec2& u, double exponent) {
    const double z = host::pow(1 - u.x, 1 / (exponent + 1));
    return direction(z, (1 - z) * (1 + z), u.y);
}
double pdf_cosine_power(const glm::dvec3& d, double exponent) {
    return d.z > 0 ? (exponent + 1) / two_pi * host::pow(d.z, exponent) : 0;
}
glm::dvec2 inverse_cosine_power(const glm::dvec3& d, double exponent) {
    return height_and_turn(1 - host::pow(std::max(d.z, 0.0), exponent + 1), d);
}

glm::dvec3 sample_cone(const glm::dvec2& u, double cos_theta) {
    const double below = u.x * (1 - cos_theta);  // 1 - z
    return direction(1 - below, below * (2 - below), u.y);
}
double pdf_cone(const glm::dvec3& d, double cos_theta) { return d.z >= cos_theta ? 1 / (two_pi * (1 - cos_theta)) : 0; }
glm::dvec2 inverse_cone(const glm::dvec3& d, double cos_theta) {
    return height_and_turn((1 - d.z) / (1 - cos_theta), d);
}

// ---- Measures -----------------------------------------------------------------------------------------------------

double star_discrepancy(const std::vector<glm::dvec2>& points) {
    // The supremum is approached at boxes whose sides are coordinates of points, closed (more points than area) or
    // open.
    const double n = double(points.size());
    std::vector<double> xs;
    for (const glm::dvec2& p : points) xs.push_back(p.x);
    xs.push_back(1);
    std::sort(xs.begin(), xs.end());
    double worst = 0;
    std::vector<double> closed, open;
    for (double a : xs) {
        closed.clear(), open.clear();
        for (const glm::dvec2& p : points) {
            if (p.x <= a) closed.push_back(p.y);
            if (p.x < a) open.push_back(p.y);
        }
        std::sort(closed.begin(), closed.end());
        std::sort(open.begin(), open.end());
        for (std::size_t i = 0; i < closed.size(); ++i) worst = std::max(worst, double(i + 1) / n - a * closed[i]);
        for (std::size_t i = 0; i <= open.size(); ++i)
            worst = std::max(worst, a * (i < open.size() ? open[i] : 1) - double(i) / n);
    }
    return worst;
}

}  // namespace plumb
