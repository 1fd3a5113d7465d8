// Spatial receivers: near what moves, or all of them.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/nodes_probes.h"

namespace plumb::frame {

namespace {

probes::IrradianceInputs spatial_inputs(ProbeBuffers& p) {
    probes::IrradianceInputs in;
    in.clusters = &p.spatial, in.cluster_level = p.spatial_levels.data(), in.receiver_level = p.spatial_active.data(), in.basis = p.spatial_basis.data();
    return in;
}

void add_active(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_host(c, probes::info_active(), "spatial receivers near what moves", {1, 1});
    node.reads = [&c, &p](graph::Reads& r) {
        r.source("bake", c.bake_key);
        r.source("geometry", c.keys.geometry);
        r.list(p.data.matrix);
        r.value(c.relief.fixed);
    };
    node.outputs = [&p] {
        Bundle b;
        lend(b, "level", {std::int64_t(p.spatial_active.size())}, p.spatial_active.data());
        lend(b, "cluster", {std::int64_t(p.spatial_levels.size())}, p.spatial_levels.data());
        return b;
    };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun& run) {
        const probes::Bake& b = bake_of(c);
        auto active = probes::active_places(b.spatial.grid, probes::dynamic_boxes(c.scene));
        if (c.relief.fixed) std::fill(active.begin(), active.end(), std::uint8_t(1));
        p.spatial_active = probes::active_levels(b.spatial.grid, active, p.spatial.receiver);
        p.spatial_levels = probes::active_clusters(p.spatial_active, p.spatial.cluster, p.spatial.clusters.size());
        run.reason = fmt::format("{} of {} places are computed, {} of {} clusters", std::count(active.begin(), active.end(), 1), active.size(),
                                 std::count(p.spatial_levels.begin(), p.spatial_levels.end(), 0), p.spatial_levels.size());
    };
    node.leave_out = [&p] { p.spatial_active.clear(), p.spatial_levels.clear(); };
    nodes.push_back(std::move(node));
}

}  // namespace

void add_volume(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    using probes::Bake;
    const auto named = [&](const std::string& form) {
        PlannedNode& node = nodes.back();
        set_form(node, form);
    };
    add_active(c, nodes);
    add_stage(c, nodes, "what clusters in the air get", "b", 4096, [](const Bake& b) { return glm::ivec2(b.spatial.flat.singular_values, b.spatial.flat.count()); },
              [&c, &p] {
                  probes::BasisInputs in = probes::basis_inputs(buffers_of(c));
                  in.clusters = &p.spatial, in.cluster_level = p.spatial_levels.data();
                  // As old as what the picture finds on the lightmap: of places that are near what moves now no earlier frame need know.
                  if (pipelined(c)) in.lambda = p.last.lambda_3.data();
                  return in;
              },
              [&p]() -> Image4& { return p.spatial_basis; });
    named("spatial");
    add_stage(c, nodes, "what receivers in the air get", "irradiance", 4096, [](const Bake& b) { return probes::irradiance_size(b.spatial.receivers.count()); },
              [&p] { return spatial_inputs(p); }, [&p]() -> Image4& { return p.spatial_irradiance; });
    named("spatial");
    add_static_light(c, nodes);
    PlannedNode gather = begin_node(c, "grid", "", "", 0, {});
    gather.listed = false;
    gather.reads = [&p](graph::Reads& r) { r.image(p.spatial_irradiance), r.list(p.data.matrix), r.list(p.static_light); };
    gather.outputs = [&p] {
        Bundle b;
        const auto grid = [&b](const char* name, const Buffer<glm::vec4>& g) {
            lend(b, name, {std::int64_t(g.size()), 4}, g.empty() ? nullptr : &g[0].x);
        };
        grid("bounced", p.bounced), grid("grid", p.grid);
        return b;
    };
    gather.run = [&c, &p](const RunOptions&, graph::NodeRun&) {
        probes::gather_grid(bake_of(c).spatial.grid, p.spatial.receiver, p.spatial_irradiance.texels, p.bounced);
        p.grid = p.bounced;
        for (std::size_t i = 0; i < p.static_light.size(); ++i) p.grid[i] += p.static_light[i];
    };
    gather.leave_out = [&p] { p.grid.clear(), p.bounced.clear(); };
    nodes.push_back(std::move(gather));
}

}  // namespace plumb::frame
