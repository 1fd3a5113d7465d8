// plumb experiment probe-ladder: the truth, each step between it and the run time, and costs, where the answer is known.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "tests/gi/random_scene.h"
#include "tools/experiments/probe_ladder.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

constexpr double pi = host::pi;

// A room of 4 x 4 x 4 m about the origin, seen from inside; with `wall` a closed wall of 0.2 m parts it.
Scene room(bool wall = false) {
    Mesh mesh;
    test::add_box(mesh, glm::vec3(-2), glm::vec3(2), 0, true);
    if (wall) test::add_box(mesh, {-0.1f, -2, -2}, {0.1f, 2, 2}, 0);
    Scene scene;
    scene.materials.resize(1);
    scene.meshes = {mesh};
    return scene;
}

probes::BakeParams small(int count) {
    probes::BakeParams p;
    p.placement.overlaps = 10, p.placement.least = 8, p.receiver_rays = 512;
    p.receivers_per_m2 = 4, p.receiver_rays = 128;
    p.placement.count = count, p.placement.least = 1;
    return p;
}

probes::Bake bake(const Scene& scene, const probes::BakeParams& params) {
    probes::BakeGraph graph(scene, params);
    graph::run(graph.nodes(), {});
    return graph.bake();
}

// Everything that steps_of() needs, of one bake and one radiance.
struct Subject {
    Subject(const Scene& scene, const probes::BakeParams& params, const std::function<Radiance(const probes::Bake&)>& radiance)
        : world(scene, params.rays),
          made(bake(scene, params)),
          light(radiance(made)),
          checked(check_receivers(world, light, made.receivers, {100, 4096, 1}, params.receiver_rays, params.distribution, {})),
          transport(transport_in_double(world, checked, made.placement.probes, made.radius.radius_m, params.placement.overlaps,
                                        made.transport, {})),
          seen(probe_light(world, light, made.placement.probes, probes::relight_directions(4096), made.transport.escape, {})),
          many(lambda_in_double(seen, probes::relight_weights(seen.directions, 4096), {})) {}

    LadderErrors errors(const Buffer<float>& weights) const {
        return errors_of(checked, steps_of(checked, transport, made, many, lambda_in_double(seen, weights, {}),
                                           lambda_in_float(seen, weights, made.params.degree, {})));
    }
    LadderErrors errors() const { return errors(probes::relight_weights(seen.directions, made.params.relight_rays)); }

    LadderWorld world;
    probes::Bake made;
    Radiance light;
    CheckedReceivers checked;
    LadderTransport transport;
    ProbeLight seen;
    std::vector<double> many;
};

Radiance constant(double l) {
    return [=](const RayEnd& end) { return end.found && end.front ? l : 0.0; };
}

// Irradiance under a parallel rectangle of radiance 1 at height h, its corners at (a0, b0) and (a1, b1) as seen from below:
// pi times the form factor of a differential area, one right-angled corner after the other (Howell, B-3).
double under_rectangle(double h, double a0, double a1, double b0, double b1) {
    const auto corner = [&](double a, double b) {
        const double x = a / h, y = b / h, s = std::sqrt(1 + x * x), t = std::sqrt(1 + y * y);
        return (x / s * host::atan(y / s) + y / t * host::atan(x / t)) / 2;
    };
    return corner(a1, b1) - corner(a0, b1) - corner(a1, b0) + corner(a0, b0);
}

}  // namespace

TEST_CASE("probe-ladder: the truth is a closed form's, within its uncertainty", "[probe_ladder][analytic]") {
    const Scene scene = room();
    const LadderWorld world(scene, Rays::exact);
    const probes::Bake made = bake(scene, small(1));
    const Radiance ceiling = [](const RayEnd& end) { return end.found && end.position.y > 1.9999f ? 1.0 : 0.0; };
    const CheckedReceivers c =
        check_receivers(world, ceiling, made.receivers, {400, 8192, 1}, 1, probes::Distribution::cosine, {});
    int on_floor = 0;
    double squares = 0, uncertainty = 0;
    for (int i = 0; i < c.count(); ++i) {
        const glm::vec3 p(c.receivers.position[std::size_t(i)]), n(c.receivers.normal[std::size_t(i)]);
        if (n.y < 0.9f) continue;
        ++on_floor;
        const double exact = under_rectangle(4, -2 - p.x, 2 - p.x, -2 - p.z, 2 - p.z);
        CHECK(exact > 0.1);
        squares += (c.truth[std::size_t(i)] - exact) * (c.truth[std::size_t(i)] - exact);
        uncertainty += c.uncertainty[std::size_t(i)] * c.uncertainty[std::size_t(i)];
    }
    REQUIRE(on_floor > 30);
    // Of two halves the root mean square difference is the standard error's twofold; sets that are uniform do better together.
    CHECK(std::sqrt(squares) < 1.5 * std::sqrt(uncertainty));
    // Of a step, sets that are uniform know the integral to about N^(-3/4).
    CHECK(std::sqrt(squares / on_floor) < pi * 1.2e-3);
    CHECK(uncertainty > 0);
}

