// Microfacets: albedos against independent quadrature, the white furnace, reciprocity, colours, extreme numbers.
#include <catch2/catch.hpp>
#include <limits>

#include "microfacets.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

const double roughnesses[] = {0, 0.03, 0.1, 0.2, 0.33, 0.47, 0.6, 0.8, 0.9, 1};
const double cosines[] = {1, 0.93, 0.7, 0.45, 0.2, 0.05, 0.01};
// What the tables err by between their nodes, README.md, "Microfacets": of cosines below 0.05 more, where roughness is small.
double table_error(double cosine) { return cosine >= 0.05 ? 1e-3 : 5e-3; }

double alpha_of(double roughness) { return std::max(roughness * roughness, double(least_alpha)); }

}  // namespace

TEST_CASE("microfacets: E is that of the literature's formulas, by another quadrature", "[reference][microfacet][analytic]") {
    // alpha = 1, o = N: D = 1/pi, V = 1/(2 (1 + cos)), E = integral of x/(1 + x) over 0..1.
    CHECK(albedos(1, 1).single == Approx(1 - host::log(2)).epsilon(1e-12));
    for (const double alpha : {0.01, 0.1, 0.3, 0.6, 1.0})
        for (const double cosine : {1.0, 0.7, 0.3, 0.1}) {
            CAPTURE(alpha, cosine);
            const double expected = literature_albedo(cosine, alpha, true);
            CHECK(albedos(cosine, alpha).single == Approx(expected).margin(1e-4));
            CHECK(albedos(cosine, alpha, 96, 200).single == Approx(albedos(cosine, alpha).single).margin(1e-8));
            CHECK(albedos(cosine, alpha, 96, 200).schlick == Approx(albedos(cosine, alpha).schlick).margin(1e-4));
        }
    // Towards the horizon nothing is lost: 1/(1 + Lambda(o)) falls with the cosine, and G does no faster.
    for (const double alpha : {0.01, 0.3, 1.0}) CHECK(albedos(0, alpha).single == Approx(1).margin(1e-6));
}

TEST_CASE("microfacets: what single reflection loses in a white furnace", "[reference][microfacet][analytic]") {
    double least = 1;
    for (const double roughness : {0.2, 0.5, 0.8, 1.0})
        for (const double cosine : {1.0, 0.7, 0.3, 0.1}) {
            CAPTURE(roughness, cosine);
            const double a = albedo({Vector(1), 1, roughness, false}, cosine, 160).x;
            CHECK(a == Approx(literature_albedo(cosine, alpha_of(roughness), false)).margin(2e-4));
            CHECK(a < 1);
            least = std::min(least, a);
        }
    // For N.o = 1 there is nothing to correlate: V is the same.
    CHECK(albedo({Vector(1), 1, 1, false}, 1).x == Approx(1 - host::log(2)).margin(1e-4));
    CHECK(least < 0.4);
}

TEST_CASE("microfacets: glTF's dielectric sends out more than it gets", "[reference][microfacet][analytic]") {
    // Smooth: F of what is mirrored, and of diffuse light 1 - F of the half vector, of which there is more.
    for (const double cosine : {1.0, 0.5, 0.1}) {
        CAPTURE(cosine);
        auto fresnel = [](double c) { return 0.04 + 0.96 * host::pow(1 - c, 5); };
        const Vector o = at_cosine(cosine, 0);
        double below = 0;
        const int side = 200;
        for (int i = 0; i < side * side; ++i) {
            const Vector w = at_cosine(std::sqrt((i % side + 0.5) / side), 2 * host::pi * (i / side + 0.5) / side);
            below += (1 - fresnel(glm::length(o + w) / 2)) / (side * side);
        }
        CHECK(albedo({Vector(1), 0, 0.02, false}, cosine).x == Approx(fresnel(cosine) + below).margin(2e-3));
    }
    CHECK(albedo({Vector(1), 0, 0.02, false}, 0.1).x > 1.5);
}

