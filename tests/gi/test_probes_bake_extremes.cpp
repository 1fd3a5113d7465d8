// Whole bakes of what is small, large, flat, many, few or degenerate.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/sh.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

Mesh scaled(Mesh mesh, double factor) {
    for (Vertex& v : mesh.vertices) v.position = glm::vec3(glm::dvec3(v.position) * factor);
    return mesh;
}

// Every ray of a receiver meets something that some probe sees, of radiance 1.
void check_pi(const Bake& b) {
    const std::vector<glm::dvec3> e = whole_irradiance(b, lambda_of(b, [](std::size_t) { return 1.0; }));
    double worst = 0;
    for (const glm::dvec3& x : e) worst = std::max(worst, std::fabs(x.x / host::pi - 1));
    CHECK(worst < 2e-5);
}

}  // namespace

TEST_CASE("bake: scenes of 0.2 mm and of 2000 km have the bits of one of 2 m", "[probes][extreme][bits]") {
    // Times 2^n, every length is, and with it every product of lengths; nothing else changes.
    BakeParams params = small();
    params.lightmap_size = 64;
    const Scene scene = furnished(1);
    BakeGraph metres(scene, params);
    run_all(metres);
    check_sound(metres.bake());
    params.weighting = Weighting::published;
    BakeGraph published(scene, params);
    run_all(published);
    for (const int power : {-13, 20}) {
        const double factor = std::ldexp(1.0, power);
        const Scene other = scene_of(scaled(scene.meshes[0], factor));
        params.weighting = Weighting::none;
        BakeGraph graph(other, params);
        run_all(graph);
        const Bake &a = metres.bake(), &b = graph.bake();
        CAPTURE(power);
        REQUIRE(a.receivers.count() == b.receivers.count());
        CHECK(hash_without_lengths(a) == hash_without_lengths(b));
        bool places = true;
        for (std::size_t i = 0; i < std::size_t(a.receivers.count()); ++i)
            places = places && glm::dvec3(a.receivers.position[i]) * factor == glm::dvec3(b.receivers.position[i]);
        for (std::size_t i = 0; i < a.placement.probes.size(); ++i)
            places = places && glm::dvec3(a.placement.probes[i]) * factor == glm::dvec3(b.placement.probes[i]);
        CHECK(places);
        CHECK(a.radius.radius_m * factor == b.radius.radius_m);
        // The published weight of rays by their length does depend on the unit.
        params.weighting = Weighting::published;
        BakeGraph weighted(other, params);
        run_all(weighted);
        CHECK(hash_without_lengths(published.bake()) != hash_without_lengths(weighted.bake()));
    }
}

TEST_CASE("bake: at any other scale the light is the same, to rounding", "[probes][extreme]") {
    // 1e-4 and 1e6 are no powers of two: positions are rounded, and a ray may pass a corner on the other side.
    BakeParams params = small();
    params.lightmap_size = 64;
    const Scene scene = furnished(1);
    BakeGraph metres(scene, params);
    run_all(metres);
    test::RunTime truth(metres.bake(), 1, 0.5);
    for (int round = 0; round < 20; ++round) truth.whole_round();
    for (const double factor : {1e-4, 1e6}) {
        const Scene other = scene_of(scaled(scene.meshes[0], factor));
        BakeGraph graph(other, params);
        run_all(graph);
        const Bake& b = graph.bake();
        check_sound(b);
        CHECK(b.supports.unsupported == 0);
        CHECK(b.counts().escaped == 0);
        test::RunTime rounds(b, 1, 0.5);
        for (int round = 0; round < 20; ++round) rounds.whole_round();
        CAPTURE(factor, truth.mean(), rounds.mean(), metres.bake().receivers.count(), b.receivers.count());
        CHECK(rounds.mean() == Approx(truth.mean()).epsilon(1e-3));
    }
}

TEST_CASE("bake: 300,000 receivers", "[probes][extreme]") {
    // In a closed convex room each of them has pi L of constant radiance, the first as the last.
    const Scene scene = empty_room();
    BakeParams params = small();
    params.receivers_per_m2 = 3200, params.receiver_rays = 2, params.test_rays = 2, params.relight_rays = 64, params.degree = 0;
    params.placement.count = 2, params.placement.overlaps = 2;
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    CHECK(b.receivers.count() >= 300000);
    CHECK(b.blocks() == (b.receivers.count() + block_receivers - 1) / block_receivers);
    check_sound(b);
    CHECK(b.supports.unsupported == 0);
    check_pi(b);
    // Of 4 numbers a receiver at most the clusters keep all.
    const auto lambda = lambda_of(b, [](std::size_t) { return 1.0; });
    double worst = 0;
    for (const glm::dvec3& e : clustered_irradiance(b, lambda)) worst = std::max(worst, std::fabs(e.x / host::pi - 1));
    CHECK(worst < 1e-5);
}