TEST_CASE("probe-ladder: constant radiance in a closed room is pi L at every step", "[probe_ladder][analytic]") {
    for (const int degree : {0, 3, 7}) {
        probes::BakeParams params = small(3);
        params.degree = degree;
        const Subject s(room(), params, [](const probes::Bake&) { return constant(2); });
        for (int i = 0; i < s.checked.count(); ++i) CHECK(s.checked.truth[std::size_t(i)] == Approx(2 * pi).epsilon(1e-12));
        CHECK(s.checked.relative_uncertainty() < 1e-12);
        const LadderErrors e = s.errors();
        INFO("degree " << degree);
        CHECK(e.black == 0);
        CHECK(e.step_rms[step_rays] < 1e-6);
        CHECK(e.step_rms[step_unseen] < 1e-6);
        CHECK(e.step_rms[step_degree] < 1e-6);
        CHECK(e.step_rms[step_relight] < 1e-6);
        CHECK(e.step_rms[step_rounding] < 1e-5);  // 128 roundings and 512
        CHECK(e.step_rms[step_rounding] > 0);
        // 128 rays integrate constants times harmonics to degree 7 exactly, 64 to degree 4 alone.
        CHECK(s.errors(probes::relight_weights(s.seen.directions, 128)).step_rms[step_relight] < 1e-6);
        const double at_64 = s.errors(probes::relight_weights(s.seen.directions, 64)).step_rms[step_relight];
        CHECK((degree <= 4 ? at_64 < 1e-6 : at_64 > 1e-3));
        // With 4 pi / N the first coefficient alone is right.
        const double equal = s.errors(equal_weights(512)).step_rms[step_relight];
        // The truth is its mean everywhere: over itself plus the mean, errors are half of those over the mean.
        const LadderErrors by_equal = s.errors(equal_weights(512));
        CHECK(by_equal.step_local[step_relight] == Approx(equal / 2).margin(1e-9));
        CHECK(by_equal.local == Approx(by_equal.rms / 2).margin(1e-9));
        if (degree == 0) CHECK(equal < 1e-6);
        if (degree == 7) CHECK((equal > 0.002 && equal < 0.03));  // gi/probes/README.md: 2 %
    }
}

TEST_CASE("probe-ladder: a field of degree 4 is exact from degree 4 on, and better by each degree before",
          "[probe_ladder][analytic]") {
    // As the one probe sees it: radiance is a polynomial of the direction from there.
    const auto of_degree_4 = [](const probes::Bake& b) -> Radiance {
        const glm::dvec3 probe(glm::vec3(b.placement.probes[0]));
        return [=](const RayEnd& end) {
            const glm::dvec3 v = glm::dvec3(end.position) - probe, d = v / std::sqrt(glm::dot(v, v));
            return 3 + d.x + 0.6 * d.x * d.y + 0.4 * d.z * (5 * d.z * d.z - 3) + 0.8 * d.x * d.y * d.z * d.z;
        };
    };
    double before = 1;
    for (int degree = 0; degree <= 7; ++degree) {
        probes::BakeParams params = small(1);
        params.degree = degree;
        const Subject s(room(), params, of_degree_4);
        const LadderErrors e = s.errors();
        INFO("degree " << degree);
        // 512 rays: 4 + 7 is below 14.
        CHECK(e.step_rms[step_relight] < 1e-6);
        CHECK(e.step_rms[step_unseen] < 1e-6);
        if (degree < 4) {
            CHECK(e.step_rms[step_degree] > 1e-3);
            CHECK(e.step_rms[step_degree] < before);
        } else {
            CHECK(e.step_rms[step_degree] < 1e-6);
        }
        before = e.step_rms[step_degree];
    }
}

