// How the steps of rsm.paths grow with the distance from the path's start, and what their samples weigh (VRSM 3.2, fig. 3.1).
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/host_math.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

constexpr int map_size = 512;

struct Law {
    rsm::Spacing spacing;
    float growth;
};
constexpr Law laws[] = {{rsm::Spacing::uniform, 64}, {rsm::Spacing::quadratic, 64}, {rsm::Spacing::geometric, 1.5f},
                        {rsm::Spacing::geometric, 64}, {rsm::Spacing::geometric, 4096}};

rsm::GatherParams paths_params(const Law& law, float jitter) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths;
    params.spacing = law.spacing, params.growth = law.growth, params.jitter = jitter;
    return params;
}

// rho over r, and twice the integral of rho drho from 0, over r^2, at u of the path's length.
double share_of_radius(const Law& law, double u) {
    switch (law.spacing) {
        case rsm::Spacing::uniform: return u;
        case rsm::Spacing::quadratic: return u * u;
        case rsm::Spacing::geometric: break;
    }
    return (std::pow(double(law.growth), u) - 1) / (double(law.growth) - 1);
}
double share_of_disc(const Law& law, double u) { return share_of_radius(law, u) * share_of_radius(law, u); }

double disc(const rsm::GatherParams& params) {
    const double r = double(params.radius) * map_size;
    return host::pi * r * r;
}
double weight(const rsm::Pattern& p, int k, int i) { return p.weights[std::size_t(k) * p.rotations + i]; }
double weight_of_rotation(const rsm::Pattern& p, int i) {
    double sum = 0;
    for (int k = 0; k < p.samples; ++k) sum += weight(p, k, i);
    return sum;
}

}  // namespace

TEST_CASE("rsm.paths: of each spacing a sample weighs its ring's share, without jitter", "[rsm][paths][VRSM 3.2][analytic]") {
    for (const Law& law : laws)
        for (auto [directions, steps] : {std::pair{15, 10}, {1, 1}, {7, 3}, {64, 32}}) {
            rsm::GatherParams params = paths_params(law, 0);
            params.directions = directions, params.steps = steps;
            const rsm::Pattern p = rsm::paths_pattern(params, map_size, 1);
            CAPTURE(int(law.spacing), law.growth, directions, steps);
            for (int i = 0; i < p.rotations; i += 21) {
                CHECK(weight_of_rotation(p, i) == Approx(disc(params)).epsilon(1e-6).margin(0));
                for (int k = 0; k < p.samples; ++k) {
                    const int step = k % steps;
                    const double ring =
                        share_of_disc(law, (step + 1.0) / steps) - share_of_disc(law, double(step) / steps);
                    CHECK(weight(p, k, i) == Approx(disc(params) * ring / directions).epsilon(1e-6).margin(0));
                }
            }
        }
}

TEST_CASE("rsm.paths: of each spacing the weights sum to the disc on the average", "[rsm][paths][VRSM 3.2][analytic]") {
    // Places in a step are 1/64 apart, so the mean of what varies by V in it is off by V / 128 at most. The weight over
    // pi r^2 / (M K) is (g^2)': it grows from 0 to twice g'(1), which the steps share.
    for (const Law& law : laws)
        for (const float jitter : {1e-6f, 0.3f, 1.0f}) {
            const rsm::GatherParams params = paths_params(law, jitter);
            const rsm::Pattern p = rsm::paths_pattern(params, map_size, 3);
            double sum = 0;
            for (int i = 0; i < p.rotations; ++i) sum += weight_of_rotation(p, i) / disc(params) / p.rotations;
            const double b = double(law.growth);
            const double slope = law.spacing == rsm::Spacing::uniform     ? 1
                                 : law.spacing == rsm::Spacing::quadratic ? 2
                                                                          : std::log(b) * b / (b - 1);
            CAPTURE(int(law.spacing), law.growth, jitter, sum);
            CHECK(sum == Approx(1).epsilon(slope / (64 * params.steps)).margin(0));
        }
}