TEST_CASE("bake: one receiver, one probe", "[probes][extreme]") {
    Mesh quad;
    add_quad(quad, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0);
    Scene scene = scene_of(quad);
    scene.environment.radiance = glm::vec3(1);
    for (const Escapes escapes : {Escapes::same_direction, Escapes::automatic}) {
        const bool sky = escapes == Escapes::automatic;
        BakeParams params = small();
        params.receivers_per_m2 = 1, params.placement.count = 1, params.placement.least = 1, params.escapes = escapes;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        check_sound(b);
        CHECK(b.receivers.count() == 1);
        CHECK(b.placement.probes.size() == (sky ? 2 : 1));
        CHECK(b.supports.overlaps == params.placement.overlaps + (sky ? 1 : 0));
        REQUIRE(b.clusters.clusters.size() == 1);
        CHECK(b.clusters.clusters[0].rank == 1);
        CHECK(b.transport.escape == (sky ? Escape::sky : Escape::same_direction));
        // pi Y_0: all rays escape, and the probe's do as well; or the sky, in the last slot, has them all.
        const std::size_t last = std::size_t(b.supports.overlaps - 1) * std::size_t(b.coefficients());
        CHECK(b.alpha[sky ? last : 0] == Approx(std::sqrt(host::pi) / 2).epsilon(1e-4));
        CHECK(told_share(b, 0) == Approx(1).epsilon(1e-4));
        // Of rank 1 the decomposition is the row itself: its two probes', of which the first tells nothing, or its one.
        const std::size_t columns = b.clusters.clusters[0].sigma_vt.size();
        REQUIRE(columns == std::size_t(b.coefficients()) * (sky ? 2 : 1));
        for (std::size_t j = 0; j < columns; ++j) {
            const std::size_t of_sky = j - std::min(j, std::size_t(b.coefficients()));
            const double alpha = double(b.alpha[j < std::size_t(b.coefficients()) ? j : last + of_sky]);
            CHECK(double(b.clusters.u[0]) * double(b.clusters.clusters[0].sigma_vt[j]) == Approx(alpha).margin(1e-6));
        }
    }
}

TEST_CASE("bake: coplanar receivers under an open sky have no more singular values than probes", "[probes][extreme][analytic]") {
    // Every ray escapes and counts in its own direction: alpha_ij = share_i c_j, c_j the clamped cosine's, the same for all
    // receivers of a plane. P probes: rank P at most, and what is beyond is the rounding of alphas.
    Mesh quad;
    add_quad(quad, {0, 0, 0}, {0, 0, 3}, {3, 0, 0}, 0);
    Scene scene = scene_of(quad);
    scene.environment.radiance = glm::vec3(1);
    for (const int probes : {1, 3}) {
        BakeParams params = small();
        params.receivers_per_m2 = 44, params.placement.count = probes, params.placement.least = 1;
        params.by_size_only = true, params.escapes = Escapes::same_direction;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        check_sound(b);
        REQUIRE(b.receivers.count() > 350);
        REQUIRE(b.clusters.clusters.size() == 1);
        const std::vector<double>& spectrum = b.clusters.clusters[0].spectrum;
        REQUIRE(int(spectrum.size()) > probes);
        CAPTURE(probes, spectrum[0], spectrum[std::size_t(probes)]);
        CHECK(spectrum[0] > 0.1);
        CHECK(spectrum[std::size_t(probes) - 1] > 1e-4 * spectrum[0]);
        CHECK(spectrum[std::size_t(probes)] < 2e-6 * spectrum[0]);
        const auto lambda = lambda_of(b, [](std::size_t) { return 1.0; });
        const auto whole = whole_irradiance(b, lambda), clustered = clustered_irradiance(b, lambda);
        for (std::size_t i = 0; i < whole.size(); ++i) {
            CHECK(whole[i].x == Approx(host::pi).epsilon(1e-5));
            CHECK(clustered[i].x == Approx(host::pi).epsilon(1e-4));
        }
    }
}

TEST_CASE("bake: coincident quads see nothing, and there is nothing to keep", "[probes][extreme]") {
    Mesh quads;
    for (int k = 0; k < 2; ++k) add_quad(quads, {0, 0, 0}, {0, 0, 2}, {2, 0, 0}, 0);
    const Scene scene = scene_of(quads);
    BakeGraph graph(scene, small());
    run_all(graph);
    const Bake& b = graph.bake();
    check_sound(b);
    for (const float a : b.alpha) CHECK(a == 0);  // there is no sky
    for (const Cluster& c : b.clusters.clusters) {
        CHECK(c.error_published == 0);
        CHECK(c.rank <= 1);
    }
    CHECK(black_receivers(b) == b.receivers.count());
}

