// Spatial receivers: near what moves, or all of them.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/nodes_probes.h"

namespace plumb::frame {

namespace {

probes::IrradianceInputs spatial_inputs(ProbeBuffers& p) {
    probes::IrradianceInputs in;
    const bool levels = !p.lod.off();
    in.clusters = &p.spatial, in.basis = p.spatial_basis.data();
    in.cluster_level = (levels ? p.air.cluster : p.spatial_levels).data(), in.receiver_level = (levels ? p.air_active : p.spatial_active).data();
    return in;
}

// What moves and may be seen; and all static surfaces, where pixels ask for their light vectors.
std::vector<probes::Box> readers(const Context& c) {
    std::vector<probes::Box> boxes = probes::dynamic_boxes(c.scene, c.plan ? c.plan->unseen : std::vector<int>());
    if (!c.relief.fixed) return boxes;
    probes::Box fixed;
    bounds(bake_of(c).atlas.geometry, fixed.low, fixed.high);
    boxes.push_back(fixed);
    return boxes;
}

}  // namespace

void add_active(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_host(c, probes::info_active(), "spatial receivers near what moves", {1, 1});
    for (std::size_t m = 0; m < c.scene.meshes.size(); ++m)
        if (c.scene.meshes[m].dynamic && !c.scene.meshes[m].vertices.empty())
            node.parts.push_back({"mesh", int(m), [](const Plan&) { return 0.0; }, [m](Plan& plan) { plan.unseen.push_back(int(m)); }});
    node.reads = [&c, &p](graph::Reads& r) {
        r.source("bake", c.bake_key);
        r.source("geometry", c.keys.geometry);
        r.list(p.data.matrix);
        r.value(c.relief.fixed);
        for (const int m : c.plan ? c.plan->unseen : std::vector<int>()) r.value(m);
    };
    node.outputs = [&p] {
        Bundle b;
        lend(b, "boxes", {std::int64_t(p.spatial_readers.size()), 6}, p.spatial_readers.empty() ? nullptr : &p.spatial_readers[0].low.x);
        lend(b, "level", {std::int64_t(p.spatial_active.size())}, p.spatial_active.data());
        lend(b, "cluster", {std::int64_t(p.spatial_levels.size())}, p.spatial_levels.data());
        return b;
    };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun& run) {
        const probes::Bake& b = bake_of(c);
        p.spatial_readers = readers(c);
        const auto active = probes::active_places(b.spatial.grid, p.spatial_readers);
        p.spatial_active = probes::active_levels(b.spatial.grid, active, p.spatial.receiver);
        p.spatial_levels = probes::active_clusters(p.spatial_active, p.spatial.cluster, p.spatial.clusters.size());
        run.reason = fmt::format("{} of {} places are computed, {} of {} clusters", std::count(active.begin(), active.end(), 1), active.size(),
                                 std::count(p.spatial_levels.begin(), p.spatial_levels.end(), 0), p.spatial_levels.size());
    };
    node.leave_out = [&p] { p.spatial_readers.clear(), p.spatial_active.clear(), p.spatial_levels.clear(); };
    nodes.push_back(std::move(node));
}

void add_volume(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    using probes::Bake;
    const auto named = [&](const std::string& form) {
        PlannedNode& node = nodes.back();
        set_form(node, form);
    };
    add_stage(c, nodes, "what clusters in the air get", "b", 4096, [](const Bake& b) { return glm::ivec2(b.spatial.flat.singular_values, b.spatial.flat.count()); },
              [&c, &p] {
                  probes::BasisInputs in = probes::basis_inputs(buffers_of(c));
                  in.clusters = &p.spatial, in.cluster_level = (p.lod.off() ? p.spatial_levels : p.air.cluster).data();
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
    gather.reads = [&p](graph::Reads& r) { r.image(p.spatial_irradiance), r.list(p.data.matrix), r.list(p.static_light), r.list(p.air.place); };
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
        if (!p.lod.off()) probes::fill_air(bake_of(c).spatial.grid, p.air.place, p.bounced);
        p.grid = p.bounced;
        for (std::size_t i = 0; i < p.static_light.size(); ++i) p.grid[i] += p.static_light[i];
    };
    gather.leave_out = [&p] { p.grid.clear(), p.bounced.clear(); };
    nodes.push_back(std::move(gather));
}

}  // namespace plumb::frame
