// Directions that microfacets are sampled with fall as densely as their density says: Pearson's chi-square test.
#include <catch2/catch.hpp>

#include "microfacets.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

// About the mirrored direction, where the lobe is: rings whose angles grow as a power, so that the first are as narrow as
// the lobe, cut into sectors.
struct Bins {
    static constexpr int rings = 20, sectors = 12;
    Basis<double> basis;
    double power;

    double angle(double ring) const { return host::pi * host::exp(power * host::log(ring / rings)); }
    int of(const Vector& w) const {
        const double x = glm::dot(basis.tangent, w), y = glm::dot(basis.bitangent, w), z = glm::dot(basis.normal, w);
        const double theta = host::atan2(std::sqrt(x * x + y * y), z), turn = host::atan2(y, x) / (2 * host::pi) + 0.5;
        const int ring = std::min(int(rings * host::exp(host::log(std::max(theta, 1e-30) / host::pi) / power)), rings - 1);
        return ring * sectors + std::min(int(turn * sectors), sectors - 1);
    }
    // The integral of f over a bin by midpoints.
    template <class Density>
    double integral(int bin, int side, Density f) const {
        const double t0 = bin / sectors == 0 ? 0 : angle(bin / sectors), t1 = angle(bin / sectors + 1);
        std::vector<glm::dvec2> circle;
        for (int k = 0; k < side; ++k) {
            const double phi = ((bin % sectors + (k + 0.5) / side) / sectors - 0.5) * 2 * host::pi;
            circle.emplace_back(host::cos(phi), host::sin(phi));
        }
        double sum = 0;
        for (int i = 0; i < side; ++i) {
            const double theta = t0 + (t1 - t0) * (i + 0.5) / side, sine = host::sin(theta), cosine = host::cos(theta);
            for (const glm::dvec2& p : circle) sum += sine * f(to_world(basis, Vector(sine * p.x, sine * p.y, cosine)));
        }
        return sum * (t1 - t0) / side * 2 * host::pi / (sectors * double(side));
    }
};

// The share of a chi-square distribution beyond x: Wilson and Hilferty 1931, to 1e-3 of what matters here.
double chi_square_tail(double x, double freedom) {
    const double z = (std::cbrt(x / freedom) - (1 - 2 / (9 * freedom))) / std::sqrt(2 / (9 * freedom));
    return 0.5 * std::erfc(z / std::sqrt(2.0));
}

struct Fit {
    double chi_square = 0, whole = 0;  // whole: the density's integral over the sphere
    int freedom = -1;
};

// Samples of the one against the density of the other.
Fit fit(const Rough& sampled, const Rough& m, double cosine, int count, int side) {
    const Vector n(0, 0, 1), w_o = at_cosine(cosine);
    const MicrofacetArgs args = args_of(m.multiple);
    const Facets<float> s = seen<float>(sampled, n, w_o);
    const Facets<double> exact = seen<double>(m, n, w_o);
    const Vector r(-w_o.x, -w_o.y, w_o.z);
    const double width = std::max(m.roughness * m.roughness, double(least_alpha));
    const Bins bins{basis_of(r), std::max(1.0, host::log(host::pi / (0.5 * width)) / host::log(double(Bins::rings)))};
    std::vector<double> hits(Bins::rings * Bins::sectors), expected(hits.size());
    for (int i = 0; i < count; ++i)
        hits[std::size_t(bins.of(Vector(sample_facets<float>(args, s, hashed(i, 0), hashed(i, 1), hashed(i, 2)).direction)))] += 1;
    Fit f;
    double few_hits = 0, few = 0;
    auto add = [&](double hit, double awaited) { f.chi_square += (hit - awaited) * (hit - awaited) / awaited, ++f.freedom; };
    for (std::size_t b = 0; b < hits.size(); ++b) {
        const double share = bins.integral(int(b), side, [&](const Vector& w) { return scatter_facets<double>(args, exact, w).pdf; });
        f.whole += share;
        if (count * share < 10)
            few_hits += hits[b], few += count * share;
        else
            add(hits[b], count * share);
    }
    if (few >= 10) add(few_hits, few);
    return f;
}

}  // namespace

TEST_CASE("microfacets: samples fall as their density says, by chi-square", "[reference][microfacet][chi-square]") {
    struct Case {
        Rough m;
        double cosine;
    };
    std::vector<Case> cases;
    for (const double roughness : {0.02, 0.1, 0.3, 0.6, 1.0})
        for (const double cosine : {1.0, 0.7, 0.3, 0.05}) cases.push_back({{Vector(1), 1, roughness}, cosine});
    for (const double cosine : {1.0, 0.5, 0.1}) cases.push_back({{Vector(0.7, 0.5, 0.2), 0, 0.4}, cosine});
    cases.push_back({{Vector(0.5), 0.3, 0.7, false}, 0.6});
    // All at once err by chance once in a thousand: Sidak 1967.
    const double least = 1 - std::pow(1 - 1e-3, 1.0 / double(cases.size()));
    for (const Case& c : cases) {
        const Fit f = fit(c.m, c.m, c.cosine, 40000, 24);
        CAPTURE(c.m.roughness, c.m.metalness, c.cosine, f.chi_square, f.freedom, f.whole);
        CHECK(f.whole == Approx(1).margin(2e-3));
        CHECK(f.freedom >= 15);
        CHECK(chi_square_tail(f.chi_square, f.freedom) >= least);
    }
    // The test sees an error: a roughness that is off by one in twenty.
    const Fit wrong = fit({Vector(1), 1, 0.315}, {Vector(1), 1, 0.3}, 0.7, 40000, 24);
    CHECK(chi_square_tail(wrong.chi_square, wrong.freedom) < 1e-6);
}

TEST_CASE("microfacets: over directions above the surface the density integrates to 1 at most", "[reference][microfacet]") {
    for (const double roughness : {0.5, 0.7, 1.0})
        for (const double cosine : {1.0, 0.5, 0.1}) {
            const Rough m{Vector(1), 1, roughness};
            const Facets<double> s = seen<double>(m, Vector(0, 0, 1), at_cosine(cosine));
            const MicrofacetArgs args = args_of(true);
            const Bins about{basis_of(Vector(0, 0, 1)), 1};
            double above = 0;
            for (int b = 0; b < Bins::rings / 2 * Bins::sectors; ++b)
                above += about.integral(b, 40, [&](const Vector& w) { return scatter_facets<double>(args, s, w).pdf; });
            CAPTURE(roughness, cosine, above);
            CHECK(above <= 1 + 1e-3);
            // What is missing are samples that meet a second facet from above: at most what the surface loses.
            CHECK(1 - above <= s.share * (1 - albedos(cosine, roughness * roughness).single) + 1e-3);
        }
}
