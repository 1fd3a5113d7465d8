// Real spherical harmonics to degree 7: 64 functions, orthonormal over the sphere.
//
// Index l (l + 1) + m, l = 0..7 the degree, m = -l..l. Default sign as IPR fig. 3.4: Y_1 = sqrt(3 / 4 pi) (y, z, x),
// that is, without the Condon-Shortley phase (-1)^m, which `condon_shortley` adds for the dumps of programs that have
// it. Directions are unit; z is the pole.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::sh {

inline constexpr int max_degree = 7;
inline constexpr int max_count = (max_degree + 1) * (max_degree + 1);

constexpr int count(int degree) { return (degree + 1) * (degree + 1); }
constexpr int index(int l, int m) { return l * (l + 1) + m; }

enum class Phase { none, condon_shortley };

// All functions up to `degree` (0..7, else InputError) at a unit direction; the others are 0. The float form rounds the
// double one.
using Values = std::array<double, max_count>;
Values basis(const glm::dvec3& direction, int degree = max_degree, Phase phase = Phase::none);
std::array<float, max_count> basis(const glm::vec3& direction, int degree = max_degree, Phase phase = Phase::none);
// The same to a higher degree, 14 at most: products of two functions up to max_degree are sums of these.
inline constexpr int highest_degree = 2 * max_degree;
std::vector<double> long_basis(const glm::dvec3& direction, int degree);

// What kernels compute the functions from (core/sh_kernel.h), each number rounded once: rise[l][m] at 8 l + m, rise[m][m]
// the factor of (x + i y)^m, then fall[l][m].
const std::array<float, 2 * max_count>& recurrence();

// Coefficients of a function with values of type T: double, or glm::dvec3 for three channels.
template <class T>
using Coefficients = std::array<T, max_count>;

// sum of c_i Y_i(direction).
template <class T>
T evaluate(const Coefficients<T>& c, const glm::dvec3& direction, int degree = max_degree, Phase phase = Phase::none) {
    const Values y = basis(direction, degree, phase);
    T sum = c[0] * y[0];
    for (int i = 1; i < count(degree); ++i) sum += c[i] * y[i];
    return sum;
}

// A quadrature over the sphere that integrates every product of two functions up to `degree` exactly (to rounding):
// Gauss-Legendre in z by uniform angles. The weights sum to 4 pi.
struct Node {
    glm::dvec3 direction;
    double weight;
};
std::vector<Node> quadrature(int degree = max_degree);

// c_i = integral of f Y_i, by the quadrature: exact for functions of the span.
template <class F>
auto project(F f, int degree = max_degree, Phase phase = Phase::none) {
    Coefficients<decltype(f(glm::dvec3()))> c{};
    for (const Node& node : quadrature(degree)) {
        const Values y = basis(node.direction, degree, phase);
        const auto value = f(node.direction) * node.weight;
        for (int i = 0; i < count(degree); ++i) c[i] += value * y[i];
    }
    return c;
}

// The matrices that rotate coefficients, one block of (2l + 1)^2 a degree: evaluate(rotate(c), R d) = evaluate(c, d).
class Rotation {
  public:
    explicit Rotation(const glm::dmat3& r, int degree = max_degree, Phase phase = Phase::none);  // r orthogonal

    double at(int l, int row, int column) const { return block_[l][std::size_t((row + l) * (2 * l + 1) + column + l)]; }

    template <class T>
    Coefficients<T> operator()(const Coefficients<T>& c) const {
        Coefficients<T> rotated{};
        for (int l = 0; l <= degree_; ++l)
            for (int row = -l; row <= l; ++row)
                for (int column = -l; column <= l; ++column)
                    rotated[index(l, row)] += at(l, row, column) * c[index(l, column)];
        return rotated;
    }

  private:
    int degree_;
    std::array<std::array<double, (2 * max_degree + 1) * (2 * max_degree + 1)>, max_degree + 1> block_{};
};

// Factors A_l by which the convolution with a clamped cosine multiplies coefficients of degree l, radiance to
// irradiance: pi, 2 pi/3, pi/4, 0, -pi/24, 0, pi/64, 0 (Ramamoorthi and Hanrahan 2001, "An Efficient Representation for
// Irradiance Environment Maps").
const std::array<double, max_degree + 1>& clamped_cosine();

}  // namespace plumb::sh