TEST_CASE("probe-ladder: steps add up to the error", "[probe_ladder]") {
    const auto stripes = [](const probes::Bake&) -> Radiance {
        return [](const RayEnd& end) { return end.position.x > 0.3f ? 4.0 : std::fabs(double(end.position.z)); };
    };
    probes::BakeParams params = small(4);
    params.singular_values = 4, params.by_size_only = true, params.relight_rays = 64, params.degree = 4;
    const Subject s(room(true), params, stripes);
    const Buffer<float> w = probes::relight_weights(s.seen.directions, 64);
    const LadderSteps steps =
        steps_of(s.checked, s.transport, s.made, s.many, lambda_in_double(s.seen, w, {}), lambda_in_float(s.seen, w, 4, {}));
    const LadderErrors e = errors_of(s.checked, steps);
    for (std::size_t i = 0; i < steps.value.size(); ++i) {
        double sum = s.checked.truth[i];
        for (const std::vector<double>& added : steps.added) sum += added[i];
        CHECK(sum == Approx(steps.value[i]).margin(1e-12));
    }
    double bias = 0;
    for (const double b : e.step_bias) bias += b;
    CHECK(bias == Approx(e.bias).margin(1e-12));
    // Each of them is there; the least is rounding.
    for (const double rms : e.step_rms) CHECK(rms > 0);
    CHECK(e.step_rms[step_rounding] < 1e-4);
    CHECK(e.rms > e.step_rms[step_rounding]);
}

TEST_CASE("probe-ladder: receivers behind a closed wall are black though lit", "[probe_ladder]") {
    const Subject s(room(true), small(1), [](const probes::Bake&) { return constant(1); });
    const bool right = s.made.placement.probes[0].x > 0;
    int lit = 0, there = 0;
    for (int i = 0; i < s.checked.count(); ++i) {
        if (!(s.checked.truth[std::size_t(i)] > 0.01 * s.checked.mean())) continue;
        ++lit;
        there += (s.checked.receivers.position[std::size_t(i)].x > 0) != right ? 1 : 0;
    }
    REQUIRE(there > 20);
    REQUIRE(there < lit);
    CHECK(s.errors().black == Approx(double(there) / lit));
    CHECK(s.errors().step_bias[step_unseen] < -0.2);
}

TEST_CASE("probe-ladder: full rank loses nothing, and a cut as much as its singular values say",
          "[probe_ladder][IPR 3.2.4.2]") {
    probes::BakeParams params = small(3);
    params.degree = 2, params.singular_values = 32, params.by_size_only = true, params.cluster_receivers = 4096;
    const probes::Bake b = bake(room(), params);
    REQUIRE(b.clusters.clusters.size() == 1);
    REQUIRE(b.clusters.clusters[0].rank == 27);  // 3 probes of 9 coefficients
    // |A - A_k|_F^2 is the sum over all unit vectors of what A and A_k make of them differently.
    std::vector<std::vector<double>> whole;
    double all = 0;
    const auto unit = [&](int p, int j) {
        std::vector<double> lambda(b.placement.probes.size() * sh::max_count, 0);
        lambda[std::size_t(p * sh::max_count + j)] = 1;
        return lambda;
    };
    for (int p = 0; p < 3; ++p)
        for (int j = 0; j < 9; ++j) {
            std::vector<double> column(std::size_t(b.receivers.count()), 0);
            for (std::size_t i = 0; i < column.size(); ++i)
                for (std::size_t slot = 0; slot < std::size_t(b.supports.overlaps); ++slot)
                    if (b.supports.probe[i * std::size_t(b.supports.overlaps) + slot] == p)
                        column[i] = double(b.alpha[(i * std::size_t(b.supports.overlaps) + slot) * 9 + std::size_t(j)]);
            for (const double a : column) all += a * a;
            whole.push_back(column);
        }
    for (const int kept : {4, 8, 16, 27}) {
        double lost = 0;
        for (int p = 0; p < 3; ++p)
            for (int j = 0; j < 9; ++j) {
                const std::vector<double> cut = clustered_in_double(b, unit(p, j), kept);
                for (std::size_t i = 0; i < cut.size(); ++i) {
                    const double d = cut[i] - whole[std::size_t(p * 9 + j)][i];
                    lost += d * d;
                }
            }
        const double tail = probes::truncation_error(b.clusters, kept).frobenius;
        INFO(kept);
        if (kept < 27) {
            CHECK(tail > 1e-4);
            CHECK(std::sqrt(lost / all) == Approx(tail).epsilon(1e-4));
        } else {
            CHECK(std::sqrt(lost / all) < 1e-6);
        }
    }
    const Subject s(room(), params, [](const probes::Bake&) -> Radiance {
        return [](const RayEnd& end) { return 1 + double(end.position.x) / 4; };
    });
    CHECK(s.errors().step_rms[step_truncation] < 1e-6);
}

