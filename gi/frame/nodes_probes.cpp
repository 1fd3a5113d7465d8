// Irradiance probes at run time: from what relight rays meet, and the light there, to indirect light of every pixel.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/isr.h"
#include "gi/probes/bake.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lod.h"
#include "gi/probes/lookup.h"
#include "gi/probes/run_loop.h"
#include "gi/probes/run_stages.h"
#include "gi/probes/shadow_rays.h"
#include "gi/probes/spatial.h"

namespace plumb::frame {

namespace {

const probes::Bake& bake_of(const Context& c) {
    if (!c.settings.bake) throw InputError("method probes: Settings::bake is missing");
    return *c.settings.bake;
}

bool pipelined(const Context& c) { return c.settings.probe_run.loop == probes::Loop::pipelined; }

// Whether something moves that spatial receivers light.
bool has_volume(const Context& c) {
    const auto moves = [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); };
    return std::any_of(c.scene.meshes.begin(), c.scene.meshes.end(), moves) && (!c.settings.bake || !c.settings.bake->spatial.empty());
}

PlannedNode begin_host(Context& c, const StageInfo& info, const std::string& why, glm::ivec2 size) {
    PlannedNode node = begin_node(c, info.name, "probes", why, 0, {});
    node.of_pixels = false, node.by_name = false;
    node.size = [=] { return size; };
    node.fill = [] {};
    return node;
}

// The node of a stage of the lightmap's update. size(bake): of its domain. inputs(): its typed inputs.
template <class SizeOf, class InputsOf, class To>
void add_stage(Context& c, Nodes& nodes, const std::string& why, const std::string& tap, double turns, SizeOf size, InputsOf inputs, To result) {
    using Kernel = typename decltype(inputs())::Kernel;
    const StageBinding& binding = stage<Kernel>();
    PlannedNode node = begin_node(c, binding, "probes", why, turns);
    node.of_pixels = false;
    node.size = [=, &c] { return c.settings.bake ? size(*c.settings.bake) : glm::ivec2(0); };
    node.dispatches = [=] { return std::vector<StageData>{data_of(inputs())}; };
    node.reads = [=, &binding](graph::Reads& r) { r.dispatch(binding, data_of(inputs())); };
    node.outputs = [=, &binding] { return lent(binding.outputs[0].name, result()); };
    node.run = [=, &binding](const RunOptions& options, graph::NodeRun& run) {
        plumb::run(binding, data_of(inputs()), options, result());
        run.bytes = bytes_of(result());
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, data_of(inputs()), at); };
    node.leave_out = [=] { result() = {}; };
    node.fill = [] {};
    node.results = {{binding.outputs[0].name, binding.outputs[0].name, tap}};
    nodes.push_back(std::move(node));
}

}  // namespace

// ---- What does not depend on light ------------------------------------------------------------------------------------

