#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/host_math.h"
#include "core/sequences.h"

using namespace plumb;

namespace {

const double pi = host::pi;

void require_near(double got, double expected, double tolerance) {
    CAPTURE(got, expected);
    REQUIRE(std::fabs(got - expected) <= tolerance);
}

template <class Sequence>
std::vector<glm::dvec2> points_of(int n, Sequence sequence) {
    std::vector<glm::dvec2> points;
    for (int i = 0; i < n; ++i) points.push_back(sequence(i));
    return points;
}

// True where each box of 2^a x 2^b with a + b = m holds exactly one of the 2^m points from `first` on.
template <class Sequence>
bool is_net(int m, int first, Sequence sequence) {
    for (int a = 0; a <= m; ++a) {
        const int columns = 1 << a, rows = 1 << (m - a);
        std::vector<int> count(std::size_t(1) << m);
        for (int i = first; i < first + (1 << m); ++i) {
            const glm::dvec2 p = sequence(i);
            ++count[std::size_t(int(p.y * rows) * columns + int(p.x * columns))];
        }
        for (int n : count)
            if (n != 1) return false;
    }
    return true;
}

// Interior points of the unit square on a grid that avoids symmetric places.
template <class F>
void for_grid(F f) {
    for (int j = 0; j < 37; ++j)
        for (int i = 0; i < 41; ++i) f(glm::dvec2((i + 0.413) / 41, (j + 0.287) / 37));
}

// The image of a small square has area 1 / pdf times as large: compared by finite differences, for maps into the plane
// and onto the sphere alike.
template <class Sample, class Pdf>
void require_density(Sample sample, Pdf pdf) {
    const double h = 1e-6;
    for_grid([&](glm::dvec2 u) {
        const glm::dvec3 x = (sample(u + glm::dvec2(h, 0)) - sample(u - glm::dvec2(h, 0))) / (2 * h);
        const glm::dvec3 y = (sample(u + glm::dvec2(0, h)) - sample(u - glm::dvec2(0, h))) / (2 * h);
        const double area = glm::length(glm::cross(x, y));
        CAPTURE(u.x, u.y);
        require_near(area * pdf(sample(u)), 1, 1e-6);
    });
}

template <class Sample, class Inverse>
void require_inverse(Sample sample, Inverse inverse) {
    for_grid([&](glm::dvec2 u) {
        const glm::dvec2 back = inverse(sample(u));
        CAPTURE(u.x, u.y);
        require_near(back.x, u.x, 1e-13);
        require_near(back.y, u.y, 1e-13);
    });
}

glm::dvec3 flat(const glm::dvec2& p) { return {p, 0}; }

}  // namespace

TEST_CASE("sequences: van der Corput mirrors the digits", "[sequences]") {
    const double expected[] = {0, 1. / 2, 1. / 4, 3. / 4, 1. / 8, 5. / 8, 3. / 8, 7. / 8};
    for (int i = 0; i < 8; ++i) CHECK(van_der_corput(i) == expected[i]);
    const double thirds[] = {0, 1. / 3, 2. / 3, 1. / 9, 4. / 9, 7. / 9, 2. / 9};
    for (int i = 0; i < 7; ++i) CHECK(van_der_corput(i, 3) == thirds[i]);
    CHECK(halton(5) == glm::dvec2(5. / 8, 7. / 9));
    CHECK(hammersley(3, 8) == glm::dvec2(3.5 / 8, 3. / 4));
    CHECK(van_der_corput(~std::uint64_t(0), 3) < 1);
}

TEST_CASE("sequences: Sobol's first points are the published ones", "[sequences]") {
    const glm::dvec2 expected[] = {{0, 0},         {0.5, 0.5},     {0.25, 0.75},   {0.75, 0.25},
                                   {0.125, 0.625}, {0.625, 0.125}, {0.375, 0.375}, {0.875, 0.875}};
    for (int i = 0; i < 8; ++i) CHECK(sobol(i) == expected[i]);
}

TEST_CASE("sequences: Sobol puts one point into each dyadic box, in every aligned run", "[sequences]") {
    for (int m = 0; m <= 10; ++m)
        for (int run = 0; run < 4; ++run) REQUIRE(is_net(m, run << m, [](int i) { return sobol(i); }));
    // An unaligned run, and Halton, do not.
    CHECK(!is_net(6, 17, [](int i) { return sobol(i); }));
    CHECK(!is_net(6, 0, [](int i) { return halton(i); }));
}

