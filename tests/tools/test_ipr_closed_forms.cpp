// The run time against closed forms, to the error that the ladder of its bake predicts receiver by receiver (probe_ladder_steps.h):
// the inside of a sphere that emits Y_lm, and a closed cube of six reflectances.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/host_math.h"
#include "core/sh.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/run_loop.h"
#include "tests/gi/probe_bakes.h"
#include "tools/experiments/probe_ladder_steps.h"

using namespace plumb;
using namespace plumb::cli;
using namespace plumb::test;

namespace {

// Red channel of the places' irradiance, by receiver, after one update or all rounds.
struct Chain {
    probes::RunData data;
    std::vector<std::int32_t> probe_level, cluster_level;
    Image4 direct, black, before, radiance, lambda, basis, irradiance, lightmap;

    probes::UpdateBuffers buffers(const probes::Bake& bake, const probes::HitSurfaces& hits) {
        data = probes::run_data(bake);
        probe_level.assign(std::size_t(data.probes), 0), cluster_level.assign(data.clusters.size(), 0);
        direct = Image4(hits.surface.width, hits.surface.height), black = Image4(data.lightmap_size.x, data.lightmap_size.y);
        probes::UpdateBuffers b;
        b.data = &data, b.harmonics = &bake.harmonics, b.weights = &bake.relight_weights;
        b.probe_level = &probe_level, b.cluster_level = &cluster_level;
        b.counts.rays[0] = bake.relight.rays, b.counts.coefficients[0] = bake.coefficients();
        b.surface = &hits.surface, b.emitted = &hits.emitted, b.place = &hits.place, b.direct = &direct;
        b.last_lightmap = &black, b.read_lambda = &lambda, b.read_basis = &basis;
        b.radiance = &radiance, b.lambda = &lambda, b.basis = &basis, b.irradiance = &irradiance, b.lightmap = &lightmap;
        return b;
    }
    double at(int receiver) const { return irradiance.texels[std::size_t(data.place_of[std::size_t(receiver)])].x; }
};

// The ladder of a bake under a given radiance; truth: of each receiver, W/m2.
struct Predicted {
    CheckedReceivers checked;
    LadderSteps steps;

    double error(std::size_t i) const {
        double sum = 0;
        for (const std::vector<double>& added : steps.added) sum += added[i];
        return sum;
    }
};
Predicted predicted(const LadderWorld& world, const Radiance& radiance, const probes::Bake& b, int most,
                    const std::function<double(int)>& truth) {
    Predicted p;
    p.checked = check_receivers(world, radiance, b.receivers, {most, 64, 1}, b.params.receiver_rays, b.params.distribution, {});
    for (std::size_t i = 0; i < p.checked.index.size(); ++i) p.checked.truth[i] = truth(p.checked.index[i]);
    const LadderTransport transport = transport_in_double(world, p.checked, b.placement.probes, b.radius.radius_m, b.supports.overlaps, b.transport, {});
    const ProbeLight light = probe_light(world, radiance, b.placement.probes, b.relight_directions, b.transport.escape, {});
    const ProbeLight fine = probe_light(world, radiance, b.placement.probes, probes::relight_directions(2048), b.transport.escape, {});
    const std::vector<double> many = lambda_in_double(fine, probes::relight_weights(fine.directions, 2048), {});
    p.steps = steps_of(p.checked, transport, b, many, lambda_in_double(light, b.relight_weights, {}),
                       lambda_in_float(light, b.relight_weights, b.params.degree, {}));
    return p;
}

double rms(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v * v;
    return std::sqrt(sum / double(values.size()));
}

}  // namespace

