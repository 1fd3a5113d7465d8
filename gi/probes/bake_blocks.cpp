// The steps of a bake that are many nodes: blocks of probes and of receivers, each kept by itself; and what is made of all.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/parallel.h"
#include "gi/probes/bake_world.h"
#include "gi/probes/kept_steps.h"
#include "gi/probes/memory.h"

namespace plumb::probes {

namespace {

TransportScene transport_scene(const Bake& b, const raster::SurfaceArgs& surfaces, const RayQuery& query, float offset) {
    TransportScene s;
    s.surfaces = surfaces, s.query = &query, s.offset = offset;
    s.probes = &b.placement.probes;
    s.directions = receiver_directions(b.transport.rays, b.transport.distribution);
    s.factors = ray_factors(s.directions, b.transport.distribution);
    return s;
}

std::size_t row_of(const Bake& b) { return std::size_t(b.supports.overlaps) * std::size_t(b.coefficients()); }

}  // namespace

TracedBlock BakeGraph::trace(bool spatial, int first, const RayQuery& query, const RunOptions& options) const {
    const Receivers& receivers = spatial ? bake_.spatial.receivers : bake_.receivers;
    TransportScene scene = transport_scene(bake_, world_->args(), query, world_->offset);
    if (spatial) scene.factors = spatial_factors(scene.directions, bake_.transport.distribution, bake_.params.spatial_weight);
    return trace_block(scene, bake_.transport, receivers, spatial ? bake_.spatial.supports : bake_.supports, first,
                       std::min(block_receivers, receivers.count() - first), options);
}

TracedBlock BakeGraph::traced(int receiver, const RayQuery& query, const RunOptions& options) const {
    return trace(false, receiver / block_receivers * block_receivers, query, options);
}

// Made when a block first asks for it.
Fit& BakeGraph::fit(const RunOptions& options) {
    if (!fit_) {
        RunOptions quiet = options;
        quiet.progress = {};
        fit_ = std::make_unique<Fit>(transport_scene(bake_, world_->args(), query(), world_->offset), bake_.transport, bake_.radius.radius_m, quiet);
    }
    return *fit_;
}

void BakeGraph::check_memory() {
    bytes_ = bytes_needed(bake_, part_, thread_count(0));
    require_memory(fmt::format("{} receivers and {} probes", bake_.receivers.count(), bake_.placement.probes.size()), bytes_, memory_limit_,
                   "receivers_per_m2, count, relight_rays, overlaps or degree");
    if (sized_) sized_(bytes_);
}

// Of a part its own blocks alone, one after the other.
std::vector<const graph::Node*> BakeGraph::add_blocks() {
    check_memory();
    Bake& b = bake_;
    const int probes = int(b.placement.probes.size());
    const auto held = [&](int receivers, int blocks) {
        return part_.count == 1 ? std::size_t(receivers) : std::size_t(of_part(blocks)) * block_receivers;
    };
    b.relight = no_hits(probes, b.params.relight_rays);
    b.alpha.assign(held(b.receivers.count(), b.blocks()) * row_of(b), 0);
    b.block_counts.assign(std::size_t(b.blocks()), {});
    b.spatial.alpha.assign(held(b.spatial.receivers.count(), b.spatial_blocks()) * row_of(b), 0);
    b.spatial.block_counts.assign(std::size_t(b.spatial_blocks()), {});
    const std::size_t before = nodes_.size();
    for (int first = part_.index * block_probes; first < probes; first += part_.count * block_probes)
        nodes_.push_back(relight_node(first, std::min(block_probes, probes - first)));
    for (int block = part_.index; block < b.blocks(); block += part_.count) nodes_.push_back(coefficients_node(block, false));
    for (int block = part_.index; block < b.spatial_blocks(); block += part_.count) nodes_.push_back(coefficients_node(block, true));
    if (part_.count == 1) nodes_.push_back(clusters_node());
    if (part_.count == 1 && !b.spatial.empty()) nodes_.push_back(spatial_clusters_node());
    std::vector<const graph::Node*> added;
    for (std::size_t i = before; i < nodes_.size(); ++i) added.push_back(&nodes_[i]);
    return added;
}

graph::Node BakeGraph::relight_node(int first, int count) {
    Bake& b = bake_;
    World& w = *world_;
    graph::Node node = host_node("probes.relight", "rays tell where a probe looks for radiance");
    node.plan.form = fmt::format("probes {} to {}", first, first + count - 1);
    node.plan.label = fmt::format("probes.relight ({})", node.plan.form);
    node.size = [=, &b] { return glm::ivec2(b.relight.rays, count); };
    node.reads = [=, this, &b](graph::Reads& r) {
        r.memory(&b.placement.probes[std::size_t(first)], std::size_t(count) * sizeof(glm::vec4));
        r.list(b.atlas.uv), r.list(b.relight_directions);
        read_rays(r);
    };
    node.run = [=, &b, &w](const RunOptions& options, graph::NodeRun& run) {
        relight_rays(b.atlas, w.args(), w.query(), b.placement.probes, b.relight_directions, first, count, options, b.relight);
        run.bytes = std::size_t(count) * std::size_t(b.relight.rays) * 32;
    };
    node.outputs = [=, &b] { return lent(b.relight, first, count); };
    node.load = [=, &b](const Bundle& kept) { take(kept, b.relight, first, count); };
    return node;
}

graph::Node BakeGraph::coefficients_node(int block, bool spatial) {
    Bake& b = bake_;
    const Receivers& receivers = spatial ? b.spatial.receivers : b.receivers;
    const Supports& supports = spatial ? b.spatial.supports : b.supports;
    RayCounts& counts = (spatial ? b.spatial.block_counts : b.block_counts)[std::size_t(block)];
    const int first = block * block_receivers, count = std::min(block_receivers, receivers.count() - first);
    const std::size_t row = row_of(b);
    float* alpha = (spatial ? b.spatial.alpha : b.alpha).data() + std::size_t(block / part_.count) * block_receivers * row;
    graph::Node node = host_node("probes.coefficients", "what receivers see, and which probes see the same");
    node.plan.form = fmt::format("{} {} to {}", spatial ? "spatial receivers" : "receivers", first, first + count - 1);
    node.plan.label = fmt::format("probes.coefficients ({})", node.plan.form);
    node.size = [=] { return glm::ivec2(count, int(row)); };
    node.reads = [=, this, &b, &receivers, &supports](graph::Reads& r) {
        const auto slice = [&](const auto& list, std::size_t each) {
            r.memory(list.data() + std::size_t(first) * each, std::size_t(count) * each * sizeof(list[0]));
        };
        slice(receivers.position, 1), slice(receivers.normal, 1);
        slice(supports.probe, std::size_t(supports.overlaps)), slice(supports.weight, std::size_t(supports.overlaps));
        if (spatial) r.value(b.params.spatial_weight);
        r.list(b.placement.probes);
        const auto& [rays, degree, distribution, escape, published, fitted, relight] = b.transport;
        r.value(rays, degree, distribution, escape, published, fitted);
        if (fitted) r.value(relight), r.memory(&b.radius.radius_m, sizeof b.radius.radius_m);
        read_rays(r);
    };
    node.run = [=, this, &b, &supports, &counts](const RunOptions& options, graph::NodeRun& run) {
        const auto start = std::chrono::steady_clock::now();
        RunOptions tracing = options;
        // Rays take nearly all of a block's time.
        if (options.progress) tracing.progress = [&](double done) { options.progress(0.95 * done); };
        const TracedBlock traced = trace(spatial, first, query(), tracing);
        seconds_of_rays_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        tracing.progress = {};
        block_coefficients(traced, b.transport, tracing, alpha);
        if (b.transport.fitted) fit(options).coefficients(traced, supports, tracing, alpha);
        counts = traced.counts;
        run.bytes = std::size_t(count) * row * sizeof(float);
        run.reason = fmt::format("{} rays; {} escaped, {} met backs, {} what no probe sees", counts.traced, counts.escaped,
                                 counts.back, counts.unseen);
    };
    node.outputs = [=, &counts] { return lent(alpha, count, std::int64_t(row), counts); };
    node.load = [=, &counts](const Bundle& kept) { take(kept, alpha, count, std::int64_t(row), counts); };
    return node;
}

graph::Node BakeGraph::clusters_node() {
    Bake& b = bake_;
    graph::Node node = host_node("probes.clusters", "decompositions of whole matrices");
    node.size = [&b] { return glm::ivec2(b.receivers.count(), 1); };
    node.reads = [&b](graph::Reads& r) {
        r.list(b.receivers.position), r.list(b.supports.probe), r.list(b.alpha);
        r.value(b.params.degree, b.params.singular_values, b.params.threshold, b.params.cluster_receivers,
                b.params.by_size_only);
    };
    node.run = [&b](const RunOptions& options, graph::NodeRun& run) {
        TransportRows rows;
        rows.receivers = b.receivers.count(), rows.overlaps = b.supports.overlaps, rows.coefficients = b.coefficients();
        rows.position = b.receivers.position.data(), rows.support = b.supports.probe.data(), rows.alpha = b.alpha.data();
        b.clusters = make_clusters(rows, cluster_params(b.params), options, &b.cluster_report);
        b.flat = flat(b.clusters);
        run.bytes = (b.flat.sigma_vt.size() + b.flat.u.size()) * sizeof(float);
        const TruncationError error = truncation_error(b.clusters, b.params.singular_values);
        run.reason = fmt::format("{} clusters; error as printed {:.4f}, Frobenius {:.2e}", b.clusters.clusters.size(),
                                 error.published, error.frobenius);
    };
    node.outputs = [&b] { return lent(b.flat); };
    node.load = [&b](const Bundle& kept) {
        b.flat = flat_clusters(kept);
        b.clusters = clusters_of(b.flat, b.coefficients());
    };
    return node;
}

}  // namespace plumb::probes