TEST_CASE("microfacets: a white metal neither loses nor gains in a white furnace", "[reference][microfacet][furnace]") {
    double worst = 0;
    for (const double roughness : roughnesses)
        for (const double cosine : cosines) {
            CAPTURE(roughness, cosine);
            const double a = albedo({Vector(1), 1, roughness}, cosine).x;
            CHECK(a == Approx(1).margin(table_error(cosine)));
            worst = std::max(worst, std::abs(a - 1));
        }
    CAPTURE(worst);
    CHECK(worst > 0);
}

TEST_CASE("microfacets: nor does a white dielectric", "[reference][microfacet][furnace]") {
    double worst = 0;
    for (const double roughness : roughnesses)
        for (const double cosine : cosines) {
            CAPTURE(roughness, cosine);
            const double a = albedo({Vector(1), 0, roughness}, cosine).x;
            CHECK(a == Approx(1).margin(table_error(cosine)));
            worst = std::max(worst, std::abs(a - 1));
        }
    CAPTURE(worst);
    CHECK(worst > 0);
}

TEST_CASE("microfacets: colours are what Schlick's function and its mean make of them", "[reference][microfacet][analytic]") {
    const Vector gold(1, 0.766, 0.336);
    for (const double roughness : {0.1, 0.5, 1.0})
        for (const double cosine : {1.0, 0.6, 0.2}) {
            CAPTURE(roughness, cosine);
            const double alpha = alpha_of(roughness);
            const Albedos e = albedos(cosine, alpha, 64, 128);
            double lost_mean = 0;  // 2 integral of (1 - E) x dx
            for (int i = 0; i < 400; ++i) {
                const double x = (i + 0.5) / 400;
                lost_mean += 2 * x * (1 - albedos(x, alpha).single) / 400;
            }
            auto surface = [&](double f0) {
                const double mean = f0 + (1 - f0) / 21, again = mean * mean * (1 - lost_mean) / (1 - mean * lost_mean);
                return f0 * e.single + (1 - f0) * e.schlick + (1 - e.single) * again;
            };
            const Vector metal = albedo({gold, 1, roughness}, cosine), plastic = albedo({gold, 0, roughness}, cosine);
            for (int c = 0; c < 3; ++c) {
                const double coat = surface(0.04);
                CHECK(metal[c] == Approx(surface(gold[c])).margin(table_error(cosine)));
                CHECK(plastic[c] == Approx(coat + gold[c] * (1 - coat)).margin(table_error(cosine)));
            }
        }
    // Smooth, from above: F0.
    const Vector smooth = albedo({gold, 1, 0}, 1);
    for (int c = 0; c < 3; ++c) CHECK(smooth[c] == Approx(gold[c]).margin(2e-4));
    CHECK(albedo({Vector(0), 0, 0}, 1).x == Approx(0.04).margin(1e-5));
}

TEST_CASE("microfacets: metalness mixes a dielectric and a metal", "[reference][microfacet]") {
    for (int i = 0; i < 300; ++i)
        for (const bool multiple : {true, false}) {
            const Vector n(0, 0, 1), o = at_cosine(hashed(i, 0)), w = at_cosine(hashed(i, 1), 6 * hashed(i, 2));
            auto value = [&](double metalness) {
                const Rough m{{hashed(i, 6), hashed(i, 7), hashed(i, 8)}, metalness, hashed(i, 10), multiple};
                return scatter_facets<double>(args_of(multiple), seen<double>(m, n, o), w).value;
            };
            const Vector plastic = value(0), metal = value(1), mixed = value(0.25);
            for (int c = 0; c < 3; ++c) CHECK(mixed[c] == Approx(0.75 * plastic[c] + 0.25 * metal[c]).epsilon(1e-6));
        }
}

TEST_CASE("microfacets: f is reciprocal", "[reference][microfacet]") {
    int compared = 0;
    for (const bool multiple : {true, false})
        for (int i = 0; i < 4000; ++i) {
            const Rough m{{hashed(i, 6), hashed(i, 7), hashed(i, 8)}, hashed(i, 9), hashed(i, 10), multiple};
            const Vector n = hashed_direction(i, 0), o = hashed_direction(i, 2), w = hashed_direction(i, 4);
            if (glm::dot(n, o) <= 1e-3 || glm::dot(n, w) <= 1e-3) continue;
            ++compared;
            const MicrofacetArgs args = args_of(multiple);
            const Vector forth = scatter_facets<double>(args, seen<double>(m, n, o), w).value / glm::dot(n, w);
            const Vector back = scatter_facets<double>(args, seen<double>(m, n, w), o).value / glm::dot(n, o);
            for (int c = 0; c < 3; ++c) CHECK(forth[c] == Approx(back[c]).epsilon(1e-9));
        }
    CHECK(compared > 1500);
}