TEST_CASE("rsm.paths: samples lie where the spacing has them", "[rsm][paths][VRSM 3.2][analytic]") {
    for (const Law& law : laws)
        for (const float jitter : {0.0f, 1.0f}) {
            rsm::GatherParams params = paths_params(law, jitter);
            params.texels = rsm::Texels::continuous;
            const double r = double(params.radius) * map_size;
            const rsm::Pattern p = rsm::paths_pattern(params, map_size, 5);
            CAPTURE(int(law.spacing), law.growth, jitter);
            double farthest = 0, nearest = 1e9;
            for (int k = 0; k < p.samples; ++k)
                for (int i = 0; i < p.rotations; ++i) {
                    const float* at = &p.positions[2 * (std::size_t(k) * p.rotations + i)];
                    const double rho = std::sqrt(double(at[0]) * at[0] + double(at[1]) * at[1]);
                    const int step = k % params.steps;
                    const double half = double(jitter) / 2;
                    CHECK(rho >= r * share_of_radius(law, (step + 0.5 - half) / params.steps) * (1 - 1e-6) - 1e-6);
                    CHECK(rho <= r * share_of_radius(law, (step + 0.5 + half) / params.steps) * (1 + 1e-6));
                    farthest = std::max(farthest, rho / r), nearest = std::min(nearest, rho / r);
                }
            if (jitter == 1) CHECK(farthest > share_of_radius(law, 0.99));
            if (jitter == 1) CHECK(nearest < share_of_radius(law, 0.01));
        }
}

TEST_CASE("rsm.paths: geometric spacing that grows by nothing is uniform", "[rsm][paths][bits]") {
    for (const float jitter : {0.0f, 1.0f}) {
        const rsm::Pattern a = rsm::paths_pattern(paths_params({rsm::Spacing::uniform, 64}, jitter), map_size, 2);
        const rsm::Pattern b = rsm::paths_pattern(paths_params({rsm::Spacing::geometric, 1}, jitter), map_size, 2);
        const rsm::Pattern c = rsm::paths_pattern(paths_params({rsm::Spacing::geometric, 1.000001f}, jitter), map_size, 2);
        CHECK(std::equal(a.weights.begin(), a.weights.end(), b.weights.begin(), b.weights.end()));
        CHECK(std::equal(a.offsets.begin(), a.offsets.end(), b.offsets.begin(), b.offsets.end()));
        for (std::size_t k = 0; k < a.weights.size(); ++k)
            CHECK(a.weights[k] == Approx(c.weights[k]).epsilon(1e-5).margin(0));
    }
}

TEST_CASE("rsm.paths: of each spacing a constant is integrated exactly", "[rsm][paths][VRSM 3.2][analytic]") {
    // 50 m away every texel sends the same.
    const raster::Rsm flat = plane_map(256, [](double, double) { return 1.0; });
    const Points far({0, 0, 50}, {0, 0, -1});
    for (const Law& law : laws) {
        rsm::GatherParams params = paths_params(law, 0);
        params.visibility = rsm::Visibility::none;
        const rsm::Pattern pattern = rsm::paths_pattern(params, 256, 1);
        const double radius = double(params.radius);
        const double truth = host::pi * 4 * radius * radius / (host::pi * 50 * 50);  // m2; E = A / (pi d^2)
        CAPTURE(int(law.spacing), law.growth);
        CHECK(gather(params, far, flat, &pattern)(0, 0).x == Approx(truth).epsilon(5e-4).margin(0));
    }
}

TEST_CASE("rsm.paths: weights by squared distance are right where spacing grows with it", "[rsm][paths][VRSM 3.2][published]") {
    // rho^2 over the ring's share: beyond r / growth the two agree but for one factor.
    const Law law{rsm::Spacing::geometric, 1e6f};
    rsm::GatherParams params = paths_params(law, 1);
    params.steps = 10;
    const rsm::Pattern corrected = rsm::paths_pattern(params, map_size, 1);
    params.variant = rsm::Variant::published;
    const rsm::Pattern published = rsm::paths_pattern(params, map_size, 1);
    double least = 1e9, most = 0;
    for (int k = 0; k < corrected.samples; ++k) {
        if (k % params.steps < 4) continue;  // from rho = 2.5e-4 r on
        const double ratio = weight(published, k, 7) / weight(corrected, k, 7);
        least = std::min(least, ratio), most = std::max(most, ratio);
    }
    CAPTURE(least, most);
    CHECK(most / least < 1.01);
}
