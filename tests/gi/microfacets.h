// Surfaces of microfacets for the tests: seen along w_o, their albedo, and what literature says of it.
#pragma once

#include <cmath>
#include <vector>

#include "core/host_math.h"
#include "gi/reference/microfacet_kernel.h"
#include "gi/reference/microfacet_tables.h"
#include "shade_probe.h"

namespace plumb::reference {

using Vector = vec3<double>;
inline constexpr float nearly_one = 1 - 0x1p-24f;

struct Rough {
    Vector base{1};
    double metalness = 1, roughness = 0.5;
    bool multiple = true;
};

inline MicrofacetArgs args_of(bool multiple) {
    const MicrofacetTables& t = microfacet_tables();
    return {nullptr, t.cells.data(), t.rows.data(), multiple};
}

template <class F>
Facets<F> seen(const Rough& m, const Vector& n, const Vector& w_o) {
    return facets_of<F>(args_of(m.multiple), true, vec3<F>(m.base), F(m.metalness), F(m.roughness), vec3<F>(n), vec3<F>(w_o));
}

// At an angle of that cosine from the pole z.
inline Vector at_cosine(double cosine, double azimuth = 0.4) {
    const double sine = std::sqrt((1 - cosine) * (1 + cosine));
    return {sine * host::cos(azimuth), sine * host::sin(azimuth), cosine};
}

// Directional albedo: the mean weight of both ways of sampling, each over the midpoints of a square.
inline Vector albedo(const Rough& m, double cosine, int side = 96) {
    const Vector z(0, 0, 1), w_o = at_cosine(cosine);
    const MicrofacetArgs args = args_of(m.multiple);
    const Facets<double> s = seen<double>(m, z, w_o);
    Vector sum(0);
    for (int i = 0; i < side * side; ++i) {
        const double u1 = (i % side + 0.5) / side, u2 = (i / side + 0.5) / side;
        sum += sample_facets<double>(args, s, 0, u1, u2).weight * s.share;
        if (s.share < 1) sum += sample_facets<double>(args, s, 1, u1, u2).weight * (1 - s.share);
    }
    return sum / double(side * side);
}

// E by the distribution of all normals: with dv = 2 pi D cos dcos, tan^2 = alpha^2 v/(1 - v), and Smith's Lambda as printed
// (Heitz 2014, (72), (86), (99)), E = mean of G (o.h)/((N.o)(N.h)).
inline double smith_lambda(double alpha, double cosine) {
    const double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
    return (std::sqrt(1 + alpha * alpha * tangent2) - 1) / 2;
}
inline double literature_albedo(double cosine, double alpha, bool correlated, int side = 800) {
    const Vector o = at_cosine(cosine, 0);
    double sum = 0;
    for (int k = 0; k < side; ++k) {
        const double turn = host::pi * (k + 0.5) / side, along = host::cos(turn), across = host::sin(turn);
        for (int j = 0; j < side; ++j) {
            // v = 1 - (1 - t)^3: the wide tail takes more of the points.
            const double t = (j + 0.5) / side, rest = (1 - t) * (1 - t) * (1 - t), v = 1 - rest;
            const double tangent = alpha * std::sqrt(v / rest), up = 1 / std::sqrt(1 + tangent * tangent), sine = tangent * up;
            const Vector h(sine * along, sine * across, up);
            const double oh = glm::dot(o, h);
            const double mu = 2 * oh * h.z - o.z;
            if (oh <= 0 || mu <= 0) continue;
            const double lambda_o = smith_lambda(alpha, o.z), lambda_i = smith_lambda(alpha, mu);
            const double g = correlated ? 1 / (1 + lambda_o + lambda_i) : 1 / ((1 + lambda_o) * (1 + lambda_i));
            sum += g * oh / (o.z * h.z) * 3 * (1 - t) * (1 - t);
        }
    }
    return sum / (double(side) * side);
}

}  // namespace plumb::reference