TEST_CASE("probe-ladder: light that surfaces send is a lamp's, with shadows", "[probe_ladder][analytic]") {
    Scene scene = room();
    test::add_box(scene.meshes[0], {-0.1f, 0.5f, -0.1f}, {0.1f, 0.6f, 0.1f}, 0);
    scene.materials[0].reflectance = {0.5f, 0.25f, 0.75f}, scene.materials[0].emission = {0.125f, 0.25f, 0};
    scene.environment.radiance = {1, 2, 3};
    Light& lamp = scene.lights.emplace_back();
    lamp.type = LightType::point, lamp.position = {0, 1, 0}, lamp.intensity = {10, 20, 30};
    const LadderWorld world(scene, Rays::exact);
    const Radiance light = direct_light(world);
    const auto luminance = [](double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const auto on_floor = [&](float x, float z) {
        RayEnd end;
        end.found = end.front = true, end.direction = {0, -1, 0};
        for (int t = 0; t < int(world.geometry.triangles.size()); ++t) {
            const glm::uvec3 c = world.geometry.triangles[std::size_t(t)];
            const glm::vec3 a = world.geometry.vertices[c.x].position, u = world.geometry.vertices[c.y].position - a,
                            v = world.geometry.vertices[c.z].position - a;
            if (a.y != -2 || u.y != 0 || v.y != 0) continue;
            const float area = u.x * v.z - u.z * v.x;
            const glm::vec2 l{((x - a.x) * v.z - (z - a.z) * v.x) / area, (u.x * (z - a.z) - u.z * (x - a.x)) / area};
            if (l.x < 0 || l.y < 0 || l.x + l.y > 1) continue;
            end.triangle = t, end.barycentrics = l, end.position = {x, -2, z};
            return end;
        }
        FAIL("no floor");
        return end;
    };
    const double emitted = luminance(0.125, 0.25, 0) / pi;
    // Under the board its shadow; beside it I cos / d^2 = 3 I / d^3.
    CHECK(light(on_floor(0.25f, 0.5f)) == Approx(emitted).epsilon(1e-6));
    const double d = std::sqrt(3.0 * 3.0 + 1.9 * 1.9 + 1.7 * 1.7);
    CHECK(light(on_floor(1.9f, -1.7f)) == Approx(emitted + luminance(5, 5, 22.5) / pi * 3 / (d * d * d)).epsilon(1e-5));
    RayEnd end = on_floor(1.9f, -1.7f);
    end.front = false;
    CHECK(light(end) == 0);
    CHECK(light(RayEnd{}) == Approx(luminance(1, 2, 3)).epsilon(1e-6));
}

TEST_CASE("probe-ladder: a lookup of a linear lightmap is linear", "[probe_ladder][analytic]") {
    const Scene scene = room();
    const LadderWorld world(scene, Rays::exact);
    probes::BakeParams params = small(1);
    const probes::Bake coarse = bake(scene, params);
    params.receivers_per_m2 = 37;
    const probes::Bake fine = bake(scene, params);
    REQUIRE(fine.receivers.count() > 4 * coarse.receivers.count());
    const auto linear = [](const glm::vec4& p) { return 3 + 0.3 * double(p.x) - 0.2 * double(p.y) + 0.1 * double(p.z); };
    std::vector<float> values;
    for (const glm::vec4& p : coarse.receivers.position) values.push_back(float(linear(p)));
    const std::vector<double> found = looked_up(world, coarse, values, fine.receivers);
    int inner = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const glm::vec4 p = fine.receivers.position[i];
        // At an edge of a wall the lookup reads what borders were extended by.
        int near_edge = 0;
        for (int a = 0; a < 3; ++a) near_edge += std::fabs(p[a]) > 1.7f ? 1 : 0;
        if (near_edge > 1) {
            CHECK(found[i] > 0);
            continue;
        }
        ++inner;
        CHECK(found[i] == Approx(linear(p)).epsilon(1e-5));
    }
    CHECK(inner > 1000);
}

