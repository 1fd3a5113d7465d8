// The picture: radiance, display, and the layers that are path traced.
#include <fmt/format.h>

#include "gi/compose/compose.h"
#include "gi/frame/frame_graph.h"
#include "gi/isr/isr.h"
#include "gi/reference/lights.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million paths (nodes_raster.cpp).
constexpr double ms_paths = 1000;

// What either composition reads.
template <class Inputs>
Inputs composed(Context& c) {
    const raster::GBuffer& g = c.frame.gbuffer;
    const Image4* emission = c.settings.method == Method::zbuffer ? &c.frame.zbuffer.sent
                             : c.relief.highlights              ? &c.frame.probes.relief.sent
                                                                : &g.emission;
    return {&g.normal, &g.albedo, emission, &c.frame.direct, &indirect_to_compose(c), c.scene.environment.radiance};
}

Traced* find_layer(Context& c, const std::string& layer) {
    for (Traced& traced : c.frame.traced)
        if (traced.layer == layer) return &traced;
    return nullptr;
}

Traced& put_layer(Context& c, Traced traced) {
    if (Traced* before = find_layer(c, traced.layer)) return *before = std::move(traced);
    return c.frame.traced.emplace_back(std::move(traced));
}

// The truth under the picture's tone curve.
void add_truth_display(Context& c, Nodes& nodes) {
    PlannedNode node = begin_node(c, "truth_display", "", "", 0, {});
    node.listed = false, node.of_layer = "truth";
    compute(c, node, c.settings.tonemap,
            [&c] { return compose::TonemapInputs{&find_layer(c, "truth")->estimate.mean}; },
            [&c]() -> Image4& { return c.frame.truth_display; });
    node.leave_out = [&c] { c.frame.truth_display = {}; };
    nodes.push_back(std::move(node));
}

}  // namespace

void add_compose(Context& c, Nodes& nodes) {
    const double pixels = double(c.size.x) * c.size.y;
    auto result = [&c]() -> Image4& { return composed_picture(c); };
    auto begin = [&](const StageBinding& binding) {
        PlannedNode node = begin_node(c, binding, "compose", "the picture", pixels);
        node.leave_out = [] {};  // another node makes it
        node.fill = [=, &c] {
            if (result().empty()) result() = Image4(c.size.x, c.size.y);
        };
        return node;
    };
    if (gathers_isr(c.settings)) {
        PlannedNode node = begin(stage<isr::ComposeKernel>());
        node.results = {{"result", "", "radiance"}};
        compute(c, node, c.settings.isr, [&c] { return composed<isr::ComposeInputs>(c); }, result);
        node.in_steps = true;
        return nodes.push_back(std::move(node));
    }
    PlannedNode node = begin(stage<compose::ComposeKernel>());
    compute(c, node, c.settings.compose, [&c] { return composed<compose::ComposeInputs>(c); }, result);
    nodes.push_back(std::move(node));
}

void add_tonemap(Context& c, Nodes& nodes) {
    PlannedNode node = begin_node(c, stage<compose::TonemapKernel>(), "tonemap", "the picture",
                                  double(c.size.x) * c.size.y);
    compute(c, node, c.settings.tonemap, [&c] { return compose::TonemapInputs{&c.frame.radiance}; },
            [&c]() -> Image4& { return c.frame.display; });
    nodes.push_back(std::move(node));
}

// Until the error is small enough, nobody knows how many samples that takes: what is expected is the number that is given
// all the same.
void add_traced(Context& c, const std::string& layer, const std::string& why, Nodes& nodes) {
    const reference::PathParams& p = c.settings.reference;
    std::string reason = why;
    if (p.until_error > 0)
        reason += fmt::format("; until its error is {} of its mean, at most {} samples", p.until_error, p.max_samples);
    PlannedNode node = begin_node(c, reference::info().name, layer, reason, double(c.size.x) * c.size.y * p.samples,
                                  {ms_paths, "paths"});
    node.plan.layer = layer;
    node.plan.samples = p.until_error > 0 ? 0 : p.samples;
    const bool picture = layer == "color";
    if (!picture) node.plan.label = layer;

    node.reads = node.reads_left_out = [=, &c](graph::Reads& r) {
        reference::PathParams params = c.settings.reference;
        r.fields(reference::fields(params));
        r.source("all that rays meet", c.keys.paths);
        r.value(c.settings.seed);
        if (own_transport(layer)) r.image(c.frame.gbuffer.position), r.image(c.frame.gbuffer.normal);
        if (layer == "truth.ao") r.value(c.settings.ao.radius);
        if (layer == "truth.reflection") r.image(c.frame.gbuffer.position), r.image(c.frame.gbuffer.normal), r.image(c.frame.gbuffer.id);
        if (layer == "truth.reflection") r.value(c.settings.reflect.lobe);
        const auto& [position, look_at, up, fov_y_deg, near, far, reversed_z] = c.scene.camera;
        r.value(position, look_at, up, fov_y_deg, near, far, reversed_z);
        if (params.rays == Rays::native) r.value(c.isa);
    };
    node.inputs = [=, &c] {
        const bool own = own_transport(layer);
        const Scene seen = own ? lamps_only(c.scene) : c.scene;
        const raster::Surfaces surfaces = raster::prepare(seen, c.world().geometry);
        const auto table = reference::light_table(seen, c.world().geometry, surfaces,
                                                  reference::environment_table(seen.environment));
        Bundle b;
        lend_surfaces(c.world().geometry, surfaces, b);
        for (Array& array : b.arrays)  // the surfaces are this function's
            for (const char* name : {"materials", "textures", "texels", "decode"})
                if (array.name == name) array.bytes.own();
        add(b, "lights", {std::int64_t(table.count), 16}, table.rows.data());
        if (own) lend(b, "position", c.frame.gbuffer.position), lend(b, "normal", c.frame.gbuffer.normal);
        return b;
    };
    node.outputs = [=, &c] {
        Bundle b;
        if (const Traced* traced = find_layer(c, layer))
            lend(b, "truth", traced->estimate.mean), lend(b, "truth.error", traced->estimate.error);
        if (picture) lend(b, "radiance", c.frame.radiance);
        return b;
    };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun& run) {
        const Image4& mean = put_layer(c, c.tracer->trace(layer, c.frame.gbuffer, options)).estimate.mean;
        if (picture) c.frame.radiance = mean;
        run.bytes = 2 * bytes_of(mean);
    };
    node.leave_out = [=, &c] { put_layer(c, c.tracer->dark(layer)); };
    if (picture) node.reuse = [=, &c] { c.frame.radiance = find_layer(c, layer)->estimate.mean; };
    node.fill = [] {};
    nodes.push_back(std::move(node));
    if (layer == "truth") add_truth_display(c, nodes);
}

}  // namespace plumb::frame
