#include "gi/probes/memory.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/sh.h"
#include "gi/probes/cluster_tree.h"
#include "gi/probes/svd_loops.h"

namespace plumb::probes {

namespace {

// Bytes, measured: what is small, and what the program touches of itself; of a triangle in Embree's tree.
constexpr std::uint64_t of_program = 12 << 20, of_tree = 200;

// What an allocator keeps of memory that was freed: a share, and what lies in the arenas of threads. How much depends on which
// thread freed what first: the same bake took 313, 340 and 371 MB.
constexpr std::uint64_t allocator_share = 25, of_arenas = 64 << 20;

// Of an element of each list that Receivers, Supports, RelightHits and the texture-space pass have.
constexpr std::uint64_t of_receiver = 3 * 16 + 8 + 3 * 4, of_slot = 8, of_relight_ray = 4 + 4 + 8 + 16;
constexpr std::uint64_t of_drawn_texel = 4 * 16 + 12 + 8 + 4 + 4;

// Of the flattened scene and of the atlas, and of what is made of them for rays.
std::uint64_t of_geometry(const Bake& b) {
    const Geometry& g = b.atlas.geometry;
    const std::uint64_t lists = g.vertices.size() * (sizeof(Vertex) + 8) + g.tangents.size() * 16 + g.triangles.size() * (12 + 4 + 4 + 4);
    return 2 * lists + g.triangles.size() * of_tree;
}

std::uint64_t of_receivers(const Bake& b) {
    const std::uint64_t all = std::uint64_t(b.receivers.count()) + std::uint64_t(b.spatial.receivers.count());
    return all * (of_receiver + std::uint64_t(b.params.placement.overlaps) * of_slot);
}

// What clusters of all receivers take, as Clusters and FlatClusters, and what a thread needs to find them.
struct OfClusters {
    std::uint64_t held = 0, workspace = 0;
};
OfClusters of_clusters(const Bake& b, int receivers, const Receivers& of, const Supports& supports) {
    TransportRows rows;
    rows.receivers = receivers, rows.overlaps = supports.overlaps, rows.coefficients = b.coefficients();
    rows.position = of.position.data(), rows.support = supports.probe.data();
    const ClusterBound c = cluster_bound(rows, cluster_params(b.params));
    const std::uint64_t u = std::uint64_t(receivers) * std::uint64_t(b.params.singular_values) * sizeof(float);
    const std::uint64_t once = c.matrices * sizeof(float) + c.spectrum * sizeof(double) + u;
    // Receivers of clusters, and the cluster of each, are held twice, too.
    return {2 * once + c.lists * 4 + c.clusters * 1024 + std::uint64_t(receivers) * 16, c.workspace};
}

}  // namespace

std::uint64_t bytes_of_scene(const Scene& scene) {
    std::uint64_t bytes = of_program;
    for (const Mesh& m : scene.meshes) bytes += m.vertices.size() * (sizeof(Vertex) + 16) + m.triangles.size() * 16;
    // Texels, and the levels of detail that are made of them.
    for (const Texture& t : scene.textures) bytes += std::uint64_t(t.texels.size()) * (4 + 6);
    return bytes;
}

std::uint64_t bytes_of_fit(const FitSize& of, int threads) {
    const std::uint64_t width = std::uint64_t(padded(sh::count(of.degree))), size = of.overlaps * width;
    const std::uint64_t pairs = std::min(of.probes * (of.probes + 1) / 2, std::uint64_t(block_receivers) * of.overlaps * (of.overlaps + 1) / 2);
    return of.probes * of.rays * (width * sizeof(double) + 64) + pairs * width * width * sizeof(double) +
           std::uint64_t(threads) * sizeof(double) * (2 * size * size + of.rays * (of.rays + width));
}

std::uint64_t bytes_to_draw(const Bake& b) {
    const std::uint64_t texels = std::uint64_t(b.atlas.size.x) * std::uint64_t(b.atlas.size.y);
    return b.scene_bytes + of_geometry(b) + texels * of_drawn_texel;
}

std::uint64_t bytes_needed(const Bake& b, const Part& part, int threads) {
    const std::uint64_t receivers = std::uint64_t(b.receivers.count()) + std::uint64_t(b.spatial.receivers.count()), block = block_receivers;
    const std::uint64_t row = std::uint64_t(b.supports.overlaps) * std::uint64_t(b.coefficients()) * sizeof(float);
    const std::uint64_t held = b.scene_bytes + of_geometry(b) + of_receivers(b) +
                               b.placement.candidates.size() * 16 +
                               b.placement.probes.size() * std::uint64_t(b.params.relight_rays) * of_relight_ray +
                               std::uint64_t(b.params.relight_rays) * (20 + 4 * std::uint64_t(b.coefficients()));
    // A block as it is traced; its transport by rows, by receivers, and on its way into the store.
    const std::uint64_t of_ray = b.transport.fitted ? 28 + 16 : 28;
    const FitSize size{b.placement.probes.size(), std::uint64_t(b.params.relight_rays), std::uint64_t(b.supports.overlaps), b.params.degree};
    const std::uint64_t while_tracing = block * (std::uint64_t(b.params.receiver_rays) * of_ray + 3 * row) + (b.transport.fitted ? bytes_of_fit(size, threads) : 0);
    if (part.count > 1) {
        const std::uint64_t blocks = (receivers + block - 1) / block, count = std::uint64_t(part.count);
        return std::max(bytes_to_draw(b), held + (blocks + count - 1) / count * block * row + while_tracing);
    }
    const OfClusters surfaces = of_clusters(b, b.receivers.count(), b.receivers, b.supports);
    // The six directions are clustered alike, one after the other.
    const OfClusters air = b.spatial.empty() ? OfClusters{} : of_clusters(b, b.spatial.grid.places(), b.spatial.receivers, b.spatial.supports);
    const std::uint64_t clusters = surfaces.held + spatial_directions * air.held;
    const std::uint64_t whole = held + receivers * row + std::max(while_tracing, std::uint64_t(threads) * std::max(surfaces.workspace, air.workspace) + clusters);
    return std::max(bytes_to_draw(b), whole + whole / allocator_share + of_arenas);
}

std::string size_text(std::uint64_t bytes) {
    return bytes < 1000000000 ? fmt::format("{:.3g} MB", double(bytes) * 1e-6) : fmt::format("{:.1f} GB", double(bytes) * 1e-9);
}

void require_memory(const std::string& what, std::uint64_t needed, std::uint64_t there, const std::string& lower) {
    if (needed > there)
        throw InputError(fmt::format("probes: {} need {} of memory; there are {}: lower {}", what, size_text(needed), size_text(there), lower));
}

}  // namespace plumb::probes
