// Irradiance probes at run time: from what relight rays meet, and the light there, to indirect light of every pixel.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/nodes_probes.h"

namespace plumb::frame {

const probes::Bake& bake_of(const Context& c) {
    if (!c.settings.bake) throw InputError("method probes: Settings::bake is missing");
    return *c.settings.bake;
}

bool pipelined(const Context& c) { return c.settings.probe_run.loop == probes::Loop::pipelined; }

bool has_volume(const Context& c) { return c.relief.dynamic || c.relief.fixed; }

PlannedNode begin_host(Context& c, const StageInfo& info, const std::string& why, glm::ivec2 size) {
    PlannedNode node = begin_node(c, info.name, "probes", why, 0, {});
    node.of_pixels = false, node.by_name = false;
    node.size = [=] { return size; };
    node.fill = [] {};
    return node;
}

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
    b.basis_level = &p.basis_level, b.tiles = &p.tiles;
    return b;
}

namespace {

// Rounds until further ones add no more than the tolerance; the stages after it make the last of them once more.
probes::Convergence run_rounds(Context& c, const RunOptions& options, Image4& before, ProbeBuffers& made) {
    probes::UpdateBuffers b = buffers_of(c);
    b.direct = &c.direct(1);
    b.radiance = &made.radiance, b.lambda = &made.lambda, b.basis = &made.basis, b.irradiance = &made.irradiance;
    b.lightmap = &made.lightmap, b.tiles = &made.tiles;
    made.tiles.wanted = c.frame.probes.tiles.wanted;
    try {
        return probes::converge(b, c.settings.probe_run, options, before);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", c.scene.name, error.what()));
    }
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
    p.last = {c.direct(1), made.lambda, std::move(made.basis), std::move(made.lightmap), made.lambda, made.lambda};
    if (c.settings.probe_run.start == probes::Start::converged) return;
    for (Image4* image : {&p.last.direct, &p.last.lambda, &p.last.basis, &p.last.lightmap, &p.last.lambda_2, &p.last.lambda_3})
        std::fill(image->texels.begin(), image->texels.end(), glm::vec4(0));
}

void read_pipeline(const ProbeBuffers::Pipeline& p, graph::Reads& r) {
    r.image(p.direct), r.image(p.lambda), r.image(p.basis), r.image(p.lightmap), r.image(p.lambda_2), r.image(p.lambda_3);
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

// Of the lightmap's node: it writes the tiles that are shown, and leaves 0 in the others. Who looks at its dispatch sees all of them.
void write_tiles(Context& c, PlannedNode& node) {
    ProbeBuffers& p = c.frame.probes;
    node.reads = [&c, &p, all = node.reads](graph::Reads& r) {
        all(r);
        r.list(p.cluster_level), r.value(pipelined(c), c.settings.pruning);
    };
    node.run = [&c, &p](const RunOptions& options, graph::NodeRun& run) {
        probes::write_lightmap(probes::lightmap_inputs(buffers_of(c)), options, p.tiles, p.lightmap);
        run.bytes = bytes_of(p.lightmap);
        const Buffer<std::uint8_t>& wanted = p.tiles.wanted.any;
        if (!p.lod.off()) run.reason += fmt::format("; {} of {} tiles are shown", std::count(wanted.begin(), wanted.end(), 1), wanted.size());
    };
    node.leave_out = [&p] { p.lightmap = {}, p.tiles.written = {}; };
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
    write_tiles(c, nodes.back());
}

void add_indirect(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    add_of_pixels(c, nodes, "where pixels lie on the lightmap", "uv",
                  [&c, &p] {
                      const View v = c.camera_view();
                      return probes::LightmapUvInputs{&c.frame.gbuffer.position, &c.frame.gbuffer.id, &p.charted,
                                                      probes::fragment_rule_at(p.lod, glm::vec3(v.eye), glm::vec3(v.forward))};
                  },
                  [&p]() -> Image4& { return p.uv; });
    add_of_pixels(c, nodes, "indirect light", "irradiance",
                  [&c, &p] { return probes::LookupInputs{&p.uv, pipelined(c) ? &p.last.lightmap : &p.lightmap, p.data.levels}; },
                  [&p]() -> Image4& { return p.looked_up; });
}

// What the next frame of a pipeline finds.
void add_latch(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_node(c, "pipeline", "", "", 0, {});
    node.listed = false;
    node.reads = [&c, &p](graph::Reads& r) {
        r.image(c.direct(1)), r.image(p.lambda), r.image(p.basis), r.image(p.lightmap), r.image(p.last.lambda), r.image(p.last.lambda_2);
    };
    node.outputs = [] { return Bundle(); };
    node.run = [&c, &p](const RunOptions&, graph::NodeRun&) { p.next = {c.direct(1), p.lambda, p.basis, p.lightmap, p.last.lambda, p.last.lambda_2}; };
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
    add_relief(c, nodes);
    add_indirect_shadow(c, has_volume(c), nodes);
    if (pipelined(c)) add_latch(c, nodes);
}

}  // namespace plumb::frame