namespace {

void add_data(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_host(c, probes::info_run_data(), c.settings.bake ? "what is known of the scene" : text_of(probes::expected_bake(c.scene, c.settings.probes)), {1, 1});
    if (!c.settings.bake) node.plan.expected_ms = probes::expected_bake(c.scene, c.settings.probes).ms;
    node.reads = [&c](graph::Reads& r) {
        if (r.hashes()) r.source("bake", probes::bake_key(bake_of(c)));
        // Which triangles stand still; where the others are is nothing to it.
        for (const Mesh& mesh : c.scene.meshes) r.value(mesh.dynamic, mesh.triangles.size(), mesh.share);
        probes::LodParams lod = c.settings.lod;
        r.fields(probes::fields(lod));
        r.value(c.settings.probe_run.window, c.settings.probe_run.unasked);
    };
    node.outputs = [&p] { return probes::lent(p.data, p.charted, p.harmonics, p.weights); };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun& run) {
        const probes::Bake& b = bake_of(c);
        p.lod = probes::lod_of(c.settings.lod, b);
        p.data = probes::run_data(b, p.lod.levels);
        p.charted = probes::charted_triangles(c.scene, c.world().geometry, b.atlas);
        p.harmonics = probes::windowed(b.harmonics, b.params.degree, c.settings.probe_run.window);
        p.weights = p.lod.off() ? b.relight_weights
                                : probes::level_weights(b.relight_directions, {p.lod.rays.begin(), p.lod.rays.begin() + p.lod.levels});
        p.boxes = p.lod.off() ? probes::LodBoxes() : probes::lod_boxes(b, c.settings.probe_run.unasked);
        p.spatial = has_volume(c) ? probes::cluster_data(b.spatial.flat, b.spatial.receivers.count(), b.coefficients()) : probes::ClusterData();
        p.spatial_levels.assign(p.spatial.clusters.size(), 0);
        p.last = p.next = {};  // of other sizes
        p.probe_level.assign(std::size_t(p.data.probes), 0), p.cluster_level.assign(p.data.clusters.size(), 0);
        run.bytes = (p.data.matrix.size() + p.data.u.size()) * sizeof(float);
        run.reason = fmt::format("{} receivers, {} probes, {} clusters, lightmap {} x {}", p.data.count(), p.data.probes,
                                 p.data.clusters.size(), b.atlas.size.x, b.atlas.size.y);
    };
    node.leave_out = [&p] { p = {}; };
    nodes.push_back(std::move(node));
}

void add_surfaces(Context& c, int view, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_host(c, probes::info_hit_surfaces(), "light is gathered there", c.views[std::size_t(view)].size);
    set_view(c, node, view);
    node.plan.reason = "light is gathered there";
    node.reads = [&c](graph::Reads& r) {
        if (r.hashes()) r.source("bake", probes::bake_key(bake_of(c)));
        r.source("surfaces", c.keys.surfaces), r.source("emission", c.keys.emission);
        r.value(c.scene.environment.radiance, c.settings.probe_run.unasked), r.image(c.scene.environment.map);
        r.value(c.settings.probe_run.relight_dynamic);
        if (c.settings.probe_run.relight_dynamic) r.source("geometry", c.keys.geometry);
    };
    node.outputs = [&c, &p, view] {
        Bundle b;
        const raster::GBuffer& g = c.gbuffer(view);
        lend(b, "position", g.position), lend(b, "normal", g.normal);
        lend(b, "surface", p.surface), lend(b, "emitted", p.emitted), lend(b, "place", p.place);
        return b;
    };
    node.run = [&c, &p, view](const RunOptions& options, graph::NodeRun& run) {
        probes::HitSurfaces made = probes::hit_surfaces(c.scene, bake_of(c), options, c.settings.probe_run.unasked);
        if (c.settings.probe_run.relight_dynamic)
            run.reason = fmt::format("light is gathered there; {} rays end on what moves", probes::meet_dynamic(*probes::dynamic_world(c.scene), bake_of(c), options, made));
        raster::GBuffer& g = c.gbuffer(view);
        g.position = std::move(made.position), g.normal = std::move(made.normal);
        g.covered = covered_by(g.normal);
        p.surface = std::move(made.surface), p.emitted = std::move(made.emitted), p.place = std::move(made.place);
        run.bytes = 5 * bytes_of(p.surface);
    };
    node.leave_out = [&c, view, size = c.views[std::size_t(view)].size] {
        raster::GBuffer& g = c.gbuffer(view);
        g.position = g.normal = Image4(size.x, size.y);
        g.covered = raster::Covered(size);
    };
    nodes.push_back(std::move(node));
}

