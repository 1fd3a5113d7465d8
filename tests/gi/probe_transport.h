// A transport of receivers that has the shape of a baked one, from formulas: for tests of clusters.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/hash.h"
#include "core/sh.h"
#include "gi/probes/clusters.h"

namespace plumb {

inline double hashed(int i, int j, int k) {  // [0, 1)
    return double(unit_float<float>(pixel_hash<std::int32_t>(i, j, k, 17).x));
}

struct Transport {
    int receivers = 0, overlaps = 0, coefficients = 0;
    std::vector<glm::vec4> position;
    std::vector<std::int32_t> support;
    std::vector<float> alpha;

    probes::TransportRows rows() const {
        return {receivers, overlaps, coefficients, position.data(), support.data(), alpha.data()};
    }
    float* slot(int receiver, int s) { return &alpha[(std::size_t(receiver) * overlaps + s) * coefficients]; }
};

// Receivers of a floor (two thirds of them) and a wall, 6 m x 4 m and 4 m x 3 m, and probes in the air above. Each is
// supported by its nearest probes, weighted by 2 t^3 - 3 t^2 + 1 of the distance; alpha is the weight times the
// spherical harmonics in the direction of the receiver's mirror image, times a cosine: smooth. Noise is added to each
// coefficient.
inline Transport smooth_transport(int receivers, int probes, int coefficients, double noise = 0, int overlaps = 10) {
    const int degree = int(std::lround(std::sqrt(coefficients))) - 1;
    Transport t{receivers, overlaps, coefficients, {}, {}, {}};
    t.support.assign(std::size_t(receivers) * overlaps, -1);
    t.alpha.assign(std::size_t(receivers) * overlaps * coefficients, 0);
    std::vector<glm::dvec3> probe;
    for (int p = 0; p < probes; ++p)
        probe.emplace_back(6 * hashed(p, 0, 1), 4 * hashed(p, 1, 1), 0.3 + 2.5 * hashed(p, 2, 1));
    for (int i = 0; i < receivers; ++i) {
        const bool wall = i % 3 == 2;
        const double a = hashed(i, 0, 2), b = hashed(i, 1, 2);
        const glm::dvec3 x = wall ? glm::dvec3(0, 4 * a, 3 * b) : glm::dvec3(6 * a, 4 * b, 0);
        const glm::dvec3 normal = wall ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
        t.position.emplace_back(glm::vec3(x), 0);

        std::vector<std::pair<double, int>> nearest;
        for (int p = 0; p < probes; ++p) nearest.emplace_back(glm::dot(probe[p] - x, probe[p] - x), p);
        std::sort(nearest.begin(), nearest.end());
        const int count = std::min(overlaps, probes);
        const double radius = 1.05 * std::sqrt(nearest[count - 1].first);
        for (int s = 0; s < count; ++s) {
            const double d = std::sqrt(nearest[s].first) / radius;
            const double weight = (2 * d - 3) * d * d + 1;
            const glm::dvec3 away = x + 2.0 * normal - probe[nearest[s].second];
            const glm::dvec3 direction = away / std::sqrt(glm::dot(away, away));
            const sh::Values y = sh::basis(direction, degree);
            t.support[std::size_t(i) * overlaps + s] = nearest[s].second;
            for (int c = 0; c < coefficients; ++c)
                t.slot(i, s)[c] = float(weight * (1.5 + direction.z) * y[c] + noise * (hashed(i, s, 100 + c) - 0.5));
        }
    }
    return t;
}

}  // namespace plumb
