// What probes see as coefficients of harmonics, in closed form: constant radiance, harmonics themselves, levels of detail, windows.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "gi/probes/directions.h"
#include "gi/probes/lambda.h"
#include "gi/probes/transport.h"
#include "gi/probes/window.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

float draw(int i, int seed) { return float(std::uint32_t(pixel_hash<std::int32_t>(i, seed, 0, 11).x) >> 8) * 0x1p-24f; }

// The probes of one set of directions, all at level 0 but for what a test says.
struct Probes {
    int probes, degree;
    Buffer<glm::vec4> directions, radiance;
    Buffer<float> harmonics, weights;
    std::vector<std::int32_t> level;
    LambdaInputs in;

    Probes(int p, int rays, int d, const std::vector<int>& level_rays = {}, const std::vector<int>& level_degrees = {})
        : probes(p), degree(d), directions(relight_directions(rays)), harmonics(harmonics_of(directions, d)) {
        std::vector<int> n = level_rays;
        if (n.empty()) n = {rays};
        weights = level_weights(directions, n);
        radiance.assign(std::size_t(p) * std::size_t(rays), glm::vec4(0)), level.assign(std::size_t(p), 0);
        in.levels = int(n.size());
        for (std::size_t k = 0; k < n.size(); ++k) {
            in.level_rays[k] = n[k];
            in.level_coefficients[k] = sh::count(k < level_degrees.size() ? level_degrees[k] : d);
        }
    }
    int rays() const { return int(directions.size()); }
    glm::vec4& f(int probe, int ray) { return radiance[std::size_t(probe * rays() + ray)]; }
    Buffer<glm::vec4> lambda(const RunOptions& options = {}) {
        in.probes = probes, in.rays = rays(), in.coefficients = sh::count(degree);
        in.radiance = &radiance, in.harmonics = &harmonics, in.weights = &weights, in.probe_level = &level;
        Buffer<glm::vec4> out;
        run(in, options, out);
        return out;
    }
    void scatter() {
        for (std::size_t i = 0; i < radiance.size(); ++i)
            radiance[i] = {draw(int(i), 1) - 0.25f, 3 * draw(int(i), 2), 1e3f * draw(int(i), 3), draw(int(i), 4)};
    }
};

}  // namespace

TEST_CASE("probes.lambda: of a constant radiance L the first coefficient is L sqrt(4 pi), the others 0, for every prefix",
          "[probes][lambda][IPR (10)][analytic]") {
    // Each prefix' weights integrate harmonics up to exact_degree() exactly.
    for (const int n : {512, 500, 256, 129, 128, 127, 64, 10, 1}) {
        const int degree = std::min(7, exact_degree(n));
        Probes p(1, 512, degree, {n});
        p.radiance.assign(512, {0.25f, 2, 1e4f, 5});
        const Buffer<glm::vec4> lambda = p.lambda();
        CAPTURE(n, degree);
        REQUIRE(int(lambda.size()) == sh::count(degree));
        for (int c = 0; c < 3; ++c) {
            const double first = double(p.radiance[0][c]) * std::sqrt(4 * host::pi);
            CHECK(lambda[0][c] == Approx(first).epsilon(1e-6));
            // Roundings of weights and harmonics, 2^-24 each of terms that sum to less than 4 pi L 1.1.
            for (std::size_t j = 1; j < lambda.size(); ++j) CHECK(std::fabs(lambda[j][c]) < 2e-6 * first);
        }
        CHECK(lambda[0].w == 0);
    }
}

TEST_CASE("probes.lambda: radiance Y_lm gives a unit vector", "[probes][lambda][IPR (10)][analytic]") {
    // Products of two harmonics are exact where their degrees sum to at most exact_degree(): 7 + 7 for 512 rays, 5 + 5 for 256.
    for (const auto& [n, degree] : {std::pair{512, 7}, {256, 5}, {128, 3}, {64, 2}}) {
        const int count = sh::count(degree);
        Probes p(count, 512, degree, {n});
        for (int j = 0; j < count; ++j)
            for (int r = 0; r < 512; ++r) p.f(j, r) = glm::vec4(p.harmonics[std::size_t(r * count + j)], 0, 0, 0);
        const Buffer<glm::vec4> lambda = p.lambda();
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j) {
                CAPTURE(n, i, j);
                CHECK(std::fabs(lambda[std::size_t(i * count + j)].x - (i == j ? 1 : 0)) < 2e-6);
                CHECK(lambda[std::size_t(i * count + j)].y == 0);
            }
    }
}