TEST_CASE("probe-ladder: receivers that see too much sky are left out", "[probe_ladder]") {
    // A floor under a table: from the table's top and the floor's far corners the sky is seen, from below the table little.
    Mesh mesh;
    test::add_quad(mesh, {-1, 0, 1}, {1, 0, 1}, {-1, 0, -1}, 0);
    test::add_box(mesh, {-0.9f, 0.1f, -0.9f}, {0.9f, 0.2f, 0.9f}, 0);
    Scene scene;
    scene.materials.resize(1);
    scene.meshes = {mesh};
    scene.environment.radiance = glm::vec3(1);
    const LadderWorld world(scene, Rays::exact);
    probes::BakeParams params = small(1);
    params.receivers_per_m2 = 25;
    const probes::Bake made = bake(scene, params);
    const Radiance light = direct_light(world);
    const CheckedReceivers all =
        check_receivers(world, light, made.receivers, {1000, 256, 1}, 16, probes::Distribution::cosine, {});
    const CheckedReceivers some =
        check_receivers(world, light, made.receivers, {1000, 256, 0.5}, 16, probes::Distribution::cosine, {});
    CHECK(all.before_sky == 0);
    CHECK(all.count() == made.receivers.count());
    CHECK(some.count() + some.before_sky == all.count());
    REQUIRE(some.count() > 50);
    REQUIRE(some.before_sky > 50);
    // Surfaces send nothing: truth is the share of the sky times pi.
    for (int i = 0; i < some.count(); ++i) {
        const std::size_t at = std::size_t(some.index[std::size_t(i)]);
        CHECK(some.truth[std::size_t(i)] <= pi * 0.5 + 1e-9);
        CHECK(some.truth[std::size_t(i)] == all.truth[at]);
        CHECK(some.receivers.position[std::size_t(i)] == made.receivers.position[at]);
        CHECK(some.radiance[std::size_t(i) * 16 + 5] == all.radiance[at * 16 + 5]);
    }
    scene.meshes[0].triangles.resize(2), scene.meshes[0].material.resize(2);
    const LadderWorld open(scene, Rays::exact);
    const probes::Bake floor = bake(scene, params);
    CHECK_THROWS_AS(check_receivers(open, light, floor.receivers, {9, 64, 0.5}, 1, probes::Distribution::cosine, {}),
                    InputError);
}

TEST_CASE("probe-ladder: where a curve flattens, and what no setting beats", "[probe_ladder]") {
    // Error as 1 / cost pays to the end; as cost^-1/2 never.
    CHECK(flat_from({{1, 8}, {2, 4}, {4, 2}, {8, 1}}) == 3);
    CHECK(flat_from({{1, 8}, {4, 4}, {16, 2}}) == 0);
    CHECK(flat_from({{1, 8}, {2, 4}, {4, 3}, {8, 2.5}}) == 1);
    // A rung that is worse than one before is stepped over.
    CHECK(flat_from({{1, 8}, {2, 9}, {4, 2}, {8, 2}}) == 2);
    CHECK(flat_from({}) == -1);
    CHECK(on_front({{1, 5}, {2, 3}, {2, 4}, {3, 3}, {4, 1}}) == std::vector<bool>{true, true, false, false, true});
    CHECK(on_front({{1, 5}, {1, 5}}) == std::vector<bool>{true, true});
}

TEST_CASE("probe-ladder: a scene without light is refused", "[probe_ladder][refusals]") {
    LadderRequest request;
    request.check = {8, 64, 1}, request.axes = {"degree"};
    const Scene scene = room();
    CHECK_THROWS_AS(climb(scene, small(1), request, {}, [](const std::string&) {}), InputError);
}
