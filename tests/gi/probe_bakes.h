// Whole bakes for tests: small scenes, their bakes, and what the run time makes of one, in double.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/content_hasher.h"
#include "core/host_math.h"
#include "gi/probes/bake.h"
#include "gi/probes/converge.h"
#include "random_scene.h"

namespace plumb::test {

inline Scene scene_of(Mesh mesh) {
    Scene scene;
    scene.materials.resize(2);
    mesh.material.resize(mesh.triangles.size(), 0);
    scene.meshes = {std::move(mesh)};
    return scene;
}

// The inside of a cube around the origin.
inline Scene empty_room(float half = 2) {
    Mesh mesh;
    add_box(mesh, glm::vec3(-half), glm::vec3(half), 0, true);
    return scene_of(mesh);
}

// A room with a box in it, which stands in the floor or above it.
inline Scene furnished(float half = 2, float foot = -0.9f) {
    Mesh mesh;
    add_box(mesh, glm::vec3(-half), glm::vec3(half), 0, true);
    add_box(mesh, half * glm::vec3(-0.3f, foot, -0.3f), half * glm::vec3(0.4f, -0.2f, 0.3f), 1);
    return scene_of(mesh);
}

// The inside of a ball of triangles by longitude and latitude, fronts inwards.
inline Scene inside_of_ball(int rings) {
    Mesh mesh;
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i <= 2 * rings; ++i) {
            const double theta = host::pi * j / rings, phi = host::pi * i / rings;
            const glm::dvec3 p(host::sin(theta) * host::cos(phi), host::cos(theta), host::sin(theta) * host::sin(phi));
            mesh.vertices.push_back({glm::vec3(2.0 * p), float(i) / float(2 * rings), glm::vec3(-p), float(j) / float(rings)});
        }
    const auto at = [&](int i, int j) { return unsigned(j * (2 * rings + 1) + i); };
    for (int j = 0; j < rings; ++j)
        for (int i = 0; i < 2 * rings; ++i) {
            if (j > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (j < rings - 1) mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    return scene_of(mesh);
}

inline probes::BakeParams small() {
    probes::BakeParams p;
    p.placement.overlaps = 10, p.placement.least = 8;
    p.receivers_per_m2 = 9, p.relight_rays = 256, p.receiver_rays = 128;
    p.placement.count = 6;
    return p;
}

inline std::vector<graph::NodeRun> run_all(probes::BakeGraph& graph, RunOptions options = {}) {
    graph::RunWith with;
    with.options = options;
    return graph::run(graph.nodes(), with);
}

// Of all that a bake made but what has a unit of length: the same for a scene that is 2^n times as large.
inline std::uint64_t hash_without_lengths(const probes::Bake& b) {
    ContentHasher h;
    h.add_all(b.atlas.uv), h.add_all(b.atlas.chart);
    h.add_all(b.receivers.normal), h.add_all(b.receivers.texel), h.add_all(b.receivers.triangle), h.add_all(b.receivers.border);
    h.add_all(b.supports.probe), h.add_all(b.supports.weight);
    h.add_all(b.relight.material), h.add_all(b.relight.triangle), h.add_all(b.relight.uv);
    h.add_all(b.alpha), h.add_all(b.flat.cluster_of), h.add_all(b.flat.rank), h.add_all(b.flat.u), h.add_all(b.flat.sigma_vt);
    return h.hash;
}

// What holds of every bake: finite numbers, indices that are there, lists that fit each other; a receiver is in a cluster
// exactly where a probe supports it.
inline void check_sound(const probes::Bake& b) {
    const std::size_t receivers = std::size_t(b.receivers.count()), slots = std::size_t(b.supports.overlaps);
    const std::size_t coefficients = std::size_t(b.coefficients());
    REQUIRE(receivers > 0);
    REQUIRE(b.placement.probes.size() > 0);
    REQUIRE(b.alpha.size() == receivers * slots * coefficients);
    const auto finite = [](const auto& list) { return std::all_of(list.begin(), list.end(), [](auto x) { return std::isfinite(x); }); };
    CHECK(finite(b.alpha));
    CHECK(finite(b.flat.u));
    CHECK(finite(b.flat.sigma_vt));
    CHECK(finite(b.flat.spectrum));
    CHECK(finite(b.harmonics));
    std::size_t wrong = 0, flagged = 0, outside = 0;
    for (std::size_t i = 0; i < receivers; ++i) {
        const bool supported = b.supports.probe[i * slots] >= 0;
        flagged += supported ? 0 : 1;
        wrong += supported == (b.clusters.cluster_of[i] >= 0) ? 0 : 1;
        const glm::dvec3 n(b.receivers.normal[i]), p(b.receivers.position[i]);
        wrong += std::fabs(glm::dot(n, n) - 1) < 1e-5 && std::isfinite(p.x + p.y + p.z) ? 0 : 1;
        for (std::size_t s = 0; s < slots; ++s) {
            const std::int32_t probe = b.supports.probe[i * slots + s];
            wrong += probe >= -1 && probe < std::int32_t(b.placement.probes.size()) ? 0 : 1;
            wrong += (probe < 0) <= (b.supports.weight[i * slots + s] == 0) ? 0 : 1;
            if (probe < 0)
                for (std::size_t j = 0; j < coefficients; ++j) wrong += b.alpha[(i * slots + s) * coefficients + j] == 0 ? 0 : 1;
        }
    }
    for (std::size_t k = 0; k < b.relight.material.size(); ++k) {
        const glm::vec2 uv = b.relight.uv[k];
        outside += uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1 ? 0 : 1;
    }
    CHECK(wrong == 0);
    CHECK(outside == 0);
    CHECK(std::int64_t(flagged) == b.supports.unsupported);
    std::vector<int> times(receivers, 0);
    for (const probes::Cluster& c : b.clusters.clusters)
        for (const std::int32_t i : c.receivers) ++times[std::size_t(i)];
    for (std::size_t i = 0; i < receivers; ++i) wrong += times[i] == (b.clusters.cluster_of[i] >= 0 ? 1 : 0) ? 0 : 1;
    CHECK(wrong == 0);
}

// Coefficients of probes whose rays bring what `radiance` says of each, [probe * rays + ray].
inline std::vector<glm::dvec3> lambda_of(const probes::Bake& b, const std::function<double(std::size_t)>& radiance) {
    std::vector<glm::dvec3> f;
    for (std::size_t k = 0; k < b.relight.material.size(); ++k) f.emplace_back(radiance(k));
    return probes::probe_coefficients(f, b.relight.probes, b.relight_weights, b.harmonics, b.params.degree);
}
inline std::vector<glm::dvec3> whole_irradiance(const probes::Bake& b, const std::vector<glm::dvec3>& lambda) {
    return probes::irradiance(b.supports, b.alpha, b.params.degree, lambda);
}

// The run time's rounds (converge.h) where every receiver has the direct irradiance e, every surface the reflectance rho.
class RunTime {
  public:
    RunTime(const probes::Bake& bake, double e, double rho)
        : whole_(bake, lit(bake, e, rho), probes::Transport::whole), clustered_(bake, lit(bake, e, rho), probes::Transport::clustered) {
        REQUIRE(whole_.without_receiver() == 0);
    }
    void whole_round() { whole_.round(), last_ = &whole_; }
    void clustered_round() { clustered_.round(), last_ = &clustered_; }

    const std::vector<glm::dvec3>& irradiances() const { return last_->irradiance(); }
    double mean() const { return last_->mean(); }
    double least() const { return std::min_element(irradiances().begin(), irradiances().end(), darker)->x; }
    double most() const { return std::max_element(irradiances().begin(), irradiances().end(), darker)->x; }

  private:
    static bool darker(const glm::dvec3& a, const glm::dvec3& b) { return a.x < b.x; }
    static probes::Relit lit(const probes::Bake& bake, double e, double rho) {
        const std::size_t rays = bake.relight.material.size();
        probes::Relit relit{std::vector<glm::dvec3>(rays, glm::dvec3(0)), std::vector<glm::dvec3>(rays, glm::dvec3(rho)),
                            std::vector<glm::dvec3>(rays, glm::dvec3(e))};
        for (std::size_t k = 0; k < rays; ++k)
            if (bake.relight.material[k] < 0) relit.reflectance[k] = relit.direct[k] = glm::dvec3(0);
        return relit;
    }

    probes::RunTime whole_, clustered_;
    const probes::RunTime* last_ = &whole_;
};

}  // namespace plumb::test