TEST_CASE("probes.lambda: equal weights, as printed, are what (10) says", "[probes][lambda][IPR (10)][analytic]") {
    Probes p(3, 300, 4);
    p.scatter(), p.weights.assign(300, float(4 * host::pi / 300));
    const Buffer<glm::vec4> lambda = p.lambda();
    for (int probe = 0; probe < 3; ++probe)
        for (int j = 0; j < 25; ++j) {
            double sum = 0, size = 0;
            for (int r = 0; r < 300; ++r) {
                const double term = double(p.f(probe, r).y) * double(p.harmonics[std::size_t(r * 25 + j)]);
                sum += term, size += std::fabs(term);
            }
            CHECK(std::fabs(lambda[std::size_t(probe * 25 + j)].y - 4 * host::pi / 300 * sum) <= 2e-6 * (4 * host::pi / 300 * size));
        }
}

TEST_CASE("probes.lambda: agrees with the sum in double", "[probes][lambda]") {
    Probes p(5, 512, 7);
    p.scatter();
    const Buffer<glm::vec4> lambda = p.lambda();
    std::vector<glm::dvec3> radiance;
    for (const glm::vec4& f : p.radiance) radiance.emplace_back(f);
    const std::vector<glm::dvec3> exact = probe_coefficients(radiance, 5, p.weights, p.harmonics, 7);
    REQUIRE(exact.size() == lambda.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
        // 132 roundings of the sum of magnitudes, at most 4 pi times the largest radiance times |Y| < 2.2; in fact far fewer.
        CHECK(std::fabs(lambda[i].x - exact[i].x) < 2e-6 * 4 * host::pi * 0.75);
        CHECK(std::fabs(lambda[i].y - exact[i].y) < 2e-6 * 4 * host::pi * 3);
        CHECK(std::fabs(lambda[i].z - exact[i].z) < 2e-6 * 4 * host::pi * 1e3);
    }
}

TEST_CASE("probes.lambda: a level has its own rays, weights and coefficients", "[probes][lambda][IPR 4.2.1][analytic]") {
    const std::vector<int> rays = {200, 128, 64, 9}, degrees = {7, 5, 2, 0};
    Probes p(9, 200, 7, rays, degrees);
    p.scatter();
    for (int i = 0; i < 9; ++i) p.level[std::size_t(i)] = i % 4;
    // What lies behind a level's rays is not read.
    for (int i = 0; i < 9; ++i)
        for (int r = rays[std::size_t(i % 4)]; r < 200; ++r) p.f(i, r) = glm::vec4(not_a_number);
    const Buffer<glm::vec4> lambda = p.lambda();
    for (int i = 0; i < 9; ++i) {
        const int n = rays[std::size_t(i % 4)], d = degrees[std::size_t(i % 4)];
        Probes alone(1, n, d);
        for (int r = 0; r < n; ++r) alone.f(0, r) = p.f(i, r);
        const Buffer<glm::vec4> expected = alone.lambda();
        for (int j = 0; j < 64; ++j) {
            const glm::vec4 got = lambda[std::size_t(i * 64 + j)];
            CAPTURE(i, j);
            CHECK(got == (j < sh::count(d) ? expected[std::size_t(j)] : glm::vec4(0)));
        }
    }
}

TEST_CASE("probes.lambda: the loop over lanes has the bits of one item after the other", "[probes][lambda][bits]") {
    // Counts of coefficients around the lanes of every set; the last rows of the table end within a packet.
    for (const int degree : {0, 1, 2, 3, 4, 5, 6, 7})
        for (const int rays : {1, 3, 130, 257}) {
            Probes p(5, rays, degree, {rays, std::max(1, rays - 2), 1}, {degree, std::max(0, degree - 1), 0});
            p.scatter();
            p.level = {0, 1, 2, 0, 1};
            p.f(1, 0).y = not_a_number, p.f(3, rays - 1).z = std::numeric_limits<float>::infinity();
            (void)p.lambda();
            const StageData data = data_of(p.in);
            const int count = sh::count(degree);
            Buffer<glm::vec4> expected(std::size_t(5 * count));
            const LambdaView v{uniforms_of<LambdaUniforms>(data), &p.radiance[0].x, p.harmonics.data(), p.weights.data(), p.level.data(),
                               &expected[0].x};
            NoTap tap;
            for (int i = 0; i < 5; ++i)
                for (int j = 0; j < count; ++j)
                    number<float>::store4(v.lambda, i * count + j, LambdaKernel::item<float>(v, j, i, tap), true);
            for (const Isa isa : supported_isas())
                for (const int threads : {1, 2}) {
                    RunOptions options;
                    options.isa = isa, options.threads = threads;
                    const Buffer<glm::vec4> got = p.lambda(options);
                    CAPTURE(degree, rays, isa_name(isa), threads);
                    REQUIRE(got.size() == expected.size());
                    CHECK(std::memcmp(got.data(), expected.data(), got.size() * sizeof got[0]) == 0);
                }
        }
}

