// How surfaces scatter: closed forms, quadrature in double, and what sampling makes of it in float.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "shade_probe.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

using Vector = vec3<double>;
constexpr float below_one = 1 - 0x1p-24f;

template <class F>
Bsdf<F> bsdf_of(double diffuse, double specular, double exponent, double mirror = 0) {
    return {vec3<F>(F(diffuse)), vec3<F>(F(specular)), F(exponent), vec3<F>(F(mirror))};
}
Bsdf<double> widened(const Bsdf<float>& b) { return {b.diffuse, b.specular, b.exponent, b.mirror}; }

// w_o at an angle from the pole z, in the plane of x.
Vector tilted(double angle) { return {host::sin(angle), 0, host::cos(angle)}; }

// The integral of f(direction) over all directions: midpoints of the angle from `axis`, finer towards it, where a lobe
// may be narrow, and of the azimuth.
template <class Function>
double integral(const Vector& axis, Function f, int n = 128) {
    const Basis<double> basis = basis_of(axis);
    std::vector<glm::dvec2> circle;
    for (int k = 0; k < 2 * n; ++k) {
        const double phi = (k + 0.5) / n * host::pi;
        circle.emplace_back(host::cos(phi), host::sin(phi));
    }
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double t = (i + 0.5) / n, theta = host::pi * t * t, sine = host::sin(theta), cosine = host::cos(theta);
        double ring = 0;
        for (const glm::dvec2& p : circle) ring += f(to_world(basis, Vector(sine * p.x, sine * p.y, cosine)));
        sum += ring * sine * 2 * t * host::pi / n;
    }
    return sum * (host::pi / n);
}

// Directional albedo, first channel, normal z: about the mirrored direction, where the lobe is narrow.
double albedo(const Bsdf<double>& b, const Vector& w_o, int n = 96) {
    const Vector z(0, 0, 1);
    auto f = [&](const Vector& w_i) { return evaluate(b, z, w_o, w_i).x; };
    return integral(mirrored(z, w_o), f, n);
}

struct Case {
    const char* name;
    Bsdf<float> bsdf;
};
std::vector<Case> cases() {
    Bsdf<float> coloured{{0.1f, 0.5f, 0.2f}, {0.3f, 0.05f, 0.4f}, 20, {0.2f, 0.1f, 0}};
    return {{"diffuse", bsdf_of<float>(0.7, 0, 50)},
            {"wide lobe", bsdf_of<float>(0, 0.9, 1)},
            {"lobe", bsdf_of<float>(0, 0.8, 30)},
            {"both", bsdf_of<float>(0.4, 0.5, 5)},
            {"lobe and mirror", bsdf_of<float>(0, 0.5, 8, 0.3)},
            {"all, coloured", coloured}};
}

}  // namespace

TEST_CASE("bsdf: the albedo of each part is the closed form", "[reference]") {
    for (const double angle : {0.0, 0.3, 0.8, 1.2, 1.5}) {
        CAPTURE(angle);
        const Vector w_o = tilted(angle);
        // Lambert: the reflectance. n = 0: f = 1/pi on half the sphere, whose share of the cosine is (1 + cos a)/2.
        // n = 1: the integral of two clamped cosines over the sphere is 2/3 (sin a + (pi - a) cos a).
        REQUIRE(albedo(bsdf_of<double>(0.7, 0, 1), w_o) == Approx(0.7).epsilon(5e-4));
        REQUIRE(albedo(bsdf_of<double>(0, 0.5, 0), w_o, 400) == Approx(0.5 * (1 + host::cos(angle)) / 2).epsilon(5e-3));
        const double one = (host::sin(angle) + (host::pi - angle) * host::cos(angle)) / host::pi;
        REQUIRE(albedo(bsdf_of<double>(0, 0.5, 1), w_o) == Approx(0.5 * one).epsilon(5e-4));
    }
    // At normal incidence the integral of (n + 2) c^(n + 1) from 0 to 1 is 1, whatever the exponent.
    for (const double exponent : {0.0, 0.5, 1.0, 3.0, 50.0, 1000.0}) {
        CAPTURE(exponent);
        REQUIRE(albedo(bsdf_of<double>(0, 0.9, exponent), tilted(0)) == Approx(0.9).epsilon(2e-3));
    }
    // A narrow lobe lies above the surface whole, and N.w_i is N.w_o times the cosine from its axis, but for what is
    // odd about the axis: again the integral of (n + 2) c^(n + 1).
    REQUIRE(albedo(bsdf_of<double>(0, 1, 1000), tilted(1)) == Approx(host::cos(1)).epsilon(1e-3));
}

