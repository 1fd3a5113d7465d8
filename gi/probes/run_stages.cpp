#include "gi/probes/run_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/content_hasher.h"
#include "core/parallel.h"
#include "gi/probes/bake.h"
#include "gi/probes/host_step.h"
#include "gi/probes/memory.h"
#include "gi/probes/run_params.h"
#include "gi/probes/static_scene.h"

namespace plumb::probes {

namespace {

constexpr auto step = host_step<RunParams>;

const Port bake = {"bake", "arrays", "", "of plumb bake"};
const Port lightmap = {"lightmap", "image rgba32f", "W/m2", "irradiance"};

// Of one core: exact rays, in scenes of middle size; decompositions, of each receiver; a fit, of each of its probes.
constexpr double rays_a_ms = 8000, clusters_ms = 0.035, fit_ms = 0.05;

}  // namespace

StageInfo info_run_data() {
    return step("probes.data", "IPR 3.2.5; without a twin: what a bake holds, laid out for the stages that read it", {bake},
                {{"matrix", "buffer f32", "", "Sigma V^T of each cluster"}, {"transport", "buffer f32", "", "U"}}, {"file", "window", "unasked"});
}

StageInfo info_hit_surfaces() {
    return step("probes.surfaces", "IPR 3.2.3.1, 3.3.1.1; without a twin: materials where relight rays end, when a material changes",
                {bake, {"materials", "buffer f32 x 4", "", "of the scene"}},
                {{"surface", "image rgba32f", "", "[probe][ray] reflectance"}, {"emitted", "image rgba32f", "W/(m2 sr)", "[probe][ray] radiance"}}, {"unasked"});
}

StageInfo info_rounds() {
    return step("probes.rounds", "IPR 3.3.1.5; without a twin: it runs the stages of an update until they change nothing",
                {{"surface", "image rgba32f", "", "[probe][ray]"}, {"direct", "image rgba32f", "W/m2", "[probe][ray]"}}, {lightmap},
                {"loop", "tolerance", "rounds", "feedback", "reflection", "start"});
}

StageInfo info_active() {
    return step("probes.active", "IPR 4.1.1, figure 4.2; without a twin: boxes of a few meshes against a grid",
                {bake, {"boxes", "buffer f32 x 4", "m", "of dynamic meshes"}}, {{"level", "buffer i32", "", "[place] 0 near them, else -1: not computed"}}, {});
}

StageInfo info_static_light() {
    return step("probes.static_light", "IPR 5.2.1.5; without a twin: rays from a few hundred places, when a static lamp changes",
                {bake, {"lights", "buffer f32 x 4", "m, W/sr, W/m2", "static lamps"}},
                {{"light", "buffer f32 x 4", "W/m2", "[place][direction] of lamps that what moves sees by the grid alone"}}, {"static_lamps"});
}

std::uint64_t bake_key(const Bake& b) {
    ContentHasher h;
    h.add(b.scene_hash, b.atlas.size, b.relight.probes, b.relight.rays, b.params.degree);
    h.add_all(b.atlas.uv), h.add_all(b.receivers.texel);
    h.add_all(b.relight.material), h.add_all(b.relight.uv), h.add_all(b.relight.position);
    h.add_all(b.relight_weights), h.add_all(b.harmonics);
    h.add_all(b.flat.receivers), h.add_all(b.flat.probes), h.add_all(b.flat.rank), h.add_all(b.flat.sigma_vt), h.add_all(b.flat.u);
    h.add_all(b.spatial.flat.receivers), h.add_all(b.spatial.flat.probes), h.add_all(b.spatial.flat.sigma_vt), h.add_all(b.spatial.flat.u);
    return h.hash;
}

Bundle lent(const RunData& d, const ChartedTriangles& c, const Buffer<float>& harmonics, const Buffer<float>& weights) {
    Bundle b;
    const auto list = [&](const char* name, const auto& values) { lend(b, name, {std::int64_t(values.size())}, values.data()); };
    const auto of4 = [&](const char* name, const auto& values) {
        lend(b, name, {std::int64_t(values.size()), 4}, values.empty() ? nullptr : &values[0].x);
    };
    of4("clusters", d.clusters), list("cluster_probes", d.cluster_probes), list("matrix", d.matrix), list("cluster", d.cluster);
    list("transport", d.u), list("receiver_level", d.receiver_level), list("cover", d.cover.texels);
    list("charted_of", c.charted_of), of4("corners", c.corners), list("harmonics", harmonics), list("weights", weights);
    return b;
}

ExpectedBake expected_bake(const Scene& scene, const BakeParams& p) {
    const Geometry g = flatten_static(scene);
    double area = 0;
    for (const glm::uvec3& t : g.triangles) {
        const glm::dvec3 a(g.vertices[t.x].position), u = glm::dvec3(g.vertices[t.y].position) - a, v = glm::dvec3(g.vertices[t.z].position) - a;
        const glm::dvec3 n(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
        area += std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z) / 2;
    }
    ExpectedBake e;
    const double side = double(p.lightmap_size);
    e.receivers = p.lightmap_size > 0 ? side * side / 2 : area * double(p.receivers_per_m2);
    e.rays = e.receivers * (double(p.receiver_rays) * (1 + p.placement.overlaps) + p.test_rays);
    e.ms = e.rays / rays_a_ms + e.receivers * clusters_ms;
    e.area_m2 = area;
    // A receiver's coefficients, its row of U twice, and its share of its cluster's matrix, twice: where many surfaces meet, clusters
    // have hardly more receivers than singular values, and the columns of a probe more than a receiver has.
    const double columns = (p.degree + 1) * (p.degree + 1), overlaps = p.placement.overlaps;
    e.bytes = e.receivers * 4 * (overlaps * columns + 2 * (p.singular_values + (overlaps + 1) * columns));
    if (transport_params(p, sends_light(scene.environment)).fitted) {
        glm::vec3 low, high;
        bounds(g, low, high);
        const FitSize fit{std::uint64_t(wanted_probes(glm::dvec3(high) - glm::dvec3(low), p.placement)), std::uint64_t(p.relight_rays),
                          std::uint64_t(p.placement.overlaps), p.degree};
        e.ms += e.receivers * overlaps * fit_ms;
        e.bytes += double(bytes_of_fit(fit, thread_count(0)));
    }
    return e;
}

std::string text_of(const ExpectedBake& e) {
    return fmt::format("without a bake one is made and kept: about {:.2g} receivers, at most {:.2g} million rays, some {:.2g} s of a core, "
                       "some {} of memory",
                       e.receivers, e.rays * 1e-6, e.ms * 1e-3, size_text(std::uint64_t(std::min(e.bytes, 1e18))));
}

}  // namespace plumb::probes
