// What is known of a bake, and what its relight rays meet: materials, emission, levels of detail.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/filters.h"
#include "gi/frame/nodes_probes.h"
#include "gi/probes/atlas_room.h"
#include "gi/probes/basis_kernel.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/shadow_rays.h"

namespace plumb::frame {

namespace {

// Of the lightmap. What a pipeline writes the next frame reads, which may look from elsewhere.
raster::Covered wanted_tiles(const Context& c) {
    const ProbeBuffers& p = c.frame.probes;
    if (!c.settings.pruning) return raster::Covered(p.data.lightmap_size, 1);
    return probes::tiles_to_write(p.data.tiles, pipelined(c) ? std::vector<std::int32_t>() : p.cluster_level);
}

void add_data(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    PlannedNode node = begin_host(c, probes::info_run_data(), "what is known of the scene", {1, 1});
    if (!c.settings.bake) {
        const probes::BakeParams& params = c.settings.probes;
        const probes::ExpectedBake expected = probes::expected_bake(c.scene, params);
        try {
            if (params.lightmap_size == 0) probes::require_room(expected.area_m2, double(params.receivers_per_m2));
        } catch (const InputError& error) {
            throw InputError(fmt::format("{}: {}", c.scene.name, error.what()));
        }
        node.plan.reason = text_of(expected), node.plan.expected_ms = expected.ms;
    }
    node.reads = [&c](graph::Reads& r) {
        r.source("bake", c.bake_key);
        // Which triangles stand still; where the others are is nothing to it.
        for (const Mesh& mesh : c.scene.meshes) r.value(mesh.dynamic, mesh.triangles.size(), mesh.share);
        probes::LodParams lod = c.settings.lod;
        r.fields(probes::fields(lod));
        r.value(c.settings.probe_run.window, c.settings.probe_run.unasked, has_volume(c), c.settings.pruning);
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
        p.last = p.next = {};  // of other sizes
        p.probe_level.assign(std::size_t(p.data.probes), 0), p.cluster_level.assign(p.data.clusters.size(), 0);
        p.basis_level = p.cluster_level, p.tiles = {wanted_tiles(c), {}};
        run.bytes = (p.data.matrix.size() + p.data.u.size()) * sizeof(float);
        run.reason = fmt::format("{} receivers, {} probes, {} clusters, lightmap {} x {}", p.data.count(), p.data.probes,
                                 p.data.clusters.size(), b.atlas.size.x, b.atlas.size.y);
        for (const std::string& note : p.lod.notes) run.reason += "; " + note;
        const bool moves = std::any_of(c.scene.meshes.begin(), c.scene.meshes.end(), [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); });
        if (moves && b.spatial.empty()) run.reason += "; no spatial receivers: what moves gets no indirect light";
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
        r.source("bake", c.bake_key);
        r.source("surfaces", c.keys.surfaces), r.source("emission", c.keys.emission);
        r.value(c.scene.environment.radiance, int(c.scene.environment.filter), c.settings.probe_run.unasked);
        r.image(c.scene.environment.map);
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
        const probes::RunParams& params = c.settings.probe_run;
        const bool moves = params.relight_dynamic;
        probes::HitSurfaces made = probes::hit_surfaces(c.scene, bake_of(c), options, moves ? probes::Unasked::black : params.unasked, !drops_normal_maps(c.settings));
        if (moves) {
            const std::size_t met = probes::meet_dynamic(*probes::dynamic_world(c.scene, c.world().geometry), bake_of(c), options, made);
            probes::stand_in(probes::stand_ins(bake_of(c), params.unasked, options), made);  // for what is found now
            run.reason = fmt::format("light is gathered there; {} rays end on what moves", met);
        }
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

// Of spatial receivers; none where nothing reads them.
void take_air_levels(Context& c, probes::AirLevels levels, graph::NodeRun& run) {
    ProbeBuffers& p = c.frame.probes;
    const probes::SpatialGrid& grid = bake_of(c).spatial.grid;
    p.air = std::move(levels);
    if (p.air.place.empty())
        p.air = probes::air_levels(grid, {}, {}, {}, int(p.spatial.clusters.size()));
    std::vector<std::uint8_t> computed;
    for (const std::int32_t level : p.air.place) computed.push_back(level != probes::no_level ? 1 : 0);
    p.air_active = probes::active_levels(grid, computed, p.spatial.receiver, p.lod.levels - 1);
    const auto read = probes::active_places(grid, p.spatial_readers);
    const auto n = probes::air_counts(p.lod, bake_of(c), p.air);
    run.reason += fmt::format(", {} places in the air for {} that are read, by clusters of levels 0 to {}: {}", std::count(computed.begin(), computed.end(), 1),
                              std::count(read.begin(), read.end(), 1), p.lod.levels - 1, fmt::join(n.clusters.begin(), n.clusters.begin() + p.lod.levels, ", "));
}

// Levels of detail of clusters and probes, and of the hits' lookups.
void add_levels(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    const StageBinding& binding = stage<probes::LevelKernel>();
    PlannedNode node = begin_node(c, binding, "probes", "what is far takes less", double(c.views[1].size.y) * 2);
    node.of_pixels = false;
    const auto view = [&c] { return c.camera_view(); };
    const auto clusters = [&p, view] {
        const View v = view();
        probes::LevelInputs in{&p.boxes.cluster_low, &p.boxes.cluster_high, probes::rule_at(p.lod, glm::vec3(v.eye), glm::vec3(v.forward))};
        return data_of(in);
    };
    node.size = [&p] { return glm::ivec2(int(p.boxes.cluster_low.size()), 1); };
    node.dispatches = [=] { return std::vector<StageData>{clusters()}; };
    node.reads = [&c, &p, view](graph::Reads& r) {
        const View v = view();
        r.value(v.eye, v.forward, pipelined(c), c.settings.pruning);
        r.list(p.data.matrix), r.image(p.place);
        if (has_volume(c)) r.list(p.spatial_readers);
    };
    node.outputs = [&p] {
        Bundle b;
        lend(b, "level", {std::int64_t(p.cluster_level.size()), 1}, p.cluster_level.data());
        lend(b, "basis_level", {std::int64_t(p.basis_level.size()), 1}, p.basis_level.data());
        lend(b, "probe_level", {std::int64_t(p.probe_level.size()), 1}, p.probe_level.data());
        lend(b, "place", p.placed);
        const auto list = [&b](const char* name, const std::vector<std::int32_t>& values) {
            lend(b, name, {std::int64_t(values.size())}, values.data());
        };
        list("air_level", p.air.cluster), list("air_place", p.air.place), list("air_active", p.air_active);
        return b;
    };
    node.run = [&c, &p, view](const RunOptions& options, graph::NodeRun& run) {
        const View v = view();
        probes::Levels levels = probes::levels_at(p.lod, bake_of(c), p.boxes, glm::vec3(v.eye), glm::vec3(v.forward), options,
                                                  has_volume(c) ? probes::air_reads(bake_of(c).spatial.grid, p.spatial_readers) : probes::AirReads());
        p.cluster_level = levels.cluster, p.probe_level = levels.probe;
        // In a pipeline the next frame's receivers read the basis.
        p.basis_level = pipelined(c) || !c.settings.pruning ? p.cluster_level : probes::basis_levels(p.data, p.cluster_level);
        p.tiles.wanted = wanted_tiles(c);
        p.placed = p.place;
        for (std::size_t i = 0; i < levels.hit.size(); ++i) p.placed.texels[i].z = float(levels.hit[i]);
        const probes::LodCounts counts = probes::lod_counts(p.lod, bake_of(c), levels);
        run.reason = fmt::format("{} of {} receivers are computed", counts.receivers, p.data.count());
        if (has_volume(c)) take_air_levels(c, std::move(levels.air), run);
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, clusters(), at); };
    node.leave_out = [&p] { p.placed = {}, p.air = {}, p.air_active.clear(); };
    node.fill = [] {};
    node.results = {};
    nodes.push_back(std::move(node));
}

}  // namespace

void add_probe_hits(Context& c, int view, Nodes& nodes) {
    add_data(c, nodes);
    add_surfaces(c, view, nodes);
    if (has_volume(c)) add_active(c, nodes);
    if (c.settings.lod.levels > 1) add_levels(c, nodes);
}

}  // namespace plumb::frame