TEST_CASE("sequences: Hammersley's set of 2^m points has one in each dyadic box", "[sequences]") {
    CHECK(is_net(8, 0, [](int i) { return hammersley(i, 256); }));
}

TEST_CASE("sequences: R2 steps by the powers of the root of g^3 = g + 1", "[sequences]") {
    const double g = 1.32471795724474602596;  // Roberts 2018
    CHECK(r2(0) == glm::dvec2(0.5, 0.5));
    for (int i : {1, 2, 100, 12345}) {
        require_near(r2(i).x, std::fmod(0.5 + i / g, 1), 1e-11);
        require_near(r2(i).y, std::fmod(0.5 + i / (g * g), 1), 1e-11);
    }
    // Exact multiples wrap without drift: the step from 10^15 to its successor is the same.
    const std::uint64_t far = 1000000000000000;
    double step = r2(far + 1).x - r2(far).x;
    require_near(step < 0 ? step + 1 : step, 1 / g, 1e-15);
}

TEST_CASE("sequences: the star discrepancy of small sets is known", "[sequences]") {
    // One point at (1/2, 1/2): the box [0, 1) x [0, 1/2) has area 1/2 and no point; the closed one to the point has 3/4
    // too much.
    CHECK(star_discrepancy({{0.5, 0.5}}) == 0.75);
    CHECK(star_discrepancy({{0, 0}}) == 1);
    CHECK(star_discrepancy({{1, 1}}) == 1);
    // The best place of a single point is at c = (sqrt(5) - 1) / 2, where 1 - c^2 = c: discrepancy c.
    const double c = (std::sqrt(5) - 1) / 2;
    CHECK(star_discrepancy({{c, c}}) == Approx(c).epsilon(1e-15));
}

TEST_CASE("sequences: discrepancy falls nearly as 1/n, and beats hashed points", "[sequences]") {
    const int n = 1024;
    const double sobol_d = star_discrepancy(points_of(n, [](int i) { return sobol(i); }));
    const double halton_d = star_discrepancy(points_of(n, [](int i) { return halton(i); }));
    const double r2_d = star_discrepancy(points_of(n, [](int i) { return r2(i); }));
    const double hammersley_d = star_discrepancy(points_of(n, [](int i) { return hammersley(i, 1024); }));
    CAPTURE(sobol_d, halton_d, r2_d, hammersley_d);
    // Random points: about 1/sqrt(n) = 0.03. A (0, m, 2)-net in base 2 has at most (m/2 + 3/2) / n (Niederreiter
    // 1992, 4.7).
    CHECK(sobol_d <= (10. / 2 + 1.5) / n);
    CHECK(hammersley_d <= (10. / 2 + 2) / n);
    CHECK(halton_d < 0.008);
    CHECK(r2_d < 0.008);
}

TEST_CASE("sequences: best candidates keep their distance, at every prefix", "[sequences]") {
    const auto points = best_candidates(256, 7);
    REQUIRE(points.size() == 256);
    for (int n : {16, 64, 256}) {
        double nearest = 4;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < i; ++j) {
                double x = std::fabs(points[i].x - points[j].x), y = std::fabs(points[i].y - points[j].y);
                x = std::fmin(x, 1 - x), y = std::fmin(y, 1 - y);
                nearest = std::fmin(nearest, std::sqrt(x * x + y * y));
            }
        // The densest packing, a triangular lattice, has sqrt(2 / (sqrt(3) n)). Random points come to about 1 / (2 n).
        const double densest = std::sqrt(2 / (std::sqrt(3) * n));
        CAPTURE(n, nearest / densest);
        CHECK(nearest > 0.5 * densest);
        CHECK(nearest < densest);
    }
    CHECK(best_candidates(256, 7) == points);
    CHECK(best_candidates(64, 7) == std::vector<glm::dvec2>(points.begin(), points.begin() + 64));
    CHECK(best_candidates(64, 8) != std::vector<glm::dvec2>(points.begin(), points.begin() + 64));
}

