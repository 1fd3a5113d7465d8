// Systems of radiosity whose solutions are known.
#pragma once

#include <array>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/radiosity/solve.h"

namespace plumb::radiosity {

inline double hashed_share(int i, int j, int seed) {  // [0, 1)
    return double(unit_float<float>(pixel_hash<std::int32_t>(i, j, seed, 19).x));
}

// Dense rows in double. What it lends must not outlive it.
struct DenseSystem {
    int n;
    std::vector<double> f, area, sums;
    Buffer<glm::vec4> reflectance, exitance, incident;

    explicit DenseSystem(int count)
        : n(count), f(std::size_t(n) * n), area(std::size_t(n), 1.0), reflectance(n, glm::vec4(0)),
          exitance(n, glm::vec4(0)), incident(n, glm::vec4(0)) {}

    double& at(int i, int j) { return f[std::size_t(i) * n + j]; }
    double at(int i, int j) const { return f[std::size_t(i) * n + j]; }
    void reflect(float rho) { reflectance.assign(n, glm::vec4(rho, rho, rho, 0)); }

    enum class Rounding { none, floats, floats_about_mean };
    Transport transport(Rounding rounding = Rounding::none) {
        Transport t;
        t.count = n, t.area = &area;
        t.row = [this](int i, std::vector<float>& row) {
            row.assign(f.begin() + std::size_t(i) * n, f.begin() + std::size_t(i + 1) * n);
        };
        t.gather = [this](const Buffer<glm::vec4>& b, Buffer<glm::vec4>& h, const RunOptions&) {
            each_row(b, [&](int i, const glm::dvec3& sum) { h[i] = glm::vec4(glm::vec3(sum), 0); });
        };
        if (rounding == Rounding::none)
            t.gather_double = [this](const Buffer<glm::dvec4>& b, Buffer<glm::dvec4>& h, const RunOptions&) {
                each_row(b, [&](int i, const glm::dvec3& sum) { h[i] = glm::dvec4(sum, 0); });
            };
        sums.assign(std::size_t(n), 0.0);
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) sums[i] += at(i, j);
        if (rounding == Rounding::floats_about_mean) t.row_sums = &sums;
        return t;
    }
    template <class Radiosities, class F>
    void each_row(const Radiosities& b, const F& take) const {
        parallel_bands(n, 64, 0, [&](int first, int last) {
            for (int i = first; i < last; ++i) {
                glm::dvec3 sum(0);
                for (int j = 0; j < n; ++j) sum += at(i, j) * glm::dvec3(b[j]);
                take(i, sum);
            }
        });
    }
    System system() const { return {&reflectance, &exitance, &incident}; }
};

// Unit squares of a unit cube: opposed at distance 1, with a shared edge (verification.md 3). Faces 2k and 2k + 1 are
// opposite.
inline constexpr double opposite_square = 0.199824895698387, adjacent_square = 0.200043776075403;

inline DenseSystem cube_of_six(float rho) {
    DenseSystem s(6);
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
            if (i != j) s.at(i, j) = i / 2 == j / 2 ? opposite_square : adjacent_square;
    s.reflect(rho);
    s.exitance[0] = glm::vec4(1, 1, 1, 0);
    return s;
}

// The same with one reflectance, from its three kinds of eigenvectors: all alike, 1; emitter against opposite, -F_opp;
// both against the sides, F_opp - 2 F_adj. {emitter, opposite, side}.
inline std::array<double, 3> cube_radiosity(double rho) {
    const double all = 1 / (6 * (1 - rho)), odd = 0.5 / (1 + rho * opposite_square);
    const double even = 1 / (3 * (1 - rho * (opposite_square - 2 * adjacent_square)));
    return {all + odd + even, all - odd + even, all - 0.5 * even};
}

// The share of the hemisphere, weighted by cosine, that a polygon above the horizon covers (Lambert 1760).
inline double polygon_form_factor(glm::dvec3 eye, glm::dvec3 normal, const std::array<glm::dvec3, 4>& corner) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec3 a = corner[k] - eye, b = corner[(k + 1) % 4] - eye, c = glm::cross(a, b);
        const double length = std::sqrt(glm::dot(c, c));
        if (length > 0) sum += host::atan2(length, glm::dot(a, b)) * glm::dot(normal, c) / length;
    }
    return std::fabs(sum) / (2 * host::pi);
}

// A unit cube in m x m patches a face: rows as a hemicube in each patch's middle without texels would have them. They sum
// to one, and they are not reciprocal. Element (face m + v) m + u; face 0 emits 1.
inline DenseSystem cube_of_patches(int m, float rho) {
    DenseSystem s(6 * m * m);
    const auto point = [](int face, double u, double v) {
        glm::dvec3 p(0);
        const int axis = face / 2;
        p[axis] = face % 2, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
        return p;
    };
    const double step = 1.0 / m;
    for (int i = 0; i < s.n; ++i) {
        const int face = i / (m * m);
        glm::dvec3 normal(0);
        normal[face / 2] = face % 2 ? -1 : 1;
        const glm::dvec3 eye = point(face, (i % m + 0.5) * step, (i / m % m + 0.5) * step);
        for (int j = 0; j < s.n; ++j) {
            const int other = j / (m * m);
            if (other == face) continue;
            const double u = j % m * step, v = j / m % m * step;
            s.at(i, j) = polygon_form_factor(eye, normal, {point(other, u, v), point(other, u + step, v),
                                                           point(other, u + step, v + step), point(other, u, v + step)});
        }
        s.area[i] = step * step;
        if (face == 0) s.exitance[i] = glm::vec4(1, 1, 1, 0);
    }
    s.reflect(rho);
    return s;
}

// The inside of a sphere: F_ij = A_j / sum of A, exact in floats: areas are powers of two that sum to one.
inline DenseSystem sphere(int n, float rho) {
    DenseSystem s(n);
    double a = 0.5;
    for (int i = 0; i < n; ++i, a *= 0.5) s.area[i] = i == n - 1 ? 2 * a : a;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) s.at(i, j) = s.area[j];
    s.reflect(rho);
    return s;
}

using Rounding = DenseSystem::Rounding;

inline constexpr Solver all_solvers[] = {Solver::passes,   Solver::shooting,            Solver::gauss_seidel,
                                         Solver::bicgstab, Solver::conjugate_gradients, Solver::direct};

inline Solution solved(DenseSystem& s, Solver solver, double tolerance = 1e-6, int most = 100000,
                       Rounding rounding = Rounding::none, const RunOptions& options = {}) {
    SolveParams params;
    params.solver = solver, params.tolerance = tolerance, params.most_products = most;
    const Transport t = s.transport(rounding);
    return solve(s.system(), t, params, options);
}

}  // namespace plumb::radiosity
