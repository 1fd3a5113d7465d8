// Fitted transport (gi/probes/fit.h): exact where it has to be, the same bits everywhere, and nearer to closed forms than IPR (9).
#include <catch2/catch.hpp>
#include <cmath>

#include "core/host_math.h"
#include "gi/probes/fit.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

probes::Bake bake_of(const Scene& scene, probes::Gather gather, RunOptions options = {}, int rays = 256, int overlaps = 10) {
    probes::BakeParams params = small();
    params.gather = gather, params.receiver_rays = rays, params.placement.overlaps = overlaps;
    probes::BakeGraph graph(scene, params);
    run_all(graph, options);
    return graph.release();
}

// Lambert 1760: irradiance under a polygon of radiance 1 that is wholly above the horizon, half the sum over its edges of the angle
// that one spans times the cosine of the normal of the plane through it.
double under_polygon(const glm::dvec3& x, const glm::dvec3& n, const std::vector<glm::dvec3>& corners) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = glm::normalize(corners[i] - x), b = glm::normalize(corners[(i + 1) % corners.size()] - x);
        const glm::dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across), angle = std::atan2(sine, glm::dot(a, b));
        if (sine > 0) sum += angle * glm::dot(n, across) / sine;
    }
    return std::fabs(sum) / 2;
}

// Mean and root mean square error at the receivers of the other faces of a cube [-2, 2]^3 whose face x = 2 has radiance 1, over the
// mean of the closed form.
std::pair<double, double> error_beside_bright_face(const probes::Bake& b) {
    const std::vector<glm::dvec3> lambda =
        lambda_of(b, [&](std::size_t ray) { return b.relight.position[ray].x > 2 - 1e-3f ? 1.0 : 0.0; });
    const std::vector<glm::dvec3> found = whole_irradiance(b, lambda);
    const std::vector<glm::dvec3> face = {{2, -2, -2}, {2, 2, -2}, {2, 2, 2}, {2, -2, 2}};
    double error = 0, squares = 0, mean = 0;
    int count = 0;
    for (int i = 0; i < b.receivers.count(); ++i) {
        const glm::dvec3 x(b.receivers.position[std::size_t(i)]), n(b.receivers.normal[std::size_t(i)]);
        if (x.x > 2 - 1e-3) continue;
        const double truth = under_polygon(x, n, face), d = found[std::size_t(i)].x - truth;
        error += std::fabs(d), squares += d * d, mean += truth, ++count;
    }
    REQUIRE(count > 100);
    return {error / mean, std::sqrt(squares * count) / mean};
}

}  // namespace

TEST_CASE("fitted transport: a constant radiance is told as exactly as by IPR (9)", "[probes][fit][analytic]") {
    const Scene scene = furnished();
    const probes::Bake fitted = bake_of(scene, probes::Gather::fitted, {}, 64), published = bake_of(scene, probes::Gather::interpolated, {}, 64);
    REQUIRE(fitted.transport.fitted);
    REQUIRE_FALSE(published.transport.fitted);
    REQUIRE(fitted.receivers.count() == published.receivers.count());
    int seen = 0;
    for (int i = 0; i < fitted.receivers.count(); ++i) {
        INFO("receiver " << i);
        const double told = double(probes::told_share(published, i));
        CHECK(std::fabs(double(probes::told_share(fitted, i)) - told) <= 2e-6);
        seen += told > 0.5 ? 1 : 0;
    }
    CHECK(seen > fitted.receivers.count() / 2);
    CHECK(fitted.alpha != published.alpha);
    check_sound(fitted);
}

TEST_CASE("fitted transport: beside a bright face it errs less than half as much as IPR (9)", "[probes][fit][analytic]") {
    const Scene scene = empty_room();
    const auto [fitted, fitted_rms] = error_beside_bright_face(bake_of(scene, probes::Gather::fitted));
    const auto [published, published_rms] = error_beside_bright_face(bake_of(scene, probes::Gather::interpolated));
    INFO(fitted << " " << fitted_rms << " for " << published << " " << published_rms);
    CHECK(published < 0.2);  // neither is nonsense
    CHECK(fitted < 0.5 * published);
    CHECK(fitted_rms < 0.5 * published_rms);
}

TEST_CASE("fitted transport: the same bits on every instruction set, on any number of threads", "[probes][fit][bits]") {
    const Scene scene = furnished();
    RunOptions options;
    options.isa = Isa::scalar, options.threads = 1;
    const probes::Bake expected = bake_of(scene, probes::Gather::fitted, options, 64, 3);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            if (threads == 1 && isa == Isa::scalar) continue;
            options.isa = isa, options.threads = threads;
            INFO(isa_name(isa) << ", " << threads << " threads");
            CHECK(bake_of(scene, probes::Gather::fitted, options, 64, 3).alpha == expected.alpha);
        }
}

TEST_CASE("fitted transport: rays that ask probes in their own direction, or weigh by their length, are interpolated", "[probes][fit]") {
    probes::BakeParams params;
    params.gather = probes::Gather::fitted;
    CHECK(probes::transport_params(params, true).fitted);
    CHECK(probes::transport_params(params, false).fitted);
    for (const probes::Escapes e : {probes::Escapes::same_direction, probes::Escapes::visible_probes, probes::Escapes::all_probes}) {
        params.escapes = e;
        CHECK_FALSE(probes::transport_params(params, true).fitted);
    }
    params.escapes = probes::Escapes::sky;
    CHECK(probes::transport_params(params, true).fitted);
    params.weighting = probes::Weighting::published;
    CHECK_FALSE(probes::transport_params(params, true).fitted);
}