TEST_CASE("probes.lambda: what is no number shows, wherever it stands", "[probes][lambda]") {
    Probes whole(2, 40, 2);
    whole.scatter();
    for (int c = 0; c < 3; ++c) {
        Probes p = whole;
        p.f(1, 39)[c] = not_a_number;
        const Buffer<glm::vec4> lambda = p.lambda();
        for (int j = 0; j < 9; ++j) {
            CHECK(std::isnan(lambda[std::size_t(9 + j)][c]));
            CHECK((std::isfinite(lambda[std::size_t(j)][c]) && std::isfinite(lambda[std::size_t(9 + j)][(c + 1) % 3])));
        }
    }
    Probes p = whole;
    p.harmonics[9 * 39 + 4] = not_a_number;
    CHECK((std::isnan(p.lambda()[4].x) && std::isnan(p.lambda()[13].z) && std::isfinite(p.lambda()[5].x)));
    p = whole, p.weights[7] = not_a_number;
    for (const glm::vec4& l : p.lambda()) CHECK((std::isnan(l.x) && std::isnan(l.y) && std::isnan(l.z) && l.w == 0));
}

TEST_CASE("probes.lambda: refuses in one line what does not fit", "[probes][lambda]") {
    const auto refused = [](auto change) {
        Probes p(3, 20, 3, {20, 10});
        CHECK_NOTHROW(p.lambda());
        change(p);
        std::string message;
        try {
            p.lambda();
        } catch (const InputError& e) {
            message = e.what();
        }
        CAPTURE(message);
        CHECK(message.starts_with("probes.lambda: "));
        CHECK(message.find('\n') == std::string::npos);
    };
    refused([](Probes& p) { p.radiance.pop_back(); });
    refused([](Probes& p) { p.harmonics.push_back(0); });
    refused([](Probes& p) { p.weights.resize(20); });
    refused([](Probes& p) { p.level.clear(); });
    refused([](Probes& p) { p.level[1] = 2; });
    refused([](Probes& p) { p.level[2] = -1; });
    refused([](Probes& p) { p.in.level_rays[1] = 0; });
    refused([](Probes& p) { p.in.level_rays[0] = 21; });
    refused([](Probes& p) { p.in.level_coefficients[1] = 17; });
    refused([](Probes& p) { p.in.level_coefficients[0] = 0; });
    refused([](Probes& p) { p.in.levels = 5; });
    refused([](Probes& p) { p.probes = 0; });
    CHECK_THROWS_AS(level_weights(relight_directions(8), {9}), InputError);
    CHECK_THROWS_AS(level_weights(relight_directions(8), {8, 0}), InputError);
}

TEST_CASE("windows: factors in closed form", "[probes][window][analytic]") {
    for (int degree = 0; degree <= 7; ++degree)
        for (const Window window : {Window::none, Window::hann, Window::lanczos}) {
            const std::vector<double> s = window_factors(window, degree);
            REQUIRE(int(s.size()) == degree + 1);
            CHECK(s[0] == 1);
            for (int l = 1; l <= degree; ++l) CHECK((window == Window::none ? s[std::size_t(l)] == 1 : s[std::size_t(l)] < s[std::size_t(l - 1)]));
            CHECK(s.back() > 0);
        }
    // Of degree 1, w = 2: (1 + cos(pi / 2)) / 2 and sin(pi / 2) / (pi / 2); of degree 2, w = 3: cos(2 pi / 3) = -1 / 2.
    CHECK(window_factors(Window::hann, 1)[1] == Approx(0.5));
    CHECK(window_factors(Window::lanczos, 1)[1] == Approx(2 / host::pi));
    CHECK(window_factors(Window::hann, 2)[2] == Approx(0.25));
    CHECK(window_factors(Window::lanczos, 2)[2] == Approx(std::sqrt(3.0) / 2 / (2 * host::pi / 3)));
    CHECK_THROWS_AS(window_factors(Window::hann, 8), InputError);
    CHECK_THROWS_AS(window_factors(Window::hann, -1), InputError);
    CHECK_THROWS_AS(windowed(Buffer<float>(10), 2, Window::hann), InputError);
}