TEST_CASE("bake: whatever a mesh's texture coordinates are, the light is the same", "[probes][extreme][degenerate]") {
    const Scene plain = empty_room(1);
    const float infinite = std::numeric_limits<float>::infinity();
    const auto coordinates = [&](const std::function<glm::vec2(std::size_t, const Vertex&)>& of) {
        Scene scene = plain;
        for (std::size_t i = 0; i < scene.meshes[0].vertices.size(); ++i) {
            Vertex& v = scene.meshes[0].vertices[i];
            const glm::vec2 uv = of(i, v);
            v.u = uv.x, v.v = uv.y;
        }
        return scene;
    };
    // Faces are quads of four vertices in a row.
    const std::vector<std::pair<const char*, Scene>> cases = {
        {"each face the whole square", plain},
        {"none", coordinates([](std::size_t, const Vertex&) { return glm::vec2(0); })},
        {"on a line", coordinates([](std::size_t i, const Vertex&) { return glm::vec2(float(i), 0); })},
        {"an atlas of its own",
         coordinates([](std::size_t i, const Vertex& v) { return glm::vec2((v.u + 1.5f * float(i / 4 % 3)) / 5, (v.v + 1.5f * float(i / 12)) / 5); })},
        {"mirrored",
         coordinates([](std::size_t i, const Vertex& v) { return glm::vec2((1 - v.u + 1.5f * float(i / 4 % 3)) / 5, (v.v + 1.5f * float(i / 12)) / 5); })},
        {"half overlapping",
         coordinates([](std::size_t i, const Vertex& v) { return glm::vec2((v.u + 0.5f * float(i / 4 % 3)) / 5, (v.v + 0.5f * float(i / 12)) / 5); })},
        {"far outside of the square", coordinates([](std::size_t i, const Vertex& v) { return glm::vec2(1000 + v.u + 1.5f * float(i / 4), -1000 + v.v); })},
        {"stretched", coordinates([](std::size_t i, const Vertex& v) { return glm::vec2(1000 * (v.u + 1.5f * float(i / 4)), v.v); })},
        {"not finite", coordinates([&](std::size_t i, const Vertex& v) { return i == 5 ? glm::vec2(std::nanf(""), infinite) : glm::vec2(v.u, v.v); })},
        {"at the end of floats", coordinates([](std::size_t, const Vertex& v) { return 1e38f * glm::vec2(v.u, v.v); })},
    };
    for (const auto& [name, scene] : cases) {
        CAPTURE(name);
        BakeParams params = small();
        params.receivers_per_m2 = 20;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        check_sound(b);
        CHECK(b.supports.unsupported == 0);
        CHECK(b.receivers.count() >= 24 * 20 * 0.9);
        check_pi(b);
        // Radiance reaches receivers of all surfaces: a relight ray's place on the lightmap is that of a receiver.
        test::RunTime rounds(b, 1, 0.5);
        for (int round = 0; round < 30; ++round) rounds.whole_round();
        CHECK(rounds.mean() == Approx(1).epsilon(1e-4));
        CHECK(rounds.least() == Approx(1).epsilon(1e-4));
        CHECK(b.atlas.summary.meshes_kept == (name == std::string("an atlas of its own") || name == std::string("mirrored") ||
                                              name == std::string("far outside of the square") ? 1 : 0));
    }
}

