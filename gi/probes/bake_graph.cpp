// The steps of a bake that are one node each, up to the rays of probes.
#include <fmt/format.h>

#include "core/error.h"
#include "gi/probes/bake_world.h"
#include "gi/probes/kept_steps.h"
#include "gi/probes/memory.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/static_scene.h"

namespace plumb::probes {

graph::Node host_node(const std::string& name, const std::string& reason) {
    graph::Node node;
    node.plan.name = node.plan.label = name;
    node.plan.reason = reason;
    return node;
}

BakeGraph::BakeGraph(const Scene& scene, const BakeParams& params, Part part, std::uint64_t memory_limit)
    : part_(part), memory_limit_(memory_limit), world_(std::make_unique<World>(scene, bake_)) {
    validate(params);
    if (part.count < 1 || part.index < 0 || part.index >= part.count)
        throw InputError(fmt::format("part {}/{}: expected 1/N to N/N", part.index + 1, part.count));
    world_->geometry = flatten_static(scene);
    bake_.params = params;
    bake_.transport = transport_params(params, sends_light(scene.environment));
    bake_.scene_hash = probes::scene_hash(scene, world_->geometry);
    bake_.scene_bytes = bytes_of_scene(scene);
    for (const graph::Node& node : {atlas_node(), receivers_node(), placement_node(), supports_node()}) nodes_.push_back(node);
    if (params.spatial_receivers > 0) nodes_.push_back(spatial_node());
    nodes_.push_back(rays_node());
    for (const graph::Node& node : nodes_) first_.push_back(&node);
}

BakeGraph::~BakeGraph() = default;

const raster::Surfaces& BakeGraph::surfaces() const { return world_->surfaces(); }

const RayQuery& BakeGraph::query() const { return world_->query(); }

// What decides where rays end.
void BakeGraph::read_rays(graph::Reads& reads) const {
    reads.source("scene", bake_.scene_hash);
    reads.value(bake_.params.rays, world_->offset);
    if (bake_.params.rays == Rays::native) reads.text(reference::embree_version()), reads.value(best_isa());
}

graph::Node BakeGraph::atlas_node() {
    Bake& b = bake_;
    World& w = *world_;
    graph::Node node = host_node("probes.atlas", "charts are packed one after the other");
    node.reads = [&](graph::Reads& r) {
        r.source("scene", b.scene_hash);
        r.value(b.params.receivers_per_m2, b.params.lightmap_size, b.params.gap, b.params.chart_angle);
    };
    const auto made = [&] {
        w.forget();
        w.offset = offset_of(extent_of(b.atlas.geometry));
    };
    node.run = [&, made](const RunOptions&, graph::NodeRun& run) {
        b.atlas = make_atlas(w.scene, w.geometry, atlas_params(b.params));
        made();
        run.bytes = b.atlas.uv.size() * sizeof(glm::vec2) + b.atlas.geometry.vertices.size() * sizeof(Vertex);
    };
    node.outputs = [&] { return lent(b.atlas); };
    node.load = [&, made](const Bundle& kept) {
        take(kept, b.atlas);
        made();
    };
    node.size = [&] { return glm::ivec2(int(b.atlas.charts.size()), 1); };
    return node;
}

graph::Node BakeGraph::receivers_node() {
    Bake& b = bake_;
    World& w = *world_;
    graph::Node node = host_node("probes.receivers", "drawn by texture_space; rays tell which lie inside of something");
    node.reads = [&](graph::Reads& r) {
        r.list(b.atlas.uv);
        r.value(b.atlas.size);
        r.value(b.params.test_rays, b.params.back_share);
        if (!b.atlas.geometry.tangents.empty()) r.text("normals without maps");
        read_rays(r);
    };
    node.run = [&, this](const RunOptions& options, graph::NodeRun& run) {
        require_memory(fmt::format("{} x {} texels", b.atlas.size.x, b.atlas.size.y), bytes_to_draw(b), memory_limit_,
                       "receivers_per_m2 or lightmap_size");
        b.receivers = place_receivers(b.atlas, w.surfaces(), options);
        b.shifted = shift_receivers(b.receivers, w.args(), w.query(), w.offset, shift_params(b.params), options);
        run.bytes = std::size_t(b.receivers.count()) * 64;
        run.reason = fmt::format("{} receivers, {} moved", b.receivers.count(), b.shifted);
    };
    node.outputs = [&] { return lent(b.receivers, b.shifted); };
    node.load = [&](const Bundle& kept) { take(kept, b.receivers, b.shifted); };
    node.size = [&] { return glm::ivec2(b.receivers.count(), 1); };
    return node;
}

graph::Node BakeGraph::placement_node() {
    Bake& b = bake_;
    World& w = *world_;
    graph::Node node = host_node("probes.placement", "probes.density tells how crowded a candidate is; the host removes");
    node.reads = [&](graph::Reads& r) {
        r.fields(fields(b.params.placement));
        r.list(b.receivers.position);
        r.value(b.transport.escape == Escape::sky);
        read_rays(r);
    };
    node.run = [&](const RunOptions& options, graph::NodeRun& run) {
        b.placement = place_probes(b.atlas.geometry, w.query(), b.params.placement, options);
        b.radius = probe_radius(b.placement.probes, b.receivers.position, b.params.placement, options);
        if (b.transport.escape == Escape::sky) add_sky(b.placement);
        run.bytes = b.placement.candidates.size() * 16 + b.placement.probes.size() * 16;
        run.reason = fmt::format("{} probes of {} candidates, radius {:.4g} m", standing_probes(b.placement.probes),
                                 b.placement.candidates.size(), b.radius.radius_m);
    };
    node.outputs = [&] { return lent(b.placement, b.radius); };
    node.load = [&](const Bundle& kept) { take(kept, b.placement, b.radius); };
    node.size = [&] { return glm::ivec2(int(b.placement.probes.size()), 1); };
    return node;
}

graph::Node BakeGraph::supports_node() {
    Bake& b = bake_;
    graph::Node node = host_node("probes.supports", "which probes a receiver gathers from");
    const auto inputs = [&b] {
        SupportsInputs in;
        in.receivers = &b.receivers.position, in.probes = &b.placement.probes;
        in.radius = float(b.radius.radius_m), in.overlaps = b.params.placement.overlaps;
        return in;
    };
    node.reads = [&b](graph::Reads& r) {
        r.list(b.receivers.position), r.list(b.placement.probes);
        r.memory(&b.radius.radius_m, sizeof b.radius.radius_m);
        r.value(b.params.placement.overlaps);
    };
    node.run = [=, &b](const RunOptions& options, graph::NodeRun& run) {
        b.supports = probes::run(inputs(), options);
        run.bytes = b.supports.probe.size() * 8;
        run.reason = fmt::format("{} receivers without probe, {} with fewer than {}", b.supports.unsupported,
                                 b.supports.incomplete, b.supports.overlaps);
        add_sky(b.supports, b.placement.probes);
    };
    node.outputs = [&b] { return lent(b.supports); };
    node.load = [&b](const Bundle& kept) { take(kept, b.supports); };
    node.size = [&b] { return glm::ivec2(b.params.placement.overlaps, b.receivers.count()); };
    node.dispatches = [=, &b] {
        return std::vector<StageData>{data_of(inputs(), 0, std::min(b.receivers.count(), receivers_a_dispatch))};
    };
    return node;
}

graph::Node BakeGraph::rays_node() {
    Bake& b = bake_;
    graph::Node node = host_node("probes.directions", "one set for all probes; weights are a least-squares problem");
    node.reads = [&b](graph::Reads& r) { r.value(b.params.relight_rays, b.params.degree); };
    node.run = [&b](const RunOptions&, graph::NodeRun& run) {
        b.relight_directions = relight_directions(b.params.relight_rays);
        b.relight_weights = relight_weights(b.relight_directions, b.params.relight_rays);
        b.harmonics = harmonics_of(b.relight_directions, b.params.degree);
        run.bytes = b.relight_directions.size() * 20 + b.harmonics.size() * 4;
    };
    node.outputs = [&b] { return lent_rays(b); };
    node.load = [&b](const Bundle& kept) { take_rays(kept, b); };
    node.size = [&b] { return glm::ivec2(b.params.relight_rays, 1); };
    node.then = [this] { return add_blocks(); };
    return node;
}

}  // namespace plumb::probes
