#include "gi/probes/texture_items.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace plumb::probes {
namespace {

constexpr int max_material = 1 << 24;  // every material below is a float

[[noreturn]] void fail(const std::string& what, std::size_t i, const std::string& cause) {
    throw InputError("bake: " + what + " " + std::to_string(i) + ": " + cause);
}
bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool is_finite(const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

void check_sizes(const BakeArrays& a) {
    const auto size = [](const char* what, std::size_t is, std::size_t expected) {
        if (is != expected)
            throw InputError(std::string("bake: ") + what + ": " + std::to_string(is) + " values; expected " +
                             std::to_string(expected));
    };
    const std::pair<const char*, std::size_t> counts[] = {
        {"receivers", a.receivers.size()},
        {"probes", a.probes.size()},
        {"clusters", a.clusters.size()},
        {"rays", std::size_t(std::max(a.rays, 0))},
        {"coefficients", std::size_t(std::max(a.coefficients, 0))},
        {"singular values", std::size_t(std::max(a.singular_values, 0))}};
    for (const auto& [what, count] : counts)
        if (count == 0) throw InputError(std::string("bake: no ") + what + ": a texture has at least one texel");
    size("u", a.u.size(), a.receivers.size() * std::size_t(a.singular_values));
    size("relight rays", a.relight.size(), a.probes.size() * std::size_t(a.rays));
    size("spherical harmonics", a.sh.size(), std::size_t(a.rays) * std::size_t(a.coefficients));
}

void check_receivers(const BakeArrays& a) {
    for (std::size_t i = 0; i < a.receivers.size(); ++i) {
        const BakedReceiver& r = a.receivers[i];
        if (!is_finite(r.position)) fail("receiver", i, "its position is not finite");
        if (r.texel.x < 0 || r.texel.y < 0) fail("receiver", i, "its texel is negative");
        if (r.material < 0 || r.material >= max_material) fail("receiver", i, "material " + std::to_string(r.material));
        if (r.border > 15) fail("receiver", i, "border " + std::to_string(r.border) + "; expected 4 bits");
        if (r.cluster < -1 || r.cluster >= int(a.clusters.size()))
            fail("receiver", i, "cluster " + std::to_string(r.cluster) + " of " + std::to_string(a.clusters.size()));
    }
    if (!is_finite(a.u)) throw InputError("bake: u: a value is not finite");
}

void check_probes(const BakeArrays& a) {
    for (std::size_t i = 0; i < a.probes.size(); ++i)
        if (!is_finite(a.probes[i])) fail("probe", i, "its position is not finite");
    for (std::size_t i = 0; i < a.relight.size(); ++i) {
        const BakedRay& r = a.relight[i];
        if (r.material < -2 || r.material >= max_material)
            fail("relight ray", i, "material " + std::to_string(r.material));
        if (!std::isfinite(r.uv.x) || !std::isfinite(r.uv.y)) fail("relight ray", i, "its u or v is not finite");
        if (r.material >= 0 && !is_finite(r.position)) fail("relight ray", i, "its hit is not finite");
    }
    if (!is_finite(a.sh)) throw InputError("bake: spherical harmonics: a value is not finite");
}

void check_clusters(const BakeArrays& a) {
    for (std::size_t i = 0; i < a.clusters.size(); ++i) {
        const BakedCluster& c = a.clusters[i];
        if (c.rank < 0 || c.rank > a.singular_values)
            fail("cluster", i,
                 "rank " + std::to_string(c.rank) + "; expected 0 to " + std::to_string(a.singular_values));
        const std::size_t values = std::size_t(c.rank) * c.probes.size() * std::size_t(a.coefficients);
        if (c.sigma_vt.size() != values)
            fail("cluster", i, std::to_string(c.sigma_vt.size()) + " values; expected " + std::to_string(values));
        for (int probe : c.probes)
            if (probe < 0 || std::size_t(probe) >= a.probes.size())
                fail("cluster", i, "probe " + std::to_string(probe) + " of " + std::to_string(a.probes.size()));
        if (!is_finite(c.sigma_vt)) fail("cluster", i, "a value of Sigma V^T is not finite");
        if (!is_finite(c.low) || !is_finite(c.high)) fail("cluster", i, "its box is not finite");
    }
}

}  // namespace

TextureCounts counts_of(const BakeArrays& a, const TextureLayout& layout) {
    if (layout.clusters_in_row < 1 || layout.receivers_in_row < 1)
        throw InputError("textures: a row has at least one cluster and one receiver");
    TextureCounts c;
    c.receivers = std::int64_t(a.receivers.size()), c.probes = std::int64_t(a.probes.size());
    c.clusters = std::int64_t(a.clusters.size());
    c.rays = a.rays, c.coefficients = a.coefficients, c.singular_values = a.singular_values;
    for (const BakedCluster& cluster : a.clusters)
        c.cluster_probes = std::max(c.cluster_probes, std::int64_t(cluster.probes.size()));
    c.cluster_columns = std::min<std::int64_t>(c.clusters, layout.clusters_in_row);
    c.receiver_columns = std::min<std::int64_t>(c.receivers, layout.receivers_in_row);
    return c;
}

ItemGrid grid_of(TextureId id, const TextureCounts& c) {
    switch (id) {
        case TextureId::probe_rays:
        case TextureId::hit_position:
            return {c.probes, 1, c.rays, 1};
        case TextureId::spherical_harmonics:
            return {1, 1, c.rays, c.coefficients};
        case TextureId::cluster_matrix:
            return {c.clusters, c.cluster_columns, c.singular_values, c.cluster_probes * c.coefficients};
        case TextureId::cluster_size:
            return {c.clusters, c.cluster_columns, 1, 1};
        case TextureId::cluster_probes:
            return {c.clusters, c.cluster_columns, 1, c.cluster_probes};
        case TextureId::cluster_bounds:
            return {c.clusters, c.cluster_columns, 8, 1};
        case TextureId::probe_position:
            return {c.probes, c.probes, 1, 1};
        case TextureId::receiver_transport:
            return {c.receivers, c.receiver_columns, c.singular_values, 1};
        case TextureId::receiver_map:
        case TextureId::receiver_material:
        case TextureId::receiver_position:
            break;
    }
    return {c.receivers, c.receiver_columns, 1, 1};
}

TextureId texture_id(const std::string& name) {
    std::string known;
    for (int id = 0; id < texture_count; ++id) {
        const char* own = info_of(TextureId(id)).name;
        if (name == own) return TextureId(id);
        known += (id ? ", " : "") + std::string(own);
    }
    throw InputError("texture \"" + name + "\" is unknown; expected one of " + known);
}

void check(const BakeArrays& arrays) {
    check_sizes(arrays);
    check_receivers(arrays);
    check_probes(arrays);
    check_clusters(arrays);
}

}  // namespace plumb::probes
