#include "gi/probes/directions.h"

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "core/sh.h"

namespace plumb::probes {

namespace {

void check_rays(int rays) {
    if (rays < 1 || rays > 32768) throw InputError("rays = " + std::to_string(rays) + ": expected 1 to 32768");
}

// Sobol's sequence begins at a corner: moved by half of a box of the first 2^16 points, so that none lies on an edge.
glm::dvec2 point(int k) { return sobol(std::uint32_t(k)) + glm::dvec2(0x1p-17); }

}  // namespace

Buffer<glm::vec4> relight_directions(int rays) {
    check_rays(rays);
    Buffer<glm::vec4> directions;
    for (int k = 0; k < rays; ++k) directions.emplace_back(glm::vec3(sample_sphere(point(k))), 0);
    return directions;
}

Buffer<glm::vec4> receiver_directions(int rays, Distribution distribution) {
    check_rays(rays);
    Buffer<glm::vec4> directions;
    for (int k = 0; k < rays; ++k) {
        const glm::dvec2 u = point(k);
        const glm::dvec3 d = distribution == Distribution::cosine ? sample_cosine_hemisphere(u) : sample_hemisphere(u);
        directions.emplace_back(glm::vec3(d), 0);
    }
    return directions;
}

Buffer<float> ray_factors(const Buffer<glm::vec4>& directions, Distribution distribution) {
    Buffer<float> factors;
    const double n = double(directions.size());
    for (const glm::vec4& d : directions)
        factors.push_back(float(distribution == Distribution::cosine ? host::pi / n : 2 * host::pi * double(d.z) / n));
    return factors;
}

int exact_degree(int n) {
    int degree = 0;
    while (degree < sh::highest_degree && 2 * (degree + 2) * (degree + 2) <= n) ++degree;
    return degree;
}

namespace {

// Solves G x = b for a positive definite G [n][n], by Cholesky's decomposition; G and b are used up.
void solve(std::vector<double>& g, std::vector<double>& b) {
    const std::size_t n = b.size();
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = g[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= g[i * n + k] * g[j * n + k];
            g[i * n + j] = i == j ? std::sqrt(sum) : sum / g[j * n + j];
        }
        for (std::size_t k = 0; k < i; ++k) b[i] -= g[i * n + k] * b[k];
        b[i] /= g[i * n + i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) b[i] -= g[k * n + i] * b[k];
        b[i] /= g[i * n + i];
    }
}

}  // namespace

// w = w0 + A^T (A A^T)^-1 (e - A w0): the nearest weights to w0 = 4 pi / n with A w = e, a row of A a harmonic, e their
// integrals: sqrt(4 pi) for the first, 0 for the others.
Buffer<float> relight_weights(const Buffer<glm::vec4>& directions, int n) {
    if (n < 1 || std::size_t(n) > directions.size()) throw InputError("relight_weights: more rays than directions");
    std::vector<std::vector<double>> columns;
    for (int r = 0; r < n; ++r) {
        const glm::dvec3 d(directions[std::size_t(r)]);
        columns.push_back(sh::long_basis(d / std::sqrt(glm::dot(d, d)), exact_degree(n)));
    }
    const std::size_t rows = columns[0].size();
    const double equal = 4 * host::pi / n;
    std::vector<double> gram(rows * rows, 0.0), rest(rows, 0.0);
    rest[0] = std::sqrt(4 * host::pi);
    for (const std::vector<double>& c : columns)
        for (std::size_t i = 0; i < rows; ++i) {
            rest[i] -= equal * c[i];
            for (std::size_t j = 0; j <= i; ++j) gram[i * rows + j] += c[i] * c[j];
        }
    solve(gram, rest);
    Buffer<float> weights;
    for (const std::vector<double>& c : columns) {
        double w = equal;
        for (std::size_t i = 0; i < rows; ++i) w += c[i] * rest[i];
        weights.push_back(float(w));
    }
    return weights;
}

Buffer<float> harmonics_of(const Buffer<glm::vec4>& directions, int degree) {
    Buffer<float> values;
    for (const glm::vec4& d : directions) {
        // Of the direction as it is stored, made unit again: rounding moved it.
        const glm::dvec3 exact(d);
        const sh::Values y = sh::basis(exact / std::sqrt(glm::dot(exact, exact)), degree);
        for (int j = 0; j < sh::count(degree); ++j) values.push_back(float(y[std::size_t(j)]));
    }
    return values;
}

}  // namespace plumb::probes
