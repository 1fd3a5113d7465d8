// What moves: spatial receivers near it, and what its pixels read of them.
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
    };
    node.outputs = [&p] {
        Bundle b;
        lend(b, "level", {std::int64_t(p.spatial_active.size())}, p.spatial_active.data());
        return b;
    };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun& run) {
        const probes::Bake& b = bake_of(c);
        const auto active = probes::active_places(b.spatial.grid, probes::dynamic_boxes(c.scene));
        p.spatial_active = probes::active_levels(b.spatial.grid, active, p.spatial.receiver);
        run.reason = fmt::format("{} of {} places are computed", std::count(active.begin(), active.end(), 1), active.size());
    };
    node.leave_out = [&p] { p.spatial_active.clear(); };
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
                  return in;
              },
              [&p]() -> Image4& { return p.spatial_basis; });
    named("spatial");
    add_stage(c, nodes, "what receivers in the air get", "irradiance", 4096, [](const Bake& b) { return probes::irradiance_size(b.spatial.receivers.count()); },
              [&p] { return spatial_inputs(p); }, [&p]() -> Image4& { return p.spatial_irradiance; });
    named("spatial");
    PlannedNode gather = begin_node(c, "grid", "", "", 0, {});
    gather.listed = false;
    gather.reads = [&p](graph::Reads& r) { r.image(p.spatial_irradiance), r.list(p.data.matrix); };
    gather.outputs = [&p] {
        Bundle b;
        lend(b, "grid", {std::int64_t(p.grid.size()), 4}, p.grid.empty() ? nullptr : &p.grid[0].x);
        return b;
    };
    gather.run = [&c, &p](const RunOptions&, graph::NodeRun&) {
        probes::gather_grid(bake_of(c).spatial.grid, p.spatial.receiver, p.spatial_irradiance.texels, p.grid);
    };
    gather.leave_out = [&p] { p.grid.clear(); };
    nodes.push_back(std::move(gather));
}

namespace {

probes::VolumeInputs volume_inputs(Context& c) {
    ProbeBuffers& p = c.frame.probes;
    probes::VolumeInputs in;
    in.grid = bake_of(c).spatial.grid, in.form = c.settings.probe_run.volume;
    in.position = &c.frame.gbuffer.position, in.normal = &c.frame.gbuffer.normal, in.lightmap_uv = &p.uv, in.irradiance = &p.grid;
    return in;
}

}  // namespace

void add_volume_of_pixels(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    add_of_pixels(c, nodes, "indirect light of what moves", "irradiance", [&c] { return volume_inputs(c); },
                  [&p]() -> Image4& { return p.volume.irradiance; });
    PlannedNode& node = nodes.back();
    node.outputs = [&p] {
        Bundle b;
        lend(b, "irradiance", p.volume.irradiance), lend(b, "light", p.volume.light), lend(b, "from_light", p.volume.from_light);
        return b;
    };
    node.run = [&c, &p](const RunOptions& options, graph::NodeRun& run) {
        probes::run(volume_inputs(c), options, p.volume);
        run.bytes = 3 * bytes_of(p.volume.irradiance);
    };
    node.leave_out = [&p, size = c.size] { p.volume.irradiance = p.volume.light = p.volume.from_light = Image4(size.x, size.y); };
    // Static pixels have the lightmap's, others the grid's.
    PlannedNode join = begin_node(c, "indirect", "", "", 0, {});
    join.listed = false;
    join.reads = [&p](graph::Reads& r) { r.image(p.looked_up), r.image(p.volume.irradiance); };
    join.outputs = [&c] { return lent("irradiance", indirect_to_shade(c)); };
    join.run = [&c, &p](const RunOptions&, graph::NodeRun&) {
        Image4& joined = indirect_to_shade(c);
        joined = p.looked_up;
        for (std::size_t i = 0; i < joined.size(); ++i)
            if (p.volume.irradiance.texels[i].w > 0) joined.texels[i] = glm::vec4(glm::vec3(p.volume.irradiance.texels[i]), 0);
    };
    join.leave_out = [&c] { indirect_to_shade(c) = Image4(c.size.x, c.size.y); };
    nodes.push_back(std::move(join));
}

}  // namespace plumb::frame