TEST_CASE("microfacets: of single reflection f is glTF's appendix B, term by term", "[reference][microfacet][analytic]") {
    for (int i = 0; i < 500; ++i) {
        const Rough m{{hashed(i, 6), hashed(i, 7), hashed(i, 8)}, hashed(i, 9), 0.1 + 0.9 * hashed(i, 10), false};
        const Vector n(0, 0, 1), v = at_cosine(0.02 + 0.98 * hashed(i, 0), 6 * hashed(i, 1)), l = at_cosine(0.02 + 0.98 * hashed(i, 2), 6 * hashed(i, 3));
        const Vector h = glm::normalize(v + l);
        const double a2 = host::pow(m.roughness, 4), nh = glm::dot(n, h), nl = l.z, nv = v.z;
        const double d = a2 / (host::pi * host::pow(nh * nh * (a2 - 1) + 1, 2));
        auto g1 = [&](double x) { return 2 * x / (x + std::sqrt(a2 + (1 - a2) * x * x)); };
        const double brdf = d * g1(nl) * g1(nv) / (4 * nl * nv), w = host::pow(1 - glm::dot(v, h), 5);
        const Vector found = scatter_facets<double>(args_of(false), seen<double>(m, n, v), l).value / nl;
        for (int c = 0; c < 3; ++c) {
            const double metal = brdf * (m.base[c] + (1 - m.base[c]) * w), fresnel = 0.04 + 0.96 * w;
            const double dielectric = (1 - fresnel) * m.base[c] / host::pi + fresnel * brdf;
            CHECK(found[c] == Approx((1 - m.metalness) * dielectric + m.metalness * metal).epsilon(1e-5));
        }
    }
}

TEST_CASE("microfacets: nothing comes from below, and what is seen from below is seen from its mirror image", "[reference][microfacet]") {
    const Vector z(0, 0, 1), up(0.6, 0, 0.8), down(0.6, 0, -0.8), side = at_cosine(0.3);
    for (const bool multiple : {true, false}) {
        const Rough m{Vector(0.8), 0.5, 0.5, multiple};
        const MicrofacetArgs args = args_of(multiple);
        CHECK(scatter_facets<double>(args, seen<double>(m, z, up), down).value == Vector(0));
        CHECK(scatter_facets<double>(args, seen<double>(m, z, down), side).value == scatter_facets<double>(args, seen<double>(m, z, up), side).value);
        CHECK(scatter_facets<double>(args, seen<double>(m, z, up), side).value.x > 0);
        for (const double u : {0.0, 0.3, 0.7, 0.99}) CHECK(glm::dot(z, sample_facets<double>(args, seen<double>(m, z, down), u, 0.3, 0.2).direction) > 0);
    }
}