TEST_CASE("probes: inside of a sphere that emits Y_lm indirect irradiance is 0, to the error that the ladder predicts", "[probes][analytic]") {
    // The form factor between two points of a sphere is 1 / its area: irradiance is pi times the mean of radiance, of Y_lm 0.
    const Scene scene = inside_of_ball(24);
    std::array<double, 2> worst{};
    for (const int rays : {64, 1024}) {
        probes::BakeParams params = small();
        params.placement.count = 8, params.placement.overlaps = 3, params.relight_rays = 512, params.receivers_per_m2 = 8, params.receiver_rays = rays;
        probes::BakeGraph graph(scene, params);
        run_all(graph);
        const probes::Bake& b = graph.bake();
        const LadderWorld world(scene, Rays::exact);
        for (const glm::ivec2 lm : {glm::ivec2(0, 0), glm::ivec2(1, 0), glm::ivec2(2, 1), glm::ivec2(3, -2)}) {
            const std::size_t j = std::size_t(lm.x * (lm.x + 1) + lm.y);
            const auto y = [&](const glm::vec3& p) { return sh::basis(glm::normalize(glm::dvec3(p)))[j]; };
            const Radiance radiance = [&](const RayEnd& end) { return end.found && end.front ? y(end.position) : 0; };
            const double truth = lm.x == 0 ? host::pi * std::sqrt(1 / (4 * host::pi)) : 0;

            probes::HitSurfaces hits = probes::hit_surfaces(scene, b, {});
            for (std::size_t i = 0; i < hits.emitted.size(); ++i) {
                hits.emitted.texels[i] = glm::vec4(float(hits.surface.texels[i].w != 0 ? y(glm::vec3(hits.position.texels[i])) : 0));
                hits.surface.texels[i] = glm::vec4(0, 0, 0, hits.surface.texels[i].w);
            }
            Chain chain;
            probes::update(chain.buffers(b, hits), {});

            const Predicted p = predicted(world, radiance, b, 512, [&](int) { return truth; });
            // pi times the root of the mean of Y^2, which is 1 / (4 pi): what irradiance would be were all light of one sign.
            const double scale = host::pi / std::sqrt(4 * host::pi);
            std::vector<double> error;
            double off = 0;
            for (std::size_t i = 0; i < p.checked.index.size(); ++i) {
                error.push_back(chain.at(p.checked.index[i]) - truth);
                off = std::max(off, std::fabs(error.back() - p.error(i)));
            }
            CAPTURE(rays, lm.x, lm.y, rms(error) / scale, off / scale);
            CHECK(off < 2e-5 * scale);  // floats' sums of 512 rays: measured 3e-6
            CHECK(rms(error) < 0.1 * scale);
            if (lm.x > 0) worst[rays == 1024] = std::max(worst[rays == 1024], rms(error) / scale);
        }
    }
    CAPTURE(worst[0], worst[1]);
    CHECK(worst[1] < worst[0] / 2);  // what these harmonics lose is the directions between rays, not the degree
    CHECK(worst[0] > 1e-3);      // the ladder has something to predict
}

// ---- A cube -------------------------------------------------------------------------------------------------------------

namespace {

constexpr std::array<float, 6> six = {0.2f, 0.7f, 0.5f, 0.3f, 0.6f, 0.4f};  // of faces -x, +x, -y, +y, -z, +z; -y emits 1
constexpr int emitter = 2;

int face_of(const glm::dvec3& p, double half) {
    for (int c = 0; c < 3; ++c)
        for (int side = 0; side < 2; ++side)
            if (std::fabs(p[c] - (side ? half : -half)) < 1e-4 * half) return 2 * c + side;
    FAIL("not on a face");
    return -1;
}

// Lambert's formula: from a point with this normal to a polygon that lies in front of it.
double point_to_polygon(const glm::dvec3& at, const glm::dvec3& normal, const std::array<glm::dvec3, 4>& corners) {
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const glm::dvec3 a = glm::normalize(corners[k] - at), b = glm::normalize(corners[(k + 1) % 4] - at), c = glm::cross(a, b);
        const double s = std::sqrt(glm::dot(c, c));
        if (s > 0) sum += std::atan2(s, glm::dot(a, b)) * glm::dot(c / s, normal);
    }
    return std::fabs(sum) / (2 * host::pi);
}

// Radiosity of n x n patches a face of the unit cube, by collocation at their middles with exact form factors.
struct Radiosity {
    int n;
    std::vector<double> irradiance, radiosity;  // [face][row][column]

    std::size_t at(int face, double u, double v) const {
        const auto cell = [&](double x) { return std::clamp(int((x + 0.5) * n), 0, n - 1); };
        return std::size_t((face * n + cell(v)) * n + cell(u));
    }
    static glm::dvec3 point(int face, double u, double v) {
        glm::dvec3 p(0);
        p[face / 2] = face % 2 ? 0.5 : -0.5, p[(face / 2 + 1) % 3] = u, p[(face / 2 + 2) % 3] = v;
        return p;
    }
    double mean(const std::vector<double>& values, int face) const {
        double sum = 0;
        for (int i = 0; i < n * n; ++i) sum += values[std::size_t(face * n * n + i)] / (n * n);
        return sum;
    }
    Radiosity(int patches, const std::array<float, 6>& rho) : n(patches) {
        const int count = 6 * n * n;
        std::vector<double> factor(std::size_t(count) * std::size_t(count), 0.0);
        const auto edge = [&](int k) { return double(k) / n - 0.5; };
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j) {
                const int f = i / (n * n), g = j / (n * n), x = i % n, y = i / n % n, s = j % n, t = j / n % n;
                if (f == g) continue;
                glm::dvec3 normal(0);
                normal[f / 2] = f % 2 ? -1 : 1;
                factor[std::size_t(i) * std::size_t(count) + std::size_t(j)] =
                    point_to_polygon(point(f, (edge(x) + edge(x + 1)) / 2, (edge(y) + edge(y + 1)) / 2), normal,
                                     {point(g, edge(s), edge(t)), point(g, edge(s + 1), edge(t)), point(g, edge(s + 1), edge(t + 1)), point(g, edge(s), edge(t + 1))});
            }
        irradiance.assign(std::size_t(count), 0), radiosity = irradiance;
        for (int round = 0; round < 80; ++round) {
            for (int i = 0; i < count; ++i) {
                const int f = i / (n * n);
                radiosity[std::size_t(i)] = (f == emitter ? 1 : 0) + double(rho[std::size_t(f)]) * irradiance[std::size_t(i)];
            }
            for (int i = 0; i < count; ++i) {
                double sum = 0;
                for (int j = 0; j < count; ++j) sum += factor[std::size_t(i) * std::size_t(count) + std::size_t(j)] * radiosity[std::size_t(j)];
                irradiance[std::size_t(i)] = sum;
            }
        }
    }
};

