// Light in closed rooms in closed form, through relight rays, transport and clusters.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/sh.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

// Of every surface with the direct irradiance e and reflectance rho, I = rho (e + I). Of a sphere with a lamp of power P in
// it e = P / A: (P/A) rho / (1 - rho). Where a share d too much arrives at each bounce, rho is rho (1 + d).
double closed_form(double e, double rho, double too_much = 0) {
    const double r = rho * (1 + too_much);
    return e * r / (1 - r);
}

// Until what is missing is below 1e-9 of the whole.
int rounds_of(double rho) { return int(std::ceil(host::log(1e-9) / host::log(rho))); }

}  // namespace

TEST_CASE("bake: in a closed convex room indirect irradiance is E rho / (1 - rho), to rounding", "[probes][analytic][furnace]") {
    // What every ray meets some probe sees, shares of a ray sum to pi / N, and the weights of 256 relight rays integrate all
    // harmonics to degree 7 exactly: no error of sampling is left, at any rho. What is left is rounding: weights and Y_j of
    // relight rays, and alpha, are floats, alpha a sum of 128 of them. One bounce says how much (measured 1.5e-6, at most 128
    // roundings of alpha, 8e-6); 1 / (1 - rho) bounces add up to the rest.
    const double e = 3;
    for (const auto& [name, scene] : {std::pair("room", empty_room()), {"ball", inside_of_ball(16)}}) {
        BakeParams params = small();
        params.receivers_per_m2 = 5;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        CAPTURE(name, b.receivers.count());
        CHECK(b.supports.unsupported == 0);
        CHECK(b.counts().escaped == 0);
        CHECK(b.counts().back == 0);
        REQUIRE(b.counts().unseen == 0);
        for (const double rho : {0.1, 0.5, 0.9}) {
            test::RunTime whole(b, e, rho);
            whole.whole_round();
            const double few = whole.least() / (rho * e) - 1, many = whole.most() / (rho * e) - 1;
            CHECK(few > -1e-5);
            CHECK(many < 1e-5);
            for (int round = 1; round < rounds_of(rho); ++round) whole.whole_round();
            CAPTURE(rho, few, many, whole.least() / closed_form(e, rho) - 1, whole.most() / closed_form(e, rho) - 1);
            CHECK(whole.least() >= closed_form(e, rho, few) * (1 - 1e-6));
            CHECK(whole.most() <= closed_form(e, rho, many) * (1 + 1e-6));
        }
    }
}

TEST_CASE("bake: clusters lose of the light in a room no more than their tails", "[probes][analytic][furnace]") {
    // Of a constant radiance L the coefficients of P probes are sqrt(4 pi) L each: of length sqrt(4 pi P) L. What a cluster
    // leaves out of a receiver's row is at most its tail's Frobenius norm (Eckart and Young), so of irradiance at most the
    // product (Cauchy and Schwarz).
    const double e = 3;
    for (const auto& [name, scene] : {std::pair("room", empty_room()), {"ball", inside_of_ball(16)}, {"furnished", furnished()}}) {
        BakeParams params = small();
        params.receivers_per_m2 = 5;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        // rho = 1, one bounce: the radiance is E / pi.
        test::RunTime whole(b, e, 1), clustered(b, e, 1);
        whole.whole_round(), clustered.clustered_round();
        double worst = 0, allowed = 0;
        for (const Cluster& c : b.clusters.clusters) {
            double squares = 0;
            for (const double s : c.spectrum) squares += s * s;
            const double bound = c.error_frobenius * std::sqrt(squares) * std::sqrt(4 * host::pi * double(c.probes.size())) * e / host::pi;
            for (const std::int32_t i : c.receivers) {
                const double lost = std::fabs(whole.irradiances()[std::size_t(i)].x - clustered.irradiances()[std::size_t(i)].x);
                CHECK(lost <= bound + 1e-5 * e);
                worst = std::max(worst, lost), allowed = std::max(allowed, bound);
            }
        }
        CAPTURE(name, worst, allowed);
        CHECK(worst < 0.01 * e);  // 0.005 e in the furnished room; the bound is 50 times as much, since no row is all tail
        if (name != std::string("ball")) CHECK(worst > 0);  // whose clusters have full rank
        for (const double rho : {0.1, 0.5, 0.9}) {
            test::RunTime w(b, e, rho), c(b, e, rho);
            for (int round = 0; round < rounds_of(rho) / 3; ++round) w.whole_round(), c.clustered_round();
            CAPTURE(rho, w.mean(), c.mean(), c.least(), c.most());
            CHECK(c.mean() == Approx(w.mean()).epsilon(0.005));
        }
    }
}

TEST_CASE("bake: rays that end where no probe looks are what a furnished room lacks", "[probes][analytic][furnace]") {
    const double e = 3;
    Scene scene = furnished();
    BakeParams params = small();
    params.receivers_per_m2 = 5;
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    CHECK(b.supports.unsupported == 0);
    const double unseen = double(b.counts().unseen) / (double(b.receivers.count()) * params.receiver_rays);
    CHECK(unseen > 0);
    CHECK(b.counts().back == 0);
    for (const double rho : {0.1, 0.5, 0.9}) {
        test::RunTime whole(b, e, rho);
        whole.whole_round();
        // Each ray brings as much as any other: the mean over receivers lacks the share of rays.
        CHECK(whole.mean() == Approx(rho * e * (1 - unseen)).epsilon(1e-5));
        CHECK(whole.most() <= rho * e * (1 + 1e-5));
        for (int round = 1; round < rounds_of(rho); ++round) whole.whole_round();
        CAPTURE(rho, unseen, whole.mean() / closed_form(e, rho), closed_form(e, rho, -unseen) / closed_form(e, rho));
        CHECK(whole.mean() < closed_form(e, rho));
        // Which surfaces are darker, and how often they are met, is not the mean alone.
        CHECK(whole.mean() == Approx(closed_form(e, rho, -unseen)).epsilon(0.2 * rho));
    }
}

TEST_CASE("bake: too few relight rays for a degree are what takes uniformity away", "[probes][analytic][furnace]") {
    // 64 rays integrate harmonics to degree 4 exactly: with degree 4 the room is uniform to rounding, with degree 7 it is not.
    Scene scene = empty_room();
    double off[2];
    for (const int degree : {4, 7}) {
        BakeParams params = small();
        params.receivers_per_m2 = 5, params.relight_rays = 64, params.degree = degree;
        BakeGraph graph(scene, params);
        run_all(graph);
        test::RunTime whole(graph.bake(), 3, 0.5);
        whole.whole_round();
        off[degree == 7] = std::max(whole.most() / 1.5 - 1, 1 - whole.least() / 1.5);
    }
    CAPTURE(off[0], off[1]);
    CHECK(off[0] < 1e-5);
    CHECK(off[1] > 1e-3);
}
