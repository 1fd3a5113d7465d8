#include "gi/probes/bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/static_scene.h"

namespace plumb::probes {

AtlasParams atlas_params(const BakeParams& p) {
    AtlasParams a;
    a.receivers_per_m2 = double(p.receivers_per_m2), a.size = p.lightmap_size, a.gap = p.gap;
    a.chart_angle_deg = double(p.chart_angle);
    return a;
}

ShiftParams shift_params(const BakeParams& p) { return {p.test_rays, double(p.back_share)}; }

ClusterParams cluster_params(const BakeParams& p) {
    ClusterParams c;
    c.singular_values = p.singular_values, c.threshold = double(p.threshold);
    c.most_receivers = p.cluster_receivers, c.by_size_only = p.by_size_only;
    return c;
}

TransportParams transport_params(const BakeParams& p, bool sky) {
    TransportParams t;
    t.rays = p.receiver_rays, t.degree = p.degree, t.distribution = p.distribution;
    t.published_weight = p.weighting == Weighting::published;
    t.escape = p.escapes == Escapes::automatic ? (sky ? Escape::sky : Escape::nothing)
                                             : Escape(int(p.escapes) - 1);
    t.fitted = p.gather == Gather::fitted && !t.published_weight && (t.escape == Escape::nothing || t.escape == Escape::sky);
    t.relight_rays = p.relight_rays;
    return t;
}

bool sends_light(const Environment& e) {
    if (e.map.empty()) return e.radiance != glm::vec3(0);
    return e.radiance != glm::vec3(0) && std::any_of(e.map.texels.begin(), e.map.texels.end(), [](const glm::vec4& t) {
        return t.x != 0 || t.y != 0 || t.z != 0;
    });
}

namespace {

// Where materials are cut out by their masks, and where their normals are of a texture.
void add_masks(const Scene& scene, ContentHasher& h) {
    h.add(scene.materials.size());
    for (const Material& m : scene.materials) {
        h.add(m.alpha_cutoff, m.normal_texture, m.normal_scale);
        if (m.alpha_cutoff <= 0 && m.normal_texture < 0) continue;
        h.add(m.alpha, m.texture);
        for (const int texture : {m.alpha_cutoff > 0 ? m.texture : -1, m.normal_texture})
            if (texture >= 0) {
                const Texture& t = scene.textures.at(std::size_t(texture));
                h.add_image(t.texels);
                h.add(t.srgb, t.filter, t.wrap_u, t.wrap_v, t.mips);
            }
    }
}

// Of all that flatten_static() and scene_hash() read. A member that a mesh gets does not compile until somebody has said here
// whether they do.
std::uint64_t static_key(const Scene& scene) {
    ContentHasher h;
    for (const Mesh& mesh : scene.meshes) {
        const auto& [name, vertices, tangents, triangles, material, transform, dynamic, share] = mesh;
        if (dynamic) continue;
        h.add_all(vertices), h.add_all(tangents), h.add_all(triangles), h.add_all(material);
        h.add(vertices.size(), triangles.size(), transform, share);
    }
    add_masks(scene, h);
    return h.hash;
}

}  // namespace

std::uint64_t scene_hash(const Scene& scene, const Geometry& geometry) {
    ContentHasher h;
    h.add_all(geometry.vertices), h.add_all(geometry.triangles), h.add_all(geometry.material), h.add_all(geometry.object);
    h.add_all(geometry.tangents);
    add_masks(scene, h);
    return h.hash;
}

std::uint64_t scene_hash(const Scene& scene) {
    static std::mutex mutex;
    static std::optional<std::pair<std::uint64_t, std::uint64_t>> last;  // its key, its hash
    const std::uint64_t key = static_key(scene);
    const std::lock_guard lock(mutex);
    if (!last || last->first != key) last = {key, scene_hash(scene, flatten_static(scene))};
    return last->second;
}

RayCounts Bake::counts() const {
    RayCounts all;
    for (const RayCounts& c : block_counts) {
        all.traced += c.traced, all.escaped += c.escaped;
        all.back += c.back, all.unseen += c.unseen;
    }
    return all;
}

float told_share(const Bake& b, int receiver) {
    const std::size_t slots = std::size_t(b.supports.overlaps), coefficients = std::size_t(b.coefficients());
    double sum = 0;
    for (std::size_t s = 0; s < slots; ++s) sum += double(b.alpha[(std::size_t(receiver) * slots + s) * coefficients]);
    return float(sum * std::sqrt(4 * host::pi) / host::pi);
}

int black_receivers(const Bake& bake) {
    int black = 0;
    for (int i = 0; i < bake.receivers.count(); ++i)
        black += bake.supports.probe[std::size_t(i) * std::size_t(bake.supports.overlaps)] >= 0 && told_share(bake, i) == 0 ? 1 : 0;
    return black;
}

}  // namespace plumb::probes
