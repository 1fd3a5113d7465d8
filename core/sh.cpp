#include "core/sh.h"

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"

namespace plumb::sh {
namespace {

void require_degree(int degree, int most = max_degree) {
    if (degree < 0 || degree > most)
        throw InputError("spherical harmonics: degree = " + std::to_string(degree) + ": must be 0.." + std::to_string(most));
}

// Y_lm = p_lm(z) times the real or imaginary part of (x + i y)^|m|, where p_lm is the normalised associated Legendre
// function over sin^m theta, a polynomial:
//     p_mm = diagonal[m]
//     p_lm = rise[l][m] (z p_{l-1,m} - fall[l][m] p_{l-2,m})
struct Recurrence {
    double diagonal[highest_degree + 1];
    double rise[highest_degree + 1][highest_degree + 1] = {}, fall[highest_degree + 1][highest_degree + 1] = {};

    Recurrence() {
        double zonal = std::sqrt(1 / (4 * host::pi));
        diagonal[0] = zonal;
        for (int m = 1; m <= highest_degree; ++m) {
            zonal *= std::sqrt((2 * m + 1) / (2. * m));
            diagonal[m] = std::sqrt(2) * zonal;  // cos(m phi) and sin(m phi) have half the square mean of 1
        }
        for (int l = 1; l <= highest_degree; ++l)
            for (int m = 0; m < l; ++m) {
                const int k = l - 1;
                rise[l][m] = std::sqrt((4. * l * l - 1) / (l * l - m * m));
                fall[l][m] = std::sqrt((k * k - m * m) / (4. * k * k - 1));
            }
    }
};

const Recurrence& table() {
    static const Recurrence table;
    return table;
}

// All functions up to `degree`, into y[count(degree)].
void evaluate_all(const glm::dvec3& d, int degree, Phase phase, double* y) {
    const Recurrence& table = sh::table();
    double cosine = 1, sine = 0;  // the parts of (d.x + i d.y)^m
    for (int m = 0; m <= degree; ++m) {
        const double sign = phase == Phase::condon_shortley && m % 2 ? -1 : 1;
        double p = table.diagonal[m], previous = 0;
        for (int l = m; l <= degree; ++l) {
            if (l > m) {
                const double next = table.rise[l][m] * (d.z * p - table.fall[l][m] * previous);
                previous = p, p = next;
            }
            y[index(l, m)] = sign * p * cosine;
            if (m > 0) y[index(l, -m)] = sign * p * sine;
        }
        const double next = cosine * d.x - sine * d.y;
        sine = cosine * d.y + sine * d.x, cosine = next;
    }
}

// Nodes and weights of Gauss and Legendre: the roots of P_n, by Newton's method.
struct GaussNode {
    double z, weight;
};
std::vector<GaussNode> gauss_legendre(int n) {
    std::vector<GaussNode> nodes;
    for (int i = 0; i < n; ++i) {
        double z = host::cos(host::pi * (i + 0.75) / (n + 0.5)), slope = 0;
        for (int step = 0; step < 8; ++step) {
            double p = 1, previous = 0;  // P_k and P_{k-1}
            for (int k = 1; k <= n; ++k) {
                const double next = ((2 * k - 1) * z * p - (k - 1) * previous) / k;
                previous = p, p = next;
            }
            slope = n * (z * p - previous) / (z * z - 1);
            z -= p / slope;
        }
        nodes.push_back({z, 2 / ((1 - z * z) * slope * slope)});
    }
    return nodes;
}

}  // namespace

Values basis(const glm::dvec3& d, int degree, Phase phase) {
    require_degree(degree);
    Values y{};
    evaluate_all(d, degree, phase, y.data());
    return y;
}

std::vector<double> long_basis(const glm::dvec3& d, int degree) {
    require_degree(degree, highest_degree);
    std::vector<double> y(std::size_t(count(degree)));
    evaluate_all(d, degree, Phase::none, y.data());
    return y;
}

std::array<float, max_count> basis(const glm::vec3& direction, int degree, Phase phase) {
    const Values y = basis(glm::dvec3(direction), degree, phase);
    std::array<float, max_count> rounded;
    for (int i = 0; i < max_count; ++i) rounded[i] = float(y[i]);
    return rounded;
}

const std::array<float, 2 * max_count>& recurrence() {
    static const auto rounded = [] {
        constexpr int side = max_degree + 1;
        std::array<float, 2 * max_count> r{};
        for (int l = 0; l < side; ++l) {
            r[std::size_t(side * l + l)] = float(table().diagonal[l]);
            for (int m = 0; m < l; ++m) {
                r[std::size_t(side * l + m)] = float(table().rise[l][m]);
                r[std::size_t(max_count + side * l + m)] = float(table().fall[l][m]);
            }
        }
        return r;
    }();
    return rounded;
}

std::vector<Node> quadrature(int degree) {
    // Products have degree 2 L in z and frequency 2 L in phi: L + 1 Gauss nodes and 2 L + 1 angles are exact; one more
    // angle makes the number even.
    require_degree(degree);
    const int angles = 2 * degree + 2;
    std::vector<Node> nodes;
    for (const GaussNode& g : gauss_legendre(degree + 1)) {
        const double radius = std::sqrt((1 - g.z) * (1 + g.z));
        for (int k = 0; k < angles; ++k) {
            const double phi = 2 * host::pi * k / angles;
            const glm::dvec3 direction(radius * host::cos(phi), radius * host::sin(phi), g.z);
            nodes.push_back({direction, g.weight * 2 * host::pi / angles});
        }
    }
    return nodes;
}

Rotation::Rotation(const glm::dmat3& r, int degree, Phase phase) : degree_(degree) {
    // Projects each rotated function Y_column(R^-1 d) onto Y_row; the quadrature is exact, and degrees do not mix.
    const glm::dmat3 inverse = glm::transpose(r);
    for (const Node& node : quadrature(degree)) {
        const Values y = basis(node.direction, degree, phase), rotated = basis(inverse * node.direction, degree, phase);
        for (int l = 0; l <= degree; ++l) {
            auto entry = block_[l].begin();
            for (int row = -l; row <= l; ++row)
                for (int column = -l; column <= l; ++column)
                    *entry++ += node.weight * y[index(l, row)] * rotated[index(l, column)];
        }
    }
}

const std::array<double, max_degree + 1>& clamped_cosine() {
    // Even l: 2 pi (-1)^(l/2 - 1) / ((l + 2)(l - 1)) * l! / (2^l (l/2)!^2).
    static const std::array<double, max_degree + 1> factors = {
        host::pi, 2 * host::pi / 3, host::pi / 4, 0, -host::pi / 24, 0, host::pi / 64, 0};
    return factors;
}

}  // namespace plumb::sh