TEST_CASE("microfacets: extreme numbers give finite weights of unit directions", "[reference][microfacet][extremes]") {
    const float corners[] = {0, 0x1p-24f, 0.5f, nearly_one};
    int samples = 0;
    for (int k = 0; k < 8; ++k) {
        const vec3<float> n = k < 6 ? vec3<float>(k == 0, k == 1, (k == 2) - (k == 3)) + vec3<float>(-(k == 4), -(k == 5), 0) : vec3<float>(hashed_direction(k, 7));
        const Basis<float> basis = basis_of(n);
        for (const double height : {1.0, 0.5, 1e-3, 1e-7, 0.0, -1e-3, -1.0})
            for (const double roughness : {0.0, 1e-3, 0.05, 0.5, 1.0})
                for (const double metalness : {0.0, 0.5, 1.0})
                    for (const double base : {0.0, 1.0})
                        for (const bool multiple : {true, false})
                            for (int u = 0; u < 64; ++u) {
                                const vec3<float> w_o = to_world(basis, vec3<float>(float(std::sqrt(1 - height * height)), 0, float(height)));
                                const Rough m{Vector(base), metalness, roughness, multiple};
                                const Facets<float> s = seen<float>(m, n, w_o);
                                const BsdfSample<float> b = sample_facets<float>(args_of(multiple), s, corners[u % 4], corners[u / 4 % 4], corners[u / 16]);
                                const bool unit = std::abs(glm::length(Vector(b.direction)) - 1) <= 1e-6;
                                const bool weighs = b.weight.x >= 0 && b.weight.x <= 0.1 / (double(s.alpha) * s.alpha) + 60;
                                const bool dense = b.pdf >= 0 && b.pdf <= 0.17 / (double(s.alpha) * s.alpha * s.alpha) + 1;
                                const bool lost = glm::dot(n, b.direction) > 0 || b.weight.x == 0;
                                ++samples;
                                if (unit && weighs && dense && lost) continue;
                                CAPTURE(n.x, n.y, n.z, height, roughness, metalness, base, multiple, u, b.weight.x, b.pdf);
                                REQUIRE((unit && weighs));
                                REQUIRE((dense && lost));
                            }
    }
    CHECK(samples == 8 * 7 * 5 * 3 * 2 * 2 * 64);
}

TEST_CASE("microfacets: floats keep the lobe of the smoothest surface", "[reference][microfacet][extremes]") {
    for (const double roughness : {0.0, 0.03, 0.2}) {
        double worst = 0;
        for (int i = 0; i < 4000; ++i) {
            const vec3<float> n = hashed_direction(i, 0), o = hashed_direction(i, 2);
            if (std::abs(glm::dot(n, o)) < 0.05) continue;
            const Rough m{Vector(1), 1, roughness};
            const BsdfSample<float> b = sample_facets<float>(args_of(true), seen<float>(m, n, o), 0, hashed(i, 4) * 0.99f, hashed(i, 5));
            if (b.weight.x == 0) continue;
            const Vector exact = glm::normalize(Vector(n));
            const double expected = scatter_facets<double>(args_of(true), seen<double>(m, exact, glm::normalize(Vector(o))), glm::normalize(Vector(b.direction))).value.x;
            const double found = scatter_facets<float>(args_of(true), seen<float>(m, n, o), b.direction).value.x;
            worst = std::max(worst, std::abs(found / expected - 1));
        }
        // Coordinates in the frame are known to 2e-7, H to that over |o + i|, which is 0.1 or more, and D to 2/alpha times that.
        CAPTURE(roughness, worst);
        CHECK(worst <= 1e-5 + 4e-6 / alpha_of(roughness));
        CHECK(worst > 0);
    }
}

TEST_CASE("microfacets: what is not a number stays visible", "[reference][microfacet][extremes]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Vector z(0, 0, 1), up(0.6, 0, 0.8), broken(nan, 0, 0.8);
    for (const bool multiple : {true, false})
        for (const double metalness : {0.0, 1.0}) {
            const Rough m{Vector(0.5), metalness, 0.4, multiple};
            const MicrofacetArgs args = args_of(multiple);
            CAPTURE(multiple, metalness);
            auto value = [&](const Rough& of, const Vector& n, const Vector& o, const Vector& i) {
                return scatter_facets<float>(args, seen<float>(of, n, o), vec3<float>(i)).value.x;
            };
            CHECK(std::isnan(value(m, z, up, broken)));
            CHECK(std::isnan(value(m, z, broken, up)));
            CHECK(std::isnan(value(m, broken, up, up)));
            for (int k = 0; k < 3; ++k) {
                Rough n = m;
                (k == 0 ? n.base.x : k == 1 ? n.metalness : n.roughness) = nan;
                CAPTURE(k);
                CHECK(std::isnan(value(n, z, up, up)));
                CHECK(std::isnan(sample_facets<float>(args, seen<float>(n, z, up), 0.3f, 0.3f, 0.3f).weight.x));
            }
            CHECK(std::isnan(sample_facets<float>(args, seen<float>(m, broken, up), 0.3f, 0.3f, 0.3f).weight.x));
        }
}