TEST_CASE("windows: constant radiance stays exact, harmonics are multiplied by their degree's factor", "[probes][window][analytic]") {
    for (const Window window : {Window::hann, Window::lanczos}) {
        Probes plain(2, 512, 7);
        for (int r = 0; r < 512; ++r) plain.f(0, r) = glm::vec4(3), plain.f(1, r) = glm::vec4(plain.harmonics[std::size_t(r * 64 + 30)]);
        Probes p = plain;
        p.harmonics = windowed(plain.harmonics, 7, window);
        const Buffer<glm::vec4> before = plain.lambda(), after = p.lambda();
        CHECK(after[0] == before[0]);
        for (std::size_t j = 1; j < 64; ++j) CHECK(std::fabs(after[j].x) < 2e-6 * after[0].x);
        // Harmonic 30 has degree 5: 25 .. 35.
        CHECK(after[64 + 30].x == Approx(window_factors(window, 7)[5]).epsilon(1e-5));
    }
    const Buffer<float> y = harmonics_of(relight_directions(5), 3);
    CHECK(windowed(y, 3, Window::none) == y);
}

TEST_CASE("windows: how many normals see negative irradiance of a peak", "[probes][window][analytic]") {
    // One bright ray: the clamped cosine's series to degree 2, with x the cosine to it, 1/4 + s_1 x / 2 + s_2 5/32 (3 x^2 - 1)
    // (Ramamoorthi and Hanrahan 2001), is negative between its roots. Of directions, x is uniform in -1 .. 1.
    Buffer<glm::vec4> irradiance;
    const auto negative = [&](Window window) {
        Probes p(1, 512, 2);
        p.harmonics = windowed(p.harmonics, 2, window);
        p.f(0, 100) = glm::vec4(100, 100, 100, 0);
        const Buffer<glm::vec4> lambda = p.lambda();
        irradiance.clear();
        for (const glm::vec4& n : relight_directions(4096)) {
            const sh::Values y = sh::basis(glm::normalize(glm::dvec3(n)), 2);
            double e = 0;
            for (int l = 0; l <= 2; ++l)
                for (int j = sh::index(l, -l); j <= sh::index(l, l); ++j)
                    e += sh::clamped_cosine()[std::size_t(l)] * double(lambda[std::size_t(j)].x) * y[std::size_t(j)];
            irradiance.emplace_back(e, e, e, 1);
        }
        irradiance.emplace_back(-1e9f, -1e9f, -1e9f, 0);  // not computed
        const NegativeIrradiance found = negative_irradiance(irradiance);
        CHECK(found.computed == 4096);
        CHECK((found.least < 0 && found.least > -100));
        return double(found.negative) / found.computed;
    };
    const auto expected = [](double s1, double s2) {
        const double a = s2 * 15 / 32, b = s1 / 2, c = 0.25 - s2 * 5 / 32, root = std::sqrt(b * b - 4 * a * c);
        return ((-b + root) - std::max(-b - root, -2 * a)) / (2 * a) / 2;
    };
    // 29 % without a window, 14 % by Hann, 18 % by Lanczos.
    CHECK(negative(Window::none) == Approx(expected(1, 1)).margin(0.005));
    CHECK(negative(Window::hann) == Approx(expected(0.75, 0.25)).margin(0.005));
    CHECK(negative(Window::lanczos) == Approx(expected(0.8269933, 0.4134967)).margin(0.005));
}

TEST_CASE("windows: negative irradiance is counted where it was computed, and has to be finite", "[probes][window]") {
    CHECK_THROWS_AS(negative_irradiance(Buffer<glm::vec4>{{not_a_number, 0, 0, 1}}), InputError);
    CHECK_THROWS_AS(negative_irradiance(Buffer<glm::vec4>{{0, 0, 0, not_a_number}}), InputError);
    CHECK_NOTHROW(negative_irradiance(Buffer<glm::vec4>{{not_a_number, 0, 0, 0}}));
    const NegativeIrradiance found = negative_irradiance(Buffer<glm::vec4>{{0, 1, -0.5f, 1}, {0, 0, 0, 1}, {-2, 0, 0, 0}});
    CHECK((found.computed == 2 && found.negative == 1 && found.least == -0.5f));
}