// Levels of detail of clusters and probes, and of the hits' lookups.
void add_levels(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const StageBinding& binding = stage<probes::LevelKernel>();
    PlannedNode node = begin_node(c, binding, "probes", "what is far takes less", double(c.views[1].size.y) * 2);
    node.of_pixels = false;
    const auto view = [&c] { return make_view(c.scene.camera, double(c.size.x) / c.size.y, c.scene.convention, c.size); };
    const auto clusters = [&p, view] {
        const View v = view();
        probes::LevelInputs in{&p.boxes.cluster_low, &p.boxes.cluster_high, probes::rule_at(p.lod, glm::vec3(v.eye), glm::vec3(v.forward))};
        return data_of(in);
    };
    node.size = [&p] { return glm::ivec2(int(p.boxes.cluster_low.size()), 1); };
    node.dispatches = [=] { return std::vector<StageData>{clusters()}; };
    node.reads = [&p, view](graph::Reads& r) {
        const View v = view();
        r.value(v.eye, v.forward);
        r.list(p.data.matrix), r.image(p.place);
    };
    node.outputs = [&p] {
        Bundle b;
        lend(b, "level", {std::int64_t(p.cluster_level.size()), 1}, p.cluster_level.data());
        lend(b, "probe_level", {std::int64_t(p.probe_level.size()), 1}, p.probe_level.data());
        lend(b, "place", p.placed);
        return b;
    };
    node.run = [&c, &p, view](const RunOptions& options, graph::NodeRun& run) {
        const View v = view();
        const probes::Levels levels = probes::levels_at(p.lod, bake_of(c), p.boxes, glm::vec3(v.eye), glm::vec3(v.forward), options);
        p.cluster_level = levels.cluster, p.probe_level = levels.probe;
        p.placed = p.place;
        for (std::size_t i = 0; i < levels.hit.size(); ++i) p.placed.texels[i].z = float(levels.hit[i]);
        const probes::LodCounts counts = probes::lod_counts(p.lod, bake_of(c), levels);
        run.reason = fmt::format("{} of {} receivers are computed", counts.receivers, p.data.count());
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, clusters(), at); };
    node.leave_out = [&p] { p.placed = {}; };
    node.fill = [] {};
    node.results = {};
    nodes.push_back(std::move(node));
}

}  // namespace

void add_probe_hits(Context& c, int view, Nodes& nodes) {
    add_data(c, nodes);
    add_surfaces(c, view, nodes);
    if (c.settings.lod.levels > 1) add_levels(c, nodes);
}

// ---- The lightmap, and what pixels read of it ------------------------------------------------------------------------

