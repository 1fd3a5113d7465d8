// Indirect shadows of dynamic meshes, in frames of the method probes: spheres that stand for meshes, or rays against them.
#include <fmt/format.h>

#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/probes/bake.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/shadow_rays.h"

namespace plumb::frame {

namespace {

using probes::IndirectShadow;

IndirectShadow mode_of(const Context& c) { return c.settings.probe_run.indirect_shadow; }

double spheres_of(const Context& c) { return double(std::max<std::size_t>(probes::moving_groups(c.scene).size(), 1)) * c.settings.probe_run.shadow_spheres; }

PlannedNode begin_spheres(Context& c, const std::string& form, const std::string& why) {
    PlannedNode node = begin_node(c, probes::info_shadow_spheres().name, "probes shadow", why, 0, {});
    set_form(node, form);
    node.of_pixels = false, node.by_name = false;
    node.size = [] { return glm::ivec2(1, 1); };
    node.fill = [] {};
    return node;
}

// Depends on meshes in their own space alone: what only moves is fitted once.
void add_fit(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_spheres(c, "fit", "spheres in place of what moves");
    node.reads = [&c](graph::Reads& r) {
        r.value(c.settings.probe_run.shadow_spheres);
        for (const probes::MovingGroup& g : probes::moving_groups(c.scene)) {
            r.value(g.first, g.last);
            for (int i = g.first; i <= g.last; ++i) {
                const Mesh& mesh = c.scene.meshes[std::size_t(i)];
                r.value(mesh.share), r.list(mesh.triangles);
                for (const Vertex& v : mesh.vertices) r.value(v.position);
            }
        }
    };
    node.outputs = [&p] {
        Bundle b;
        for (std::size_t i = 0; i < p.fitted.size(); ++i)
            if (!p.fitted[i].empty()) lend(b, fmt::format("group_{}", i), {std::int64_t(p.fitted[i].size()), 4}, &p.fitted[i][0].x);
        return b;
    };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun& run) {
        p.fitted.clear();
        std::size_t count = 0;
        for (const probes::MovingGroup& g : probes::moving_groups(c.scene)) {
            p.fitted.push_back(probes::fit_spheres({&c.scene.meshes[std::size_t(g.first)], std::size_t(g.last - g.first + 1)}, c.settings.probe_run.shadow_spheres));
            count += p.fitted.back().size();
        }
        run.reason = fmt::format("{} spheres in place of what moves", count);
    };
    node.leave_out = [&p] { p.fitted.clear(); };
    nodes.push_back(std::move(node));
}

// Where they are, and what light they hide there.
void add_place(Context& c, bool spatial, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_spheres(c, "light", "the light that spheres hide");
    node.reads = [=, &c, &p](graph::Reads& r) {
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces);
        r.value(mode_of(c), spatial, c.settings.probe_run.shadow_spheres);
        for (const auto& f : p.fitted) r.list(f);
        r.list(p.grid), r.list(p.data.matrix);
    };
    node.outputs = [&p] {
        Bundle b;
        const probes::ShadowSpheres& s = p.shadow_spheres;
        lend(b, "spheres", {std::int64_t(s.rows.size()), 4}, s.rows.empty() ? nullptr : &s.rows[0].x);
        lend(b, "owner", {std::int64_t(s.owner.size()), 2}, s.owner.empty() ? nullptr : &s.owner[0].x);
        return b;
    };
    node.run = [=, &c, &p](const RunOptions& options, graph::NodeRun&) {
        p.shadow_spheres = probes::place_spheres(c.scene, probes::moving_groups(c.scene), p.fitted);
        if (!spatial || mode_of(c) == IndirectShadow::uniform) return;
        const std::vector<glm::vec3> reflects = mode_of(c) == IndirectShadow::reflecting ? probes::mean_reflectance(c.scene) : std::vector<glm::vec3>();
        probes::light_spheres(c.settings.bake->spatial.grid, p.grid, reflects, options, p.shadow_spheres);
    };
    node.leave_out = [&p] { p.shadow_spheres = {}; };
    nodes.push_back(std::move(node));
}

// What both ways of shading share: E is read from one image and E' written to another, and E' = E where the node is left out.
void shade(Context& c, PlannedNode& node) {
    ProbeBuffers& p = c.frame.probes;
    node.outputs = [&c] { return lent("shaded", c.frame.indirect); };
    node.leave_out = [&c, &p] { c.frame.indirect = p.unshaded; };
    node.reads_left_out = [&p](graph::Reads& r) { r.image(p.unshaded); };
    node.results = {{"irradiance", "shaded", "shaded"}};
}

void add_stage(Context& c, bool spatial, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const StageBinding& binding = stage<probes::IndirectShadowKernel>();
    PlannedNode node = begin_node(c, binding, "probes shadow", "what moves hides indirect light", double(c.size.x) * c.size.y * spheres_of(c));
    shade(c, node);
    const bool directional = spatial && mode_of(c) != IndirectShadow::uniform;
    const auto data = [=, &c, &p] {
        probes::IndirectShadowInputs in;
        in.position = &c.frame.gbuffer.position, in.normal = &c.frame.gbuffer.normal, in.irradiance = &p.unshaded;
        in.id = &c.frame.gbuffer.id, in.spheres = &p.shadow_spheres, in.directional = directional;
        return data_of(in);
    };
    node.dispatches = [=] { return std::vector<StageData>{data()}; };
    node.reads = [=, &binding](graph::Reads& r) { r.dispatch(binding, data()); };
    node.run = [=, &c, &binding](const RunOptions& options, graph::NodeRun& run) {
        plumb::run(binding, data(), options, c.frame.indirect);
        run.bytes = bytes_of(c.frame.indirect);
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, data(), at); };
    nodes.push_back(std::move(node));
}

void add_rays(Context& c, bool spatial, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const double rays = double(c.size.x) * c.size.y * c.settings.probe_run.shadow_rays;
    PlannedNode node = begin_node(c, probes::info_shadow_rays().name, "probes shadow", "what moves hides indirect light", rays, {150, "rays"});
    shade(c, node);
    node.reads = [=, &c, &p](graph::Reads& r) {
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces);
        r.value(spatial, c.settings.probe_run.shadow_rays);
        r.image(c.frame.gbuffer.position), r.image(c.frame.gbuffer.normal), r.image(p.unshaded);
        r.list(p.grid), r.list(p.data.matrix);
    };
    node.run = [=, &c, &p](const RunOptions& options, graph::NodeRun& run) {
        const auto world = probes::dynamic_world(c.scene, c.world().geometry);
        probes::ShadowRaysInputs in;
        in.world = world.get(), in.rays = c.settings.probe_run.shadow_rays, in.irradiance = &p.unshaded;
        in.position = &c.frame.gbuffer.position, in.normal = &c.frame.gbuffer.normal;
        if (spatial) in.grid = &c.settings.bake->spatial.grid, in.six = &p.grid;
        probes::run(in, options, c.frame.indirect);
        run.bytes = bytes_of(c.frame.indirect);
    };
    nodes.push_back(std::move(node));
}

}  // namespace

Image4& indirect_to_shade(Context& c) { return mode_of(c) == IndirectShadow::off ? c.frame.indirect : c.frame.probes.unshaded; }

void add_indirect_shadow(Context& c, bool spatial, Nodes& nodes) {
    if (mode_of(c) == IndirectShadow::off) return;
    if (mode_of(c) == IndirectShadow::rays) return add_rays(c, spatial, nodes);
    add_fit(c, nodes);
    add_place(c, spatial, nodes);
    add_stage(c, spatial, nodes);
}

}  // namespace plumb::frame
