#include "gi/radiosity/edge_integral.h"

#include <algorithm>
#include <cmath>

#include "core/host_math.h"

namespace plumb::radiosity {
namespace {

// The integral of ln sqrt(u^2 + h^2) from 0 to u, h >= 0.
double log_integral(double u, double h) {
    const double r2 = u * u + h * h;
    if (r2 == 0) return 0;
    return 0.5 * u * host::log(r2) - u + h * host::atan2(u, h);
}

// An integral of log_integral, even in u.
double second_log_integral(double u, double h) {
    const double r2 = u * u + h * h;
    if (r2 == 0) return 0;
    return 0.25 * (u * u - h * h) * host::log(r2) - 0.75 * u * u + h * u * host::atan2(u, h);
}

// The nodes above 0 and the middle of Gauss' rule of 7 points and Kronrod's of 15 (Kronrod 1965; QUADPACK's qk15).
constexpr double nodes[8] = {0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                             0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                             0.586087235467691130294144691693300, 0.405845151377397166906606412076961,
                             0.207784955007898467600689403773245, 0};
constexpr double kronrod[8] = {0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                               0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                               0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                               0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr double gauss[4] = {0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                             0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

// The inner integral over q at one point of p.
struct Inner {
    glm::dvec3 start, direction;  // p's
    glm::dvec3 other, other_direction;
    double other_length;
    double operator()(double s) const {
        const glm::dvec3 to = other - (start + direction * s);
        const double foot = -glm::dot(to, other_direction), h = glm::length(glm::cross(to, other_direction));
        return log_integral(other_length - foot, h) - log_integral(-foot, h);
    }
};

// Halves the interval until the rules' difference, taken as QUADPACK takes it, is within `tolerance` a unit of length.
void integrate(const Inner& f, double low, double high, double tolerance, int depth, EdgeIntegral& sum) {
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    double values[15], k = 0, g = 0;
    for (int i = 0; i < 8; ++i) {
        values[i] = f(middle - half * nodes[i]);
        values[14 - i] = i < 7 ? f(middle + half * nodes[i]) : values[7];
        const double pair = i < 7 ? values[i] + values[14 - i] : values[7];
        k += kronrod[i] * pair;
        if (i % 2 == 1) g += gauss[i / 2] * pair;
    }
    double spread = 0;
    for (int i = 0; i < 15; ++i) spread += kronrod[i < 8 ? i : 14 - i] * std::fabs(values[i] - 0.5 * k);
    spread *= half;
    double error = std::fabs(k - g) * half;
    if (spread > 0 && error > 0) {
        const double ratio = 200 * error / spread;
        error = spread * std::fmin(1, ratio * std::sqrt(ratio));
    }
    if (error > tolerance * 2 * half && depth > 0) {
        integrate(f, low, middle, tolerance, depth - 1, sum);
        integrate(f, middle, high, tolerance, depth - 1, sum);
        return;
    }
    sum.value += k * half, sum.error += error;
}

// Both on the same line or on parallel ones: `along` is q's direction in terms of p's, +1 or -1.
double parallel(const Edge& p, const Edge& q, const glm::dvec3& direction, double length, double q_length,
                double along) {
    const double a0 = glm::dot(q.from - p.from, direction), a1 = a0 + along * q_length;
    const double h = glm::length(glm::cross(q.from - p.from, direction));
    const double low = std::fmin(a0, a1), high = std::fmax(a0, a1);
    return (second_log_integral(length - low, h) - second_log_integral(low, h)) -
           (second_log_integral(length - high, h) - second_log_integral(high, h));
}

// On lines that cross at an angle: s and t are counted from where they do. As the divergence of (s, t) ln r is 2 ln r +
// 1, the integral over the rectangle is one over its border.
double crossing(double s0, double s1, double t0, double t1, double cosine, double sine) {
    auto along = [&](double fixed, double from, double to) {
        const double h = std::fabs(fixed) * sine, foot = fixed * cosine;
        return fixed * (log_integral(to - foot, h) - log_integral(from - foot, h));
    };
    return 0.5 *
           (along(s1, t0, t1) - along(s0, t0, t1) + along(t1, s0, s1) - along(t0, s0, s1) - (s1 - s0) * (t1 - t0));
}

}  // namespace

EdgeIntegral edge_integral(const Edge& p, const Edge& q, double tolerance) {
    EdgeIntegral result;
    const double p_length = glm::length(p.to - p.from), q_length = glm::length(q.to - q.from);
    if (!(p_length > 0 && q_length > 0)) return result;
    const glm::dvec3 d = (p.to - p.from) / p_length, e = (q.to - q.from) / q_length, across = glm::cross(d, e);
    const double cosine = glm::dot(d, e), sine = glm::length(across);
    if (std::fabs(cosine) <= 4e-16) return result;
    const glm::dvec3 gap = q.from - p.from;
    if (sine <= 4e-16) {
        result.value = parallel(p, q, d, p_length, q_length, cosine > 0 ? 1 : -1);
    } else {
        // Where the lines are nearest to each other, from p.from and q.from.
        const double s = glm::dot(glm::cross(gap, e), across) / (sine * sine);
        const double t = glm::dot(glm::cross(gap, d), across) / (sine * sine);
        const double distance = std::fabs(glm::dot(gap, across)) / sine;
        if (distance <= 1e-15 && sine > 0.01 && std::fabs(s) < 100 && std::fabs(t) < 100) {
            result.value = crossing(-s, p_length - s, -t, q_length - t, cosine, sine);
        } else {
            // Halved where the integrand bends most: near the other line, and beside its ends.
            const Inner f{p.from, d, q.from, e, q_length};
            double cuts[5] = {0, p_length, s, glm::dot(gap, d), glm::dot(q.to - p.from, d)};
            for (double& cut : cuts) cut = std::fmin(std::fmax(cut, 0), p_length);
            std::sort(cuts, cuts + 5);
            for (int i = 0; i < 4; ++i)
                if (cuts[i + 1] > cuts[i]) integrate(f, cuts[i], cuts[i + 1], tolerance / p_length, 48, result);
        }
    }
    result.value *= cosine, result.error *= std::fabs(cosine);
    result.magnitude = std::fabs(result.value) + p_length * q_length * std::fabs(cosine);
    return result;
}

}  // namespace plumb::radiosity