TEST_CASE("bsdf: no surface reflects more than its reflectances", "[reference]") {
    for (const double exponent : {0.0, 0.3, 1.0, 4.0, 40.0, 400.0})
        for (const double angle : {0.0, 0.2, 0.6, 1.0, 1.3, 1.5, host::pi / 2}) {
            CAPTURE(exponent, angle);
            const double a = albedo(bsdf_of<double>(0.3, 0.7, exponent), tilted(angle));
            REQUIRE(a <= 1.002);
            REQUIRE(a >= 0.299);
        }
}

TEST_CASE("bsdf: f is reciprocal", "[reference]") {
    const Bsdf<double> b = bsdf_of<double>(0.3, 0.6, 7);
    int compared = 0;
    for (int i = 0; i < 10000; ++i) {
        const Vector n = hashed_direction(i, 0), w_o = hashed_direction(i, 2), w_i = hashed_direction(i, 4);
        const double cos_o = glm::dot(n, w_o), cos_i = glm::dot(n, w_i);
        if (cos_o <= 0.01 || cos_i <= 0.01) continue;
        ++compared;
        const double forth = evaluate(b, n, w_o, w_i).x / cos_i, back = evaluate(b, n, w_i, w_o).x / cos_o;
        REQUIRE(forth == Approx(back).epsilon(1e-10));
        REQUIRE(forth >= 0.3 / host::pi * 0.999);
    }
    REQUIRE(compared > 1000);
}

TEST_CASE("bsdf: there is nothing below the surface", "[reference]") {
    const Bsdf<float> b{vec3<float>(0.3f), vec3<float>(0.3f), 1, vec3<float>(0.3f)};
    const vec3<float> z(0, 0, 1), up(0.6f, 0, 0.8f), down(0.6f, 0, -0.8f), zero(0);
    REQUIRE(evaluate(b, z, up, up).x > 0);
    REQUIRE(evaluate(b, z, up, down) == zero);
    REQUIRE(evaluate(b, z, down, up) == zero);
    REQUIRE(evaluate(b, z, down, down) == zero);
    for (const float u_lobe : {0.0f, 0.5f, 0.9f}) {
        REQUIRE(sample(b, z, up, u_lobe, 0.2f, 0.3f).weight.x > 0);
        REQUIRE(sample(b, z, down, u_lobe, 0.2f, 0.3f).weight == zero);
    }
    // Diffuse alone: as sample_diffuse() and evaluate_diffuse(), which do not ask where w_o is.
    const Bsdf<float> chalk{vec3<float>(0.3f), zero, 1, zero};
    REQUIRE(evaluate(chalk, z, down, up).x == Approx(evaluate_diffuse(chalk.diffuse, z, up).x));
    REQUIRE(sample(chalk, z, down, 0.5f, 0.2f, 0.3f).weight.x == Approx(0.3f));
}

TEST_CASE("bsdf: the density integrates to 1 less the mirror's share", "[reference]") {
    for (const Case& c : cases()) {
        for (const double angle : {0.0, 0.9, 1.5}) {
            CAPTURE(c.name, angle);
            const Bsdf<double> b = widened(c.bsdf);
            const Vector z(0, 0, 1), w_o = tilted(angle);
            const double p = integral(mirrored(z, w_o), [&](const Vector& w_i) { return pdf(b, z, w_o, w_i); });
            REQUIRE(p == Approx(1 - lobe_shares(b).mirror).epsilon(1e-3));
        }
    }
}

TEST_CASE("bsdf: samples weigh what the surface reflects, and their densities are their own", "[reference]") {
    const int n = 16, lobes = 48;
    for (const Case& c : cases()) {
        for (const double angle : {0.0, 0.9, 1.45}) {
            CAPTURE(c.name, angle);
            const glm::vec3 z(0, 0, 1), w_o = tilted(angle);
            Vector sum(0);
            int wrong = 0;
            for (int i = 0; i < lobes * n * n; ++i) {
                const float u_lobe = (float(i / (n * n)) + 0.5f) / lobes;
                const float u1 = (float(i % n) + hashed(i, 0)) / n, u2 = (float(i / n % n) + hashed(i, 1)) / n;
                const BsdfSample<float> s = sample(c.bsdf, z, w_o, u_lobe, u1, u2);
                sum += s.weight;
                const vec3<float> value = evaluate(c.bsdf, z, w_o, s.direction);
                if (s.mirror)
                    wrong += s.pdf != 0 || s.direction != mirrored(z, w_o);
                else
                    wrong += s.pdf != pdf(c.bsdf, z, w_o, s.direction) ||
                             s.weight != (value == vec3<float>(0) ? value : value / s.pdf);
            }
            REQUIRE(wrong == 0);
            const Vector mean = sum / double(lobes * n * n);
            for (int channel = 0; channel < 3; ++channel) {
                Bsdf<double> b = widened(c.bsdf);
                b.diffuse.x = b.diffuse[channel], b.specular.x = b.specular[channel];
                // The lobes' shares meet steps of 1/48: of the weight, which is at most 2, one step is misplaced.
                const double expected = albedo(b, tilted(angle)) + b.mirror[channel];
                REQUIRE(mean[channel] == Approx(expected).margin(0.012));
            }
        }
    }
}

