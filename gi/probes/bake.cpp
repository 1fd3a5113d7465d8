#include "gi/probes/bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "core/sh.h"
#include "gi/lend.h"
#include "gi/reference/ray_query.h"
#include "raster/surfaces.h"

namespace plumb::probes {

// What rays need, made when the atlas is there.
struct BakeGraph::World {
    Geometry geometry;
    bool sky = false;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> query;
    float offset = 0;

    raster::SurfaceArgs args(const Atlas& atlas) const { return raster::surface_args(atlas.geometry, surfaces, View{}); }
};

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
    t.escape = p.escapes == Escapes::automatic ? (sky ? Escape::same_direction : Escape::nothing)
                                             : Escape(int(p.escapes) - 1);
    return t;
}

bool sends_light(const Environment& e) {
    if (e.map.empty()) return e.radiance != glm::vec3(0);
    return e.radiance != glm::vec3(0) && std::any_of(e.map.texels.begin(), e.map.texels.end(), [](const glm::vec4& t) {
        return t.x != 0 || t.y != 0 || t.z != 0;
    });
}

namespace {

template <class List>
void lend_list(Bundle& b, const std::string& name, const List& list) {
    using T = typename List::value_type;
    const std::int64_t n = std::int64_t(list.size());
    if constexpr (std::is_arithmetic_v<T>)
        lend(b, name, {n}, list.data());
    else
        lend(b, name, {n, T::length()}, n ? &list[0].x : static_cast<const typename T::value_type*>(nullptr));
}

graph::Node host_node(const std::string& name, const std::string& reason) {
    graph::Node node;
    node.plan.name = node.plan.label = name;
    node.plan.reason = reason;
    return node;
}

}  // namespace

std::uint64_t scene_hash(const Scene& scene, const Geometry& geometry) {
    ContentHasher h;
    h.add_all(geometry.vertices), h.add_all(geometry.triangles), h.add_all(geometry.material), h.add_all(geometry.object);
    h.add_all(geometry.tangents);
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
    return h.hash;
}

RayCounts Bake::counts() const {
    RayCounts all;
    for (const RayCounts& c : block_counts) {
        all.traced += c.traced, all.escaped += c.escaped;
        all.back += c.back, all.unseen += c.unseen;
    }
    return all;
}

std::uint64_t bytes_needed(const Bake& bake, const Part& part) {
    const std::uint64_t receivers = std::uint64_t(bake.receivers.count()), probes = bake.placement.probes.size();
    const std::uint64_t coefficients = std::uint64_t(bake.coefficients()), slots = std::uint64_t(bake.supports.overlaps);
    const std::uint64_t row = slots * coefficients * sizeof(float), kept = std::uint64_t(bake.params.singular_values);
    const std::uint64_t alpha = receivers * row / std::uint64_t(part.count) + std::uint64_t(block_receivers) * row;
    const std::uint64_t relight = probes * std::uint64_t(bake.params.relight_rays) * 32;
    const std::uint64_t block = std::uint64_t(block_receivers) * (std::uint64_t(bake.params.receiver_rays) * 28 + 2 * row);
    const std::uint64_t lightmap = std::uint64_t(bake.atlas.size.x) * std::uint64_t(bake.atlas.size.y);
    const std::uint64_t atlas = bake.atlas.geometry.vertices.size() * 2 * sizeof(Vertex) + bake.atlas.geometry.triangles.size() * 60;
    std::uint64_t bytes = alpha + relight + block + atlas + receivers * (80 + slots * 8) + lightmap * 16;
    if (part.count > 1) return bytes;
    // Clusters of 40 receivers and twice the probes of one, as rooms have them; three copies: clusters, as they are kept, the file.
    const std::uint64_t matrices = receivers / 40 * kept * 2 * std::min(probes, slots) * coefficients * sizeof(float);
    const std::uint64_t largest = std::uint64_t(bake.params.cluster_receivers) * std::min(probes, 4 * slots) * coefficients * 8 * 4;
    return bytes + 3 * (matrices + receivers * kept * 4) + largest + relight + receivers * (80 + slots * 8);
}

int black_receivers(const Bake& bake) {
    const std::size_t row = std::size_t(bake.supports.overlaps) * std::size_t(bake.coefficients());
    int black = 0;
    for (std::size_t i = 0; i < std::size_t(bake.receivers.count()); ++i) {
        if (bake.supports.probe[i * std::size_t(bake.supports.overlaps)] < 0) continue;
        const float* alpha = bake.alpha.data() + i * row;
        black += std::all_of(alpha, alpha + row, [](float a) { return a == 0; }) ? 1 : 0;
    }
    return black;
}

