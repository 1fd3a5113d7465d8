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

// Directional albedo, by two quadratures that share the integrand by their densities: midpoints of the square of visible
// normals, denser towards its rim, and cosines t^4, for what microfacets lose lies about the horizon. What lies below a dielectric's
// surface is spread evenly: the second alone has it.
inline Vector albedo(const Rough& m, double cosine, int side = 80) {
    const Vector z(0, 0, 1), w_o = at_cosine(cosine);
    const MicrofacetArgs args = args_of(m.multiple);
    const Facets<double> s = seen<double>(m, z, w_o);
    Facets<double> coat = s;
    if (m.metalness == 0) coat.base = Vector(0);
    const double a2 = s.alpha * s.alpha;
    Vector sum(0);
    auto add = [&](const Vector& w_i, double weight, bool below) {
        if (w_i.z <= 0) return;
        const Vector h = glm::normalize(w_o + w_i);
        const double bulge = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
        const double of_normals = a2 / (host::pi * bulge * bulge) / (2 * (cosine + std::sqrt(a2 + (1 - a2) * cosine * cosine)));
        const double of_cosines = 1 / (8 * host::pi * w_i.z / std::sqrt(std::sqrt(w_i.z)));
        const Vector of_coat = scatter_facets<double>(args, coat, w_i).value;
        sum += of_coat * (weight / (of_normals + of_cosines));
        if (below) sum += (scatter_facets<double>(args, s, w_i).value - of_coat) * (weight / of_cosines);
    };
    for (int i = 0; i < side * side; ++i) {
        const double t = (i % side + 0.5) / side, u2 = (i / side + 0.5) / side, turn = 2 * host::pi * u2;
        const Vector h = to_world(s.basis, visible_normal<double>(s.w_o, s.alpha, 1 - (1 - t) * (1 - t), u2));
        add(h * (2 * glm::dot(h, w_o)) - w_o, 2 * (1 - t), false);
        const double up = t * t * t * t, sine = std::sqrt(1 - up * up);
        add({sine * host::cos(turn), sine * host::sin(turn), up}, 1, true);
    }
    return sum / double(side * side);
}

// E by the distribution of all normals: with dv = 2 pi D cos dcos, tan^2 = alpha^2 v/(1 - v), and Smith's Lambda as printed
// (Heitz 2014, (72), (86), (99)), E = mean of G (o.h)/((N.o)(N.h)).
inline double smith_lambda(double alpha, double cosine) {
    const double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
    return (std::sqrt(1 + alpha * alpha * tangent2) - 1) / 2;
}
inline double literature_albedo(double cosine, double alpha, bool correlated, int side = 400) {
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