TEST_CASE("bsdf: samples fall as densely as the density says", "[reference]") {
    // 12 x 12 boxes of equal solid angle about the normal, and the share of samples in each.
    const int rows = 12, columns = 12, count = 200000;
    const Bsdf<float> b = bsdf_of<float>(0.4, 0.5, 12);
    const glm::vec3 z(0, 0, 1), w_o = tilted(0.7);
    std::vector<double> hits(rows * columns), expected(rows * columns);
    for (int i = 0; i < count; ++i) {
        const vec3<float> d = sample(b, z, w_o, hashed(i, 0), hashed(i, 1), hashed(i, 2)).direction;
        const double turn = host::atan2(d.y, d.x) / (2 * host::pi) + 0.5;
        const int row = std::min(rows - 1, int((d.z + 1.0) / 2 * rows));
        const int column = std::min(columns - 1, int(turn * columns));
        hits[row * columns + column] += 1.0 / count;
    }
    const int fine = 16;
    for (int i = 0; i < rows * fine; ++i)
        for (int k = 0; k < columns * fine; ++k) {
            const double cosine = (i + 0.5) / (rows * fine) * 2 - 1, sine = std::sqrt(1 - cosine * cosine);
            const double phi = ((k + 0.5) / (columns * fine) - 0.5) * 2 * host::pi;
            const Vector d(sine * host::cos(phi), sine * host::sin(phi), cosine);
            const double p = pdf(widened(b), Vector(z), Vector(w_o), d);
            expected[i / fine * columns + k / fine] += p * 4 * host::pi / (rows * fine * columns * fine);
        }
    for (int box = 0; box < rows * columns; ++box) {
        CAPTURE(box, hits[box], expected[box]);
        // Five standard deviations of a count, and the quadrature's own error.
        REQUIRE(std::abs(hits[box] - expected[box]) <= 5 * std::sqrt(expected[box] / count) + 2e-5);
    }
}

TEST_CASE("bsdf: a lobe of exponent 1e6 keeps its shape in floats", "[reference]") {
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
        const vec3<float> a = hashed_direction(i, 0);
        const vec3<float> b = to_world(basis_of(a), cosine_power(hashed(i, 2), hashed(i, 3), 1e6f));
        const double expected = phong_lobe(glm::normalize(Vector(a)), glm::normalize(Vector(b)), 1e6);
        if (expected > 1e-3) worst = std::max(worst, std::abs(phong_lobe(a, b, 1e6f) / expected - 1));
    }
    // |a - b| is about 1e-3, its coordinates are rounded to 6e-8 at most. By the cosine the error would be above 3 %.
    REQUIRE(worst <= 1e-3);
    REQUIRE(worst > 0);
    // And wide lobes agree with powers of the cosine.
    for (const float exponent : {0.0f, 1.0f, 3.5f, 100.0f})
        for (const double angle : {0.0, 0.5, 1.0, 1.5}) {
            const vec3<float> a(0, 0, 1), b = tilted(angle);
            CAPTURE(exponent, angle);
            REQUIRE(phong_lobe(a, b, exponent) == Approx(host::pow(b.z, exponent)).epsilon(2e-5).margin(1e-7));
            REQUIRE(phong_lobe(a, -b, exponent) == 0);
        }
}