TEST_CASE("sequences: each mapping has the density it claims", "[sequences]") {
    require_density([](glm::dvec2 u) { return flat(sample_disc(u)); }, [](glm::dvec3 p) { return pdf_disc(p); });
    require_density([](glm::dvec2 u) { return flat(sample_disc_linear(u)); },
                    [](glm::dvec3 p) { return pdf_disc_linear(p); });
    require_density(sample_sphere, [](glm::dvec3) { return pdf_sphere(); });
    require_density(sample_hemisphere, pdf_hemisphere);
    require_density(sample_cosine_hemisphere, pdf_cosine_hemisphere);
    for (double n : {0.0, 1.0, 32.0})
        require_density([&](glm::dvec2 u) { return sample_cosine_power(u, n); },
                        [&](glm::dvec3 d) { return pdf_cosine_power(d, n); });
    for (double c : {-0.5, 0.0, 0.9})
        require_density([&](glm::dvec2 u) { return sample_cone(u, c); }, [&](glm::dvec3 d) { return pdf_cone(d, c); });
}

TEST_CASE("sequences: the concentric map keeps areas", "[sequences]") {
    // Its density is that of the disc, 1/pi, but on the diagonals, where it has a crease.
    const double h = 1e-6;
    for_grid([&](glm::dvec2 u) {
        if (std::fabs(std::fabs(2 * u.x - 1) - std::fabs(2 * u.y - 1)) < 1e-4) return;
        const glm::dvec2 x = sample_disc_concentric({u.x + h, u.y}) - sample_disc_concentric({u.x - h, u.y});
        const glm::dvec2 y = sample_disc_concentric({u.x, u.y + h}) - sample_disc_concentric({u.x, u.y - h});
        require_near((x.x * y.y - x.y * y.x) / (4 * h * h), pi, 1e-6);
    });
    CHECK(sample_disc_concentric({0.5, 0.5}) == glm::dvec2(0, 0));
}

TEST_CASE("sequences: each mapping can be undone", "[sequences]") {
    require_inverse(sample_disc, inverse_disc);
    require_inverse(sample_disc_concentric, inverse_disc_concentric);
    require_inverse(sample_disc_linear, inverse_disc_linear);
    require_inverse(sample_sphere, inverse_sphere);
    require_inverse(sample_hemisphere, inverse_hemisphere);
    require_inverse(sample_cosine_hemisphere, inverse_cosine_hemisphere);
    for (double n : {0.0, 1.0, 32.0})
        require_inverse([&](glm::dvec2 u) { return sample_cosine_power(u, n); },
                        [&](glm::dvec3 d) { return inverse_cosine_power(d, n); });
    for (double c : {-0.5, 0.0, 0.9})
        require_inverse([&](glm::dvec2 u) { return sample_cone(u, c); },
                        [&](glm::dvec3 d) { return inverse_cone(d, c); });
}

TEST_CASE("sequences: directions are unit, also at the corners of the square", "[sequences]") {
    const double last = 0x1.fffffffffffffp-1;
    for (double x : {0.0, 1e-300, 0.5, last})
        for (double y : {0.0, 0.25, last}) {
            const glm::dvec2 u(x, y);
            for (const glm::dvec3& d : {sample_sphere(u), sample_hemisphere(u), sample_cosine_hemisphere(u),
                                        sample_cosine_power(u, 50), sample_cone(u, 0.99)})
                require_near(glm::length(d), 1, 1e-15);
        }
    CHECK(pdf_hemisphere({0, 0.6, -0.8}) == 0);
    CHECK(pdf_cosine_hemisphere({0, 0.6, -0.8}) == 0);
    CHECK(pdf_cone({0, 0.8, 0.6}, 0.7) == 0);
    CHECK(pdf_disc({1, 0.1}) == 0);
}

TEST_CASE("sequences: the cosine-weighted mean over Sobol points has its closed form", "[sequences]") {
    // E[f] with density cos / pi: f = cos gives 2/3, f = x^2 gives 1/4.
    double z = 0, x2 = 0;
    const int n = 1 << 14;
    for (int i = 0; i < n; ++i) {
        const glm::dvec3 d = sample_cosine_hemisphere(sobol(i) + 0x1p-33);
        z += d.z, x2 += d.x * d.x;
    }
    require_near(z / n, 2. / 3, 1e-4);
    require_near(x2 / n, 0.25, 1e-4);
}