BakeGraph::BakeGraph(const Scene& scene, const BakeParams& params, Part part, std::uint64_t memory_limit)
    : scene_(scene), part_(part), memory_limit_(memory_limit), world_(std::make_unique<World>()) {
    validate(params);
    if (part.count < 1 || part.index < 0 || part.index >= part.count)
        throw InputError(fmt::format("part {}/{}: expected 1/N to N/N", part.index + 1, part.count));
    world_->geometry = flatten(scene);
    world_->sky = sends_light(scene.environment);
    bake_.params = params;
    bake_.transport = transport_params(params, world_->sky);
    bake_.scene_hash = probes::scene_hash(scene, world_->geometry);
    add_host_nodes();
    for (const graph::Node& node : nodes_) first_.push_back(&node);
}

BakeGraph::~BakeGraph() = default;

// What decides where rays end.
void BakeGraph::read_rays(graph::Reads& reads) const {
    reads.source("scene", bake_.scene_hash);
    reads.value(bake_.params.rays, world_->offset);
    if (bake_.params.rays == Rays::native) reads.text(reference::embree_version()), reads.value(best_isa());
}

void BakeGraph::add_host_nodes() {
    Bake& b = bake_;
    World& w = *world_;

    graph::Node atlas = host_node("probes.atlas", "charts are packed one after the other");
    atlas.reads = [&](graph::Reads& r) {
        r.source("scene", b.scene_hash);
        r.value(b.params.receivers_per_m2, b.params.lightmap_size, b.params.gap, b.params.chart_angle);
    };
    atlas.run = [&](const RunOptions&, graph::NodeRun& run) {
        b.atlas = make_atlas(scene_, w.geometry, atlas_params(b.params));
        w.surfaces = raster::prepare(scene_, b.atlas.geometry);
        w.query = reference::build_ray_query(b.atlas.geometry, w.surfaces, b.params.rays);
        w.offset = offset_of(extent_of(b.atlas.geometry));
        run.bytes = b.atlas.uv.size() * sizeof(glm::vec2) + b.atlas.geometry.vertices.size() * sizeof(Vertex);
    };
    atlas.outputs = [&] {
        Bundle out;
        lend_list(out, "uv", b.atlas.uv);
        lend_list(out, "chart", b.atlas.chart);
        return out;
    };
    atlas.size = [&] { return glm::ivec2(int(b.atlas.charts.size()), 1); };
    nodes_.push_back(atlas);

    graph::Node receivers = host_node("probes.receivers", "drawn by texture_space; rays tell which lie inside of something");
    receivers.reads = [&](graph::Reads& r) {
        r.list(b.atlas.uv);
        r.value(b.atlas.size);
        r.value(b.params.test_rays, b.params.back_share);
        read_rays(r);
    };
    receivers.run = [&](const RunOptions& options, graph::NodeRun& run) {
        b.receivers = place_receivers(b.atlas, w.surfaces, options);
        b.shifted = shift_receivers(b.receivers, w.args(b.atlas), *w.query, w.offset, shift_params(b.params), options);
        run.bytes = std::size_t(b.receivers.count()) * 64;
        run.reason = fmt::format("{} receivers, {} moved", b.receivers.count(), b.shifted);
    };
    receivers.outputs = [&] {
        Bundle out;
        lend_list(out, "position", b.receivers.position), lend_list(out, "normal", b.receivers.normal);
        lend_list(out, "shift", b.receivers.shift), lend_list(out, "texel", b.receivers.texel);
        lend_list(out, "material", b.receivers.material), lend_list(out, "triangle", b.receivers.triangle);
        lend_list(out, "border", b.receivers.border);
        return out;
    };
    receivers.size = [&] { return glm::ivec2(b.receivers.count(), 1); };
    nodes_.push_back(receivers);

    graph::Node placement = host_node("probes.placement", "probes.density tells how crowded a candidate is; the host removes");
    placement.reads = [&](graph::Reads& r) {
        r.fields(fields(b.params.placement));
        r.list(b.receivers.position);
        read_rays(r);
    };
    placement.run = [&](const RunOptions& options, graph::NodeRun& run) {
        b.placement = place_probes(b.atlas.geometry, *w.query, b.params.placement, options);
        b.radius = probe_radius(b.placement.probes, b.receivers.position, b.params.placement, options);
        run.bytes = b.placement.candidates.size() * 16 + b.placement.probes.size() * 16;
        run.reason = fmt::format("{} probes of {} candidates, radius {:.4g} m", b.placement.probes.size(),
                                 b.placement.candidates.size(), b.radius.radius_m);
    };
    placement.outputs = [&] {
        Bundle out;
        lend_list(out, "candidates", b.placement.candidates), lend_list(out, "probes", b.placement.probes);
        lend(out, "radius", {1}, &b.radius.radius_m);
        return out;
    };
    placement.size = [&] { return glm::ivec2(int(b.placement.probes.size()), 1); };
    nodes_.push_back(placement);

    graph::Node supports = host_node("probes.supports", "which probes a receiver gathers from");
    const auto supports_inputs = [&] {
        SupportsInputs in;
        in.receivers = &b.receivers.position, in.probes = &b.placement.probes;
        in.radius = float(b.radius.radius_m), in.overlaps = b.params.placement.overlaps;
        return in;
    };
    supports.reads = [=, &b](graph::Reads& r) {
        r.list(b.receivers.position), r.list(b.placement.probes);
        r.memory(&b.radius.radius_m, sizeof b.radius.radius_m);
        r.value(b.params.placement.overlaps);
    };
    supports.run = [=, &b](const RunOptions& options, graph::NodeRun& run) {
        b.supports = probes::run(supports_inputs(), options);
        run.bytes = b.supports.probe.size() * 8;
        run.reason = fmt::format("{} receivers without probe, {} with fewer than {}", b.supports.unsupported,
                                 b.supports.incomplete, b.supports.overlaps);
    };
    supports.outputs = [&] {
        Bundle out;
        lend_list(out, "probe", b.supports.probe), lend_list(out, "weight", b.supports.weight);
        return out;
    };
    supports.size = [&] { return glm::ivec2(b.params.placement.overlaps, b.receivers.count()); };
    supports.dispatches = [=, &b] {
        return std::vector<StageData>{data_of(supports_inputs(), 0, std::min(b.receivers.count(), receivers_a_dispatch))};
    };
    nodes_.push_back(supports);

    graph::Node relight = host_node("probes.relight", "rays tell where a probe looks for radiance");
    relight.reads = [&](graph::Reads& r) {
        r.list(b.placement.probes), r.list(b.atlas.uv);
        r.value(b.params.relight_rays, b.params.degree);
        read_rays(r);
    };
    relight.run = [&, this](const RunOptions& options, graph::NodeRun& run) {
        const std::uint64_t needed = bytes_needed(b, part_);
        if (needed > memory_limit_)
            throw InputError(fmt::format("probes: {} receivers and {} probes need {:.1f} GB of memory; there are {:.1f} GB: lower "
                                         "receivers_per_m2, count, relight_rays, overlaps or degree",
                                         b.receivers.count(), b.placement.probes.size(), double(needed) / 1e9,
                                         double(memory_limit_) / 1e9));
        if (sized_) sized_(needed);
        b.relight_directions = relight_directions(b.params.relight_rays);
        b.relight_weights = relight_weights(b.relight_directions, b.params.relight_rays);
        b.harmonics = harmonics_of(b.relight_directions, b.params.degree);
        b.relight = relight_rays(b.atlas, w.args(b.atlas), *w.query, b.placement.probes, b.relight_directions, options);
        run.bytes = b.relight.material.size() * 32 + b.harmonics.size() * 4;
    };
    relight.outputs = [&] {
        Bundle out;
        lend_list(out, "directions", b.relight_directions), lend_list(out, "weights", b.relight_weights);
        lend_list(out, "harmonics", b.harmonics);
        lend_list(out, "material", b.relight.material), lend_list(out, "triangle", b.relight.triangle);
        lend_list(out, "uv", b.relight.uv), lend_list(out, "position", b.relight.position);
        return out;
    };
    relight.size = [&] { return glm::ivec2(b.relight.rays, b.relight.probes); };
    relight.then = [this] { return add_blocks(); };
    nodes_.push_back(relight);
}