Scene cube(const std::array<float, 6>& rho) {
    Scene scene = empty_room(0.5f);
    scene.materials.resize(6);
    for (int f = 0; f < 6; ++f) scene.materials[std::size_t(f)].reflectance = glm::vec3(rho[std::size_t(f)]);
    scene.materials[emitter].emission = glm::vec3(1);
    Mesh& mesh = scene.meshes[0];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::uvec3 c = mesh.triangles[t];
        mesh.material[t] = face_of((glm::dvec3(mesh.vertices[c.x].position) + glm::dvec3(mesh.vertices[c.y].position) + glm::dvec3(mesh.vertices[c.z].position)) / 3.0, 0.5);
    }
    return scene;
}

}  // namespace

TEST_CASE("probes: a closed cube of six reflectances against its continuous solution, to the error that the ladder predicts", "[probes][analytic]") {
    // Of one reflectance 0.5 face means are 1.1044, 0.1712, 0.1811 (emitter, opposite, side): the solver that six are held against.
    std::array<float, 6> equal{};
    equal.fill(0.5f);
    const Radiosity known(12, equal);
    CHECK(known.mean(known.radiosity, emitter) == Approx(1.1044).epsilon(0.003));
    CHECK(known.mean(known.radiosity, emitter + 1) == Approx(0.1712).epsilon(0.003));
    CHECK(known.mean(known.radiosity, 0) == Approx(0.1811).epsilon(0.003));
    constexpr double of_solver = 0.003;

    for (const bool several : {false, true}) {
        const std::array<float, 6>& rho = several ? six : equal;
        const Radiosity solved(12, rho);
        const Scene scene = cube(rho);
        probes::BakeParams params = small();
        params.receivers_per_m2 = 300, params.relight_rays = 512, params.placement.count = 24, params.placement.overlaps = 3;
        probes::BakeGraph graph(scene, params);
        run_all(graph);
        const probes::Bake& b = graph.bake();
        const probes::HitSurfaces hits = probes::hit_surfaces(scene, b, {});
        Chain chain;
        Image4 before;
        probes::RunParams run;
        run.tolerance = 1e-5f;
        (void)probes::converge(chain.buffers(b, hits), run, {}, before);

        // Each round adds the ladder's error under the light that is there, and brings what others have of it by reflection.
        const LadderWorld world(scene, Rays::exact);
        const auto place = [&](const glm::dvec3& p) {
            const int f = face_of(p, 0.5);
            return solved.at(f, p[(f / 2 + 1) % 3], p[(f / 2 + 2) % 3]);
        };
        const Radiance radiance = [&](const RayEnd& end) { return end.found && end.front ? solved.radiosity[place(end.position)] / host::pi : 0; };
        const auto irradiance = [&](int receiver) { return solved.irradiance[place(glm::dvec3(b.receivers.position[std::size_t(receiver)]))]; };
        const Predicted p = predicted(world, radiance, b, b.receivers.count(), irradiance);
        std::array<double, 6> mean{}, truth{}, step{}, count{};
        double all = 0;
        for (std::size_t i = 0; i < p.checked.index.size(); ++i) {
            const int receiver = p.checked.index[i];
            const std::size_t f = std::size_t(face_of(glm::dvec3(b.receivers.position[std::size_t(receiver)]), 0.5));
            mean[f] += chain.at(receiver), truth[f] += irradiance(receiver), step[f] += p.error(i), count[f] += 1;
            all += irradiance(receiver) / double(p.checked.index.size());
        }
        // e = step + F rho e of faces, F = 1/5 to rounding: 0.1998 to the opposite one, 0.2000 to a side.
        std::array<double, 6> expected{};
        for (int round = 0; round < 80; ++round) {
            const std::array<double, 6> last = expected;
            for (std::size_t f = 0; f < 6; ++f) {
                expected[f] = step[f] / count[f];
                for (std::size_t g = 0; g < 6; ++g) expected[f] += g == f ? 0 : 0.2 * double(rho[g]) * last[g];
            }
        }
        for (std::size_t f = 0; f < 6; ++f) {
            REQUIRE(count[f] > 100);
            const double error = (mean[f] - truth[f]) / count[f];
            CAPTURE(several, f, truth[f] / count[f], error, step[f] / count[f], expected[f]);
            CHECK(std::fabs(error - expected[f]) < 3 * of_solver * all);
            CHECK(std::fabs(error) < 0.05);  // of what the emitter sends
        }
    }
}