TEST_CASE("bake: triangles without area and twice the same ones change no light", "[probes][extreme][degenerate]") {
    const Scene plain = empty_room(1);
    const auto with = [&](const std::function<void(Mesh&)>& change) {
        Mesh mesh = plain.meshes[0];
        change(mesh);
        return scene_of(mesh);
    };
    const std::vector<std::pair<const char*, Scene>> cases = {
        {"corners that are one vertex", with([](Mesh& m) { m.triangles.insert(m.triangles.begin(), {glm::uvec3(0, 0, 1), glm::uvec3(2)}); })},
        {"corners on a line", with([](Mesh& m) {
             const unsigned n = unsigned(m.vertices.size());
             for (const float x : {-0.5f, 0.0f, 0.5f}) m.vertices.push_back({{x, -1, 0.25f}, 0, {0, 1, 0}, 0});
             m.triangles.push_back({n, n + 1, n + 2});
         })},
        {"a needle 1e-8 m wide", with([](Mesh& m) {
             const unsigned n = unsigned(m.vertices.size());
             for (const float x : {-0.5f, 0.5f}) m.vertices.push_back({{x, -1, 0.25f}, 0, {0, 1, 0}, 0});
             m.vertices.push_back({{0.5f, -1, std::nextafterf(0.25f, 1)}, 0, {0, 1, 0}, 0});
             m.triangles.push_back({n, n + 2, n + 1});
         })},
        {"a point in the middle of the room", with([](Mesh& m) {
             const unsigned n = unsigned(m.vertices.size());
             for (int k = 0; k < 3; ++k) m.vertices.push_back({{0.1f, 0.2f, 0.3f}, 0, {0, 1, 0}, 0});
             m.triangles.push_back({n, n + 1, n + 2});
         })},
        {"normals of length 0", with([](Mesh& m) {
             for (Vertex& v : m.vertices) v.normal = glm::vec3(0);
         })},
    };
    for (const auto& [name, scene] : cases) {
        CAPTURE(name);
        BakeGraph graph(scene, small());
        run_all(graph);
        check_sound(graph.bake());
        CHECK(graph.bake().supports.unsupported == 0);
        check_pi(graph.bake());
    }
    // Each triangle twice: of receivers that lie on each other neither is in front, and both see the room.
    const Scene twice = with([](Mesh& m) {
        const std::vector<glm::uvec3> triangles = m.triangles;
        m.triangles.insert(m.triangles.end(), triangles.begin(), triangles.end());
    });
    BakeGraph graph(twice, small());
    run_all(graph);
    check_sound(graph.bake());
    check_pi(graph.bake());
}

TEST_CASE("bake: open meshes, sheets and what stands alone under a sky", "[probes][extreme][analytic]") {
    // All that is met and the sky have the radiance 1, and rays that meet nothing count in their own direction.
    const auto open = [](float ceiling) {  // without its ceiling, or with a hole in it
        Mesh mesh;
        add_box(mesh, glm::vec3(-1), glm::vec3(1), 0, true);
        std::vector<glm::uvec3> kept;
        for (const glm::uvec3& t : mesh.triangles)
            if (mesh.vertices[t.x].normal.y > -0.5f) kept.push_back(t);
        mesh.triangles = kept, mesh.material.resize(kept.size());
        if (ceiling > 0) add_quad(mesh, {-1, 1, -1}, {1, 1, -1}, {-1, 1, 1 - ceiling}, 0);
        return mesh;
    };
    Mesh sheet, both, box, ball;
    add_quad(sheet, {-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}, 0);
    add_quad(both, {-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}, 0);
    add_quad(both, {-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, 0);
    add_box(box, glm::vec3(-1), glm::vec3(1), 0);
    add_ball(ball, {0, 0, 0}, 1, 6, 0);
    for (const auto& [name, mesh] : std::vector<std::pair<const char*, Mesh>>{
             {"without ceiling", open(0)}, {"a hole in the ceiling", open(1)}, {"a sheet", sheet}, {"a sheet of two sides", both},
             {"a box", box}, {"a ball", ball}}) {
        for (const Escapes escapes : {Escapes::same_direction, Escapes::automatic}) {
            Scene scene = scene_of(mesh);
            scene.environment.radiance = glm::vec3(1);
            BakeParams params = small();
            params.receivers_per_m2 = 16, params.placement.count = 12, params.escapes = escapes;
            BakeGraph graph(scene, params);
            run_all(graph);
            const Bake& b = graph.bake();
            check_sound(b);
            CAPTURE(name, b.receivers.count(), b.counts().unseen, b.counts().back, b.counts().escaped);
            CHECK(b.transport.escape == (escapes == Escapes::automatic ? Escape::sky : Escape::same_direction));
            CHECK(b.supports.unsupported == 0);
            CHECK(b.counts().escaped > 0);
            CHECK(b.counts().back == 0);
            // Each receiver has pi times the share of its rays that some probe sees, or that escape beside one that sees as far.
            const auto e = whole_irradiance(b, lambda_of(b, [](std::size_t) { return 1.0; }));
            double worst = 0, sum = 0;
            for (int first = 0; first < b.receivers.count(); first += block_receivers) {
                const TracedBlock traced = graph.traced(first, {});
                for (int i = 0; i < traced.count; ++i) {
                    int seen = 0;
                    for (int k = 0; k < traced.rays; ++k) seen += traced.visible[std::size_t(k * traced.count + i)] != 0 ? 1 : 0;
                    const double share = double(seen) / traced.rays;
                    worst = std::max(worst, std::fabs(e[std::size_t(first + i)].x - host::pi * share)), sum += share;
                }
            }
            CAPTURE(worst, sum / b.receivers.count());
            CHECK(worst < 1e-4);
            CHECK(sum / b.receivers.count() > (escapes == Escapes::automatic ? 0.9 : 0.8));
        }
    }
}
