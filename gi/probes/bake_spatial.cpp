// The steps of a bake that are of spatial receivers alone (IPR 4.1). Their coefficients are those of any receivers: bake_blocks.cpp.
#include <fmt/format.h>

#include "core/error.h"
#include "gi/probes/bake_world.h"
#include "gi/probes/kept_steps.h"

namespace plumb::probes {

graph::Node BakeGraph::spatial_node() {
    Bake& b = bake_;
    World& w = *world_;
    graph::Node node = host_node("probes.spatial", "places of a grid; rays tell which lie inside of something");
    node.reads = [&, this](graph::Reads& r) {
        r.list(b.placement.probes);
        r.memory(&b.radius.radius_m, sizeof b.radius.radius_m);
        r.value(b.params.spatial_receivers, b.params.spatial_back_share, b.params.test_rays, b.params.placement.overlaps);
        read_rays(r);
    };
    node.run = [&](const RunOptions& options, graph::NodeRun& run) {
        glm::vec3 low(0), high(0);
        bounds(b.atlas.geometry, low, high);
        const SpatialParams p{b.params.spatial_receivers, b.params.test_rays, double(b.params.spatial_back_share)};
        b.spatial = place_spatial(low, high, p, w.args(), w.query(), w.offset, b.placement.probes, float(b.radius.radius_m),
                                  b.params.placement.overlaps, options);
        const glm::ivec3 n = b.spatial.grid.count;
        run.bytes = std::size_t(b.spatial.receivers.count()) * 48;
        run.reason = fmt::format("{} x {} x {} places of six receivers, {} moved", n.x, n.y, n.z, b.spatial.shifted);
    };
    node.outputs = [&] { return lent(b.spatial); };
    node.load = [&](const Bundle& kept) { take(kept, b.spatial); };
    node.size = [&] { return glm::ivec2(b.spatial.receivers.count(), 1); };
    return node;
}

graph::Node BakeGraph::spatial_clusters_node() {
    Bake& b = bake_;
    graph::Node node = host_node("probes.clusters", "decompositions of whole matrices");
    node.plan.form = "spatial receivers";
    node.plan.label = "probes.clusters (spatial receivers)";
    node.size = [&b] { return glm::ivec2(b.spatial.receivers.count(), 1); };
    node.reads = [&b](graph::Reads& r) {
        r.list(b.spatial.receivers.position), r.list(b.spatial.supports.probe), r.list(b.spatial.alpha);
        r.value(b.params.degree, b.params.singular_values, b.params.threshold, b.params.cluster_receivers, b.params.by_size_only);
    };
    node.run = [&b](const RunOptions& options, graph::NodeRun& run) {
        b.spatial.clusters = spatial_clusters(b.spatial, b.coefficients(), cluster_params(b.params), options);
        b.spatial.flat = flat(b.spatial.clusters);
        run.bytes = (b.spatial.flat.sigma_vt.size() + b.spatial.flat.u.size()) * sizeof(float);
        run.reason = fmt::format("{} clusters", b.spatial.clusters.clusters.size());
    };
    node.outputs = [&b] { return lent(b.spatial.flat); };
    node.load = [&b](const Bundle& kept) {
        b.spatial.flat = flat_clusters(kept);
        b.spatial.clusters = clusters_of(b.spatial.flat, b.coefficients());
    };
    return node;
}

}  // namespace plumb::probes