namespace {

// Where each stage of an update reads and writes: in a pipeline it reads what the frame before has left.
probes::UpdateBuffers buffers_of(Context& c) {
    ProbeBuffers& p = c.frame.probes;
    const bool behind = pipelined(c);
    probes::UpdateBuffers b;
    b.data = &p.data, b.harmonics = &p.harmonics, b.weights = &p.weights;
    b.probe_level = &p.probe_level, b.cluster_level = &p.cluster_level;
    b.counts = {p.lod.levels, p.lod.rays, p.lod.coefficients};
    b.feedback = c.settings.probe_run.feedback, b.constant = c.settings.probe_run.reflection;
    b.surface = &p.surface, b.emitted = &p.emitted, b.place = p.lod.off() ? &p.place : &p.placed;
    b.direct = behind ? &p.last.direct : &c.direct(1);
    b.last_lightmap = behind ? &p.last.lightmap : &p.before;
    b.radiance = &p.radiance, b.lambda = &p.lambda, b.basis = &p.basis, b.irradiance = &p.irradiance, b.lightmap = &p.lightmap;
    b.read_lambda = behind ? &p.last.lambda : &p.lambda;
    b.read_basis = behind ? &p.last.basis : &p.basis;
    return b;
}

// Rounds until further ones add no more than the tolerance; the stages after it make the last of them once more.
probes::Convergence run_rounds(Context& c, const RunOptions& options, Image4& before, ProbeBuffers& made) {
    probes::UpdateBuffers b = buffers_of(c);
    b.direct = &c.direct(1);
    b.radiance = &made.radiance, b.lambda = &made.lambda, b.basis = &made.basis, b.irradiance = &made.irradiance;
    b.lightmap = &made.lightmap;
    return probes::converge(b, c.settings.probe_run, options, before);
}

// What the frame before has left; the first frame of a pipeline finds what has converged, or black.
void begin_pipeline(Context& c, const RunOptions& options, graph::NodeRun& run) {
    ProbeBuffers& p = c.frame.probes;
    if (!p.next.lightmap.empty()) {
        p.last = p.next;
        return;
    }
    ProbeBuffers made;
    Image4 before;
    run.reason = text_of(run_rounds(c, options, before, made));
    p.last = {c.direct(1), std::move(made.lambda), std::move(made.basis), std::move(made.lightmap)};
    if (c.settings.probe_run.start == probes::Start::converged) return;
    for (Image4* image : {&p.last.direct, &p.last.lambda, &p.last.basis, &p.last.lightmap})
        std::fill(image->texels.begin(), image->texels.end(), glm::vec4(0));
}

void read_pipeline(const ProbeBuffers::Pipeline& p, graph::Reads& r) {
    r.image(p.direct), r.image(p.lambda), r.image(p.basis), r.image(p.lightmap);
}

void add_rounds(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const bool behind = pipelined(c);
    PlannedNode node = begin_host(c, probes::info_rounds(), behind ? "what the frame before left" : "light is reflected again and again", {1, 1});
    node.reads = [=, &c, &p](graph::Reads& r) {
        const probes::RunParams& params = c.settings.probe_run;
        r.value(params.tolerance, params.rounds, params.feedback, params.reflection, behind);
        r.list(p.data.matrix), r.list(p.data.u), r.list(p.harmonics), r.list(p.weights);
        r.image(p.surface), r.image(p.emitted), r.image(p.lod.off() ? p.place : p.placed), r.image(c.direct(1));
        r.list(p.probe_level), r.list(p.cluster_level);
        if (behind) r.value(params.start), read_pipeline(p.next, r);
    };
    // What lies there counts by its content: the end of each frame writes it anew.
    node.outputs = [=, &p] { return behind ? Bundle() : lent("lightmap", p.before); };
    node.run = [=, &c, &p](const RunOptions& options, graph::NodeRun& run) {
        if (behind) return begin_pipeline(c, options, run);
        ProbeBuffers made;
        p.converged = run_rounds(c, options, p.before, made);
        run.reason = text_of(p.converged);
        run.bytes = bytes_of(p.before);
    };
    node.leave_out = [&p] { p.before = {}, p.last = p.next = {}; };
    nodes.push_back(std::move(node));
}

void add_update(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const double hits = double(c.views[1].size.x) * c.views[1].size.y;
    const double coefficients = c.settings.bake ? double(c.settings.bake->coefficients()) : 64;
    const double receivers = c.settings.bake ? double(c.settings.bake->receivers.count()) : 65536;
    const double side = c.settings.bake ? double(c.settings.bake->atlas.size.x) : 512;
    using probes::Bake;
    add_stage(c, nodes, "what relight rays bring", "f", hits, [](const Bake& b) { return glm::ivec2(b.relight.rays, b.relight.probes); },
              [&c] { return probes::radiance_inputs(buffers_of(c)); }, [&p]() -> Image4& { return p.radiance; });
    add_stage(c, nodes, "what probes see", "lambda", hits * coefficients,
              [](const Bake& b) { return glm::ivec2(b.coefficients(), b.relight.probes); },
              [&c] { return probes::lambda_inputs(buffers_of(c)); }, [&p]() -> Image4& { return p.lambda; });
    add_stage(c, nodes, "what clusters get", "b", receivers, [](const Bake& b) { return glm::ivec2(b.flat.singular_values, b.flat.count()); },
              [&c] { return probes::basis_inputs(buffers_of(c)); }, [&p]() -> Image4& { return p.basis; });
    add_stage(c, nodes, "what receivers get", "irradiance", receivers * 32, [](const Bake& b) { return probes::irradiance_size(b.receivers.count()); },
              [&c] { return probes::irradiance_inputs(buffers_of(c)); }, [&p]() -> Image4& { return p.irradiance; });
    const int levels = c.settings.lod.levels;
    add_stage(c, nodes, "the lightmap", "lightmap", side * side,
              [=](const Bake& b) { return glm::ivec2(b.atlas.size.x, probes::lightmap_rows(b.atlas.size.x, levels)); },
              [&c] { return probes::lightmap_inputs(buffers_of(c)); }, [&p]() -> Image4& { return p.lightmap; });
}

// Of what pixels of the frame read.
template <class InputsOf, class To>
void add_of_pixels(Context& c, Nodes& nodes, const std::string& why, const std::string& tap, InputsOf inputs, To result) {
    add_stage(c, nodes, why, tap, double(c.size.x) * c.size.y, [size = c.size](const probes::Bake&) { return size; }, inputs, result);
    PlannedNode& node = nodes.back();
    node.of_pixels = true;
    node.leave_out = [=, size = c.size] { result() = Image4(size.x, size.y); };
    node.fill = {};
}

// The update of spatial receivers near dynamic meshes, and what pixels of these read.
probes::IrradianceInputs spatial_inputs(ProbeBuffers& p) {
    probes::IrradianceInputs in;
    in.clusters = &p.spatial, in.cluster_level = p.spatial_levels.data(), in.receiver_level = p.spatial_active.data(), in.basis = p.spatial_basis.data();
    return in;
}

void add_active(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_host(c, probes::info_active(), "spatial receivers near what moves", {1, 1});
    node.reads = [&c, &p](graph::Reads& r) {
        if (r.hashes()) r.source("bake", probes::bake_key(bake_of(c)));
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

probes::VolumeInputs volume_inputs(Context& c) {
    ProbeBuffers& p = c.frame.probes;
    probes::VolumeInputs in;
    in.grid = bake_of(c).spatial.grid, in.form = c.settings.probe_run.volume;
    in.position = &c.frame.gbuffer.position, in.normal = &c.frame.gbuffer.normal, in.lightmap_uv = &p.uv, in.irradiance = &p.grid;
    return in;
}

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

void add_indirect(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const bool volume = has_volume(c);
    add_of_pixels(c, nodes, "where pixels lie on the lightmap", "uv",
                  [&c, &p] {
                      const View v = make_view(c.scene.camera, double(c.size.x) / c.size.y, c.scene.convention, c.size);
                      return probes::LightmapUvInputs{&c.frame.gbuffer.position, &c.frame.gbuffer.id, &p.charted,
                                                      probes::fragment_rule_at(p.lod, glm::vec3(v.eye), glm::vec3(v.forward))};
                  },
                  [&p]() -> Image4& { return p.uv; });
    add_of_pixels(c, nodes, "indirect light", "irradiance",
                  [&c, &p] { return probes::LookupInputs{&p.uv, pipelined(c) ? &p.last.lightmap : &p.lightmap, p.data.levels}; },
                  [&c, &p, volume]() -> Image4& { return volume ? p.looked_up : indirect_to_shade(c); });
    if (volume) add_volume_of_pixels(c, nodes);
}

// What the next frame of a pipeline finds.
void add_latch(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_node(c, "pipeline", "", "", 0, {});
    node.listed = false;
    node.reads = [&c, &p](graph::Reads& r) {
        r.image(c.direct(1)), r.image(p.lambda), r.image(p.basis), r.image(p.lightmap);
    };
    node.outputs = [] { return Bundle(); };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun&) { p.next = {c.direct(1), p.lambda, p.basis, p.lightmap}; };
    node.leave_out = [] {};
    nodes.push_back(std::move(node));
}

}  // namespace

void add_probes(Context& c, Nodes& nodes) {
    if (!lights_probes(c.settings)) return;
    add_rounds(c, nodes);
    add_update(c, nodes);
    if (has_volume(c)) add_volume(c, nodes);
    add_indirect(c, nodes);
    add_indirect_shadow(c, has_volume(c), nodes);
    if (pipelined(c)) add_latch(c, nodes);
}

}  // namespace plumb::frame