const raster::Surfaces& BakeGraph::surfaces() const { return world_->surfaces; }

graph::Node BakeGraph::clusters_node() {
    Bake& b = bake_;
    graph::Node node = host_node("probes.clusters", "decompositions of whole matrices");
    const auto all = [&b] { return glm::ivec2(b.receivers.count(), 1); };
    node.size = all;
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

std::vector<const graph::Node*> BakeGraph::add_blocks() {
    // Of a part its own blocks alone, one after the other.
    const std::size_t row = std::size_t(bake_.supports.overlaps) * std::size_t(bake_.coefficients());
    const std::size_t held = part_.count == 1 ? std::size_t(bake_.receivers.count()) : std::size_t(blocks_here()) * block_receivers;
    bake_.alpha.assign(held * row, 0);
    bake_.block_counts.assign(std::size_t(bake_.blocks()), {});
    std::vector<const graph::Node*> added;
    for (int block = part_.index; block < bake_.blocks(); block += part_.count) {
        nodes_.push_back(block_node(block));
        added.push_back(&nodes_.back());
    }
    if (part_.count == 1) {
        nodes_.push_back(clusters_node());
        added.push_back(&nodes_.back());
    }
    return added;
}

namespace {

TransportScene transport_scene(const Bake& b, const raster::SurfaceArgs& surfaces, const RayQuery& query, float offset) {
    TransportScene s;
    s.surfaces = surfaces, s.query = &query, s.offset = offset;
    s.probes = &b.placement.probes;
    s.directions = receiver_directions(b.transport.rays, b.transport.distribution);
    s.factors = ray_factors(s.directions, b.transport.distribution);
    return s;
}

}  // namespace

TracedBlock BakeGraph::traced(int receiver, const RunOptions& options) const {
    const int first = receiver / block_receivers * block_receivers;
    return trace_block(transport_scene(bake_, world_->args(bake_.atlas), *world_->query, world_->offset), bake_.transport,
                       bake_.receivers, bake_.supports, first, std::min(block_receivers, bake_.receivers.count() - first),
                       options);
}

graph::Node BakeGraph::block_node(int block) {
    Bake& b = bake_;
    RayCounts& counts = b.block_counts[std::size_t(block)];
    const int first = block * block_receivers, count = std::min(block_receivers, b.receivers.count() - first);
    const std::size_t row = std::size_t(b.supports.overlaps) * std::size_t(b.coefficients());
    float* alpha = b.alpha.data() + std::size_t(block / part_.count) * block_receivers * row;
    graph::Node node = host_node("probes.coefficients", "what receivers see, and which probes see the same");
    node.plan.form = fmt::format("receivers {} to {}", first, first + count - 1);
    node.plan.label = fmt::format("probes.coefficients ({})", node.plan.form);
    node.size = [=] { return glm::ivec2(count, int(row)); };
    node.reads = [=, this, &b](graph::Reads& r) {
        const auto slice = [&](const auto& list, std::size_t each) {
            r.memory(list.data() + std::size_t(first) * each, std::size_t(count) * each * sizeof(list[0]));
        };
        slice(b.receivers.position, 1), slice(b.receivers.normal, 1);
        slice(b.supports.probe, std::size_t(b.supports.overlaps)), slice(b.supports.weight, std::size_t(b.supports.overlaps));
        r.list(b.placement.probes);
        const auto& [rays, degree, distribution, escape, published] = b.transport;
        r.value(rays, degree, distribution, escape, published);
        read_rays(r);
    };
    node.run = [=, this, &b, &counts](const RunOptions& options, graph::NodeRun& run) {
        const auto start = std::chrono::steady_clock::now();
        RunOptions tracing = options;
        // Rays take nearly all of a block's time.
        if (options.progress) tracing.progress = [&](double done) { options.progress(0.95 * done); };
        const TracedBlock traced = this->traced(first, tracing);
        seconds_of_rays_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        tracing.progress = {};
        block_coefficients(traced, b.transport, tracing, alpha);
        counts = traced.counts;
        run.bytes = std::size_t(count) * row * sizeof(float);
        run.reason = fmt::format("{} rays; {} escaped, {} met backs, {} what no probe sees", counts.traced, counts.escaped,
                                 counts.back, counts.unseen);
    };
    node.outputs = [=, &counts] {
        Bundle out;
        lend(out, "alpha", {count, std::int64_t(row)}, const_cast<const float*>(alpha));
        lend(out, "rays", {4, 2}, reinterpret_cast<const std::uint32_t*>(&counts));
        return out;
    };
    node.load = [=, &counts](const Bundle& kept) {
        const auto values = elements<float>(kept, "alpha", {count, std::int64_t(row)});
        const auto rays = elements<std::uint32_t>(kept, "rays", {4, 2});
        std::copy(values.begin(), values.end(), alpha);
        const auto count_at = [&](std::size_t k) { return std::uint64_t(rays[2 * k]) | std::uint64_t(rays[2 * k + 1]) << 32; };
        counts = {count_at(0), count_at(1), count_at(2), count_at(3)};
    };
    return node;
}

}  // namespace plumb::probes