TEST_CASE("bsdf: extreme numbers give finite weights of unit directions", "[reference]") {
    std::vector<glm::vec3> normals{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int i = 0; i < 10; ++i) normals.push_back(hashed_direction(i, 7));
    const float corners[] = {0, 0x1p-24f, 0.5f, below_one};
    const std::vector<double> mixtures[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0.7, 0.3}, {0.2, 0.3, 0.5}};
    int samples = 0;
    for (const glm::vec3& n : normals) {
        const Basis<float> basis = basis_of(n);
        for (const double height : {1.0, 0.5, 1e-3, 1e-7, 0.0, -1e-3, -1.0}) {
            const float side = float(std::sqrt(1 - height * height));
            const vec3<float> w_o = to_world(basis, vec3<float>(side, 0, float(height)));
            for (const float exponent : {0.0f, 1.0f, 1e6f}) {
                for (const std::vector<double>& m : mixtures) {
                    const Bsdf<float> b = bsdf_of<float>(m[0], m[1], exponent, m[2]);
                    for (int u = 0; u < 64; ++u) {
                        const float u_lobe = corners[u % 4], u1 = corners[u / 4 % 4], u2 = corners[u / 16];
                        const BsdfSample<float> s = sample(b, n, w_o, u_lobe, u1, u2);
                        const bool unit = std::abs(glm::length(Vector(s.direction)) - 1) <= 1e-6;
                        const bool weighs = s.weight.x >= 0 && s.weight.x <= 2.001 * (m[0] + m[1] + m[2]);
                        const bool dense = s.pdf >= 0 && s.pdf <= 1.6e5f;
                        const bool unseen = glm::dot(n, w_o) < 0 && m[1] + m[2] > 0;
                        const bool below = glm::dot(n, s.direction) <= 0 || unseen;
                        const bool mirror = m[2] > 0 && u_lobe < float(m[2]);
                        const bool lost = !below || mirror || s.weight.x == 0;
                        ++samples;
                        if (unit && weighs && dense && lost && s.mirror == mirror) continue;
                        CAPTURE(n.x, n.y, n.z, height, exponent, m[0], m[1], m[2], u_lobe, u1, u2);
                        REQUIRE((unit && weighs));
                        REQUIRE((dense && lost));
                        REQUIRE(s.mirror == mirror);
                    }
                }
            }
        }
    }
    REQUIRE(samples == 16 * 7 * 3 * 6 * 64);
}

TEST_CASE("bsdf: a lobe that is not there is not chosen, however the shares round", "[reference]") {
    const vec3<float> z(0, 0, 1), up(0.6f, 0, 0.8f), r(-0.6f, 0, 0.8f);
    int rounded = 0;
    for (int i = 0; i < 1000; ++i) {
        const Bsdf<float> b = bsdf_of<float>(0, hashed(i, 0), 1e6, hashed(i, 1));
        const LobeShares<float> share = lobe_shares(b);
        rounded += share.mirror + share.specular <= below_one;
        const BsdfSample<float> s = sample(b, z, up, below_one, 0.9f, 0.3f);
        REQUIRE(glm::dot(s.direction, r) > 0.999f);
        REQUIRE(s.weight.x > 0);
    }
    REQUIRE(rounded > 10);
}

TEST_CASE("bsdf: the diffuse path is the general one without its lobes", "[reference]") {
    for (int i = 0; i < 10000; ++i) {
        const vec3<float> n = hashed_direction(i, 0), w = hashed_direction(i, 2);
        const vec3<float> w_o = glm::dot(n, w) < 0 ? -w : w, w_i = hashed_direction(i, 4);
        const Bsdf<float> b{{hashed(i, 6), 0.5f, 0.9f}, vec3<float>(0), 50, vec3<float>(0)};
        const BsdfSample<float> all = sample(b, n, w_o, hashed(i, 7), hashed(i, 8), hashed(i, 9));
        const BsdfSample<float> fast = sample_diffuse(b.diffuse, n, hashed(i, 8), hashed(i, 9));
        REQUIRE(fast.direction == all.direction);
        REQUIRE(fast.pdf == all.pdf);
        REQUIRE(!fast.mirror);
        REQUIRE(glm::length(fast.weight - all.weight) <= 3e-7);
        REQUIRE(glm::length(evaluate_diffuse(b.diffuse, n, w_i) - evaluate(b, n, w_o, w_i)) <= 1e-7);
        REQUIRE(pdf_diffuse(n, w_i) == pdf(b, n, w_o, w_i));
    }
}

TEST_CASE("bsdf: what is not a number stays visible", "[reference]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const vec3<float> z(0, 0, 1), up(0.6f, 0, 0.8f), broken(nan, 0, 0.8f);
    for (const Bsdf<float>& b : {bsdf_of<float>(0.5, 0, 1), bsdf_of<float>(0, 0.5, 1), bsdf_of<float>(0.4, 0.5, 1e6)}) {
        CAPTURE(b.diffuse.x, b.specular.x);
        REQUIRE(std::isnan(evaluate(b, z, up, broken).x));
        REQUIRE(std::isnan(evaluate(b, broken, up, up).x));
        REQUIRE(std::isnan(sample(b, broken, up, 0.3f, 0.3f, 0.3f).weight.x));
        Bsdf<float> c = b;
        c.diffuse.x = nan;
        REQUIRE(std::isnan(evaluate(c, z, up, up).x));
    }
    REQUIRE(std::isnan(evaluate(bsdf_of<float>(0, 0.5, 1), z, broken, up).x));
}
