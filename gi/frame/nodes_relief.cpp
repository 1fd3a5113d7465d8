// What pixels of the method probes make of the lightmap and of the grid in the air: indirect light of what moves, normal maps,
// highlights, the layers of IPR figure 5.20, and lamps that what moves sees by the grid alone.
#include <fmt/format.h>

#include <algorithm>

#include "core/host_math.h"
#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "gi/frame/frame_graph.h"
#include "gi/probes/bake.h"
#include "gi/probes/run_stages.h"
#include "gi/probes/static_light.h"
#include "gi/reference/ray_query.h"
#include "raster/bindings.h"
#include "raster/screen_triangle.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million triangles and pixels, as nodes_raster.cpp has them.
constexpr double ms_pixels = 60;


// A join of images that other nodes made, pixel by pixel: it has no row of its own. of_pixel(i) writes all of `outputs`.
template <class OfPixel>
void add_join(Context& c, Nodes& nodes, const std::string& name, std::vector<const Image4*> inputs, std::vector<Image4*> outputs, OfPixel of_pixel) {
    PlannedNode node = begin_node(c, name, "", "", 0, {});
    node.listed = false;
    node.reads = [=](graph::Reads& r) {
        for (const Image4* image : inputs) r.image(*image);
    };
    node.outputs = [=] {
        Bundle b;
        for (std::size_t i = 0; i < outputs.size(); ++i) lend(b, fmt::format("image_{}", i), *outputs[i]);
        return b;
    };
    const auto make_room = [=, size = c.size] {
        for (Image4* image : outputs)
            if (image->width != size.x || image->height != size.y) *image = Image4(size.x, size.y);
    };
    node.run = [=](const RunOptions&, graph::NodeRun&) {
        make_room();
        for (std::size_t i = 0; i < outputs[0]->size(); ++i) of_pixel(i);
    };
    node.leave_out = [=, size = c.size] {
        for (Image4* image : outputs) *image = Image4(size.x, size.y);
    };
    nodes.push_back(std::move(node));
}

// ---- The grid of the air, asked by pixels ----------------------------------------------------------------------------

// Of surfaces without a place on the lightmap, or `everywhere`; of static surfaces the grid has no static lamps, whose light reaches them
// directly.
void add_volume(Context& c, Nodes& nodes, const std::string& form, const std::string& why, bool fixed, const Image4& normal, probes::VolumeLight& made) {
    ProbeBuffers& p = c.frame.probes;
    const StageBinding& binding = stage<probes::VolumeKernel>();
    PlannedNode node = begin_node(c, binding, "probes", why, double(c.size.x) * c.size.y);
    set_form(node, form);
    node.by_name = form.empty();
    const auto inputs = [=, &c, &p, &normal] {
        probes::VolumeInputs in;
        if (c.settings.bake) in.grid = c.settings.bake->spatial.grid;
        in.form = c.settings.probe_run.volume, in.everywhere = fixed;
        in.position = &c.frame.gbuffer.position, in.normal = &normal, in.lightmap_uv = &p.uv, in.irradiance = fixed ? &p.bounced : &p.grid;
        return in;
    };
    node.dispatches = [=] { return std::vector<StageData>{data_of(inputs())}; };
    node.reads = [=, &binding](graph::Reads& r) { r.dispatch(binding, data_of(inputs())); };
    node.outputs = [&made] {
        Bundle b;
        lend(b, "irradiance", made.irradiance), lend(b, "light", made.light), lend(b, "from_light", made.from_light);
        return b;
    };
    node.run = [=, &made](const RunOptions& options, graph::NodeRun& run) {
        probes::run(inputs(), options, made);
        run.bytes = 3 * bytes_of(made.irradiance);
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, data_of(inputs()), at); };
    node.leave_out = [&made, size = c.size] { made.irradiance = made.light = made.from_light = Image4(size.x, size.y); };
    node.results = {{"irradiance", "irradiance", "E"}};
    nodes.push_back(std::move(node));
}

// The G-buffer as if no material had a normal map.
void add_plain(Context& c, Nodes& nodes) {
    raster::GBuffer& g = c.frame.probes.relief.plain;
    const double pixels = double(c.size.x) * c.size.y;
    PlannedNode node = begin_node(c, raster::gbuffer_binding().info.name, "camera", "normals without maps", c.triangles + pixels, {ms_pixels, "triangles + pixels"});
    set_form(node, "plain");
    node.by_name = false, node.direct = true;
    node.size = [&c] { return c.size; };
    node.results = {{"normal", "normal", "normal", 0, 3, true, true}};
    node.inputs = [&c] {
        Bundle b;
        const World& w = c.world();
        lend_surfaces(w.geometry, w.plain, b);
        const Buffer<glm::vec4> clip = raster::clip_positions(w.geometry, c.camera_view(), 0);
        add(b, "clip_positions", {std::int64_t(clip.size()), 4}, clip.empty() ? nullptr : &clip.data()->x);
        lend(b, "objects", {std::int64_t(w.geometry.object.size())}, w.geometry.object.data());
        return b;
    };
    node.reads = [&c](graph::Reads& r) {
        const auto& [position, look_at, up, fov_y_deg, near, far, reversed_z] = c.scene.camera;
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces), r.source("emission", c.keys.emission);
        raster::Layout layout = c.settings.layout;
        r.text(layout.name), r.fields(raster::fields(layout));
        r.value(c.scene.convention, position, look_at, up, fov_y_deg, near, far, reversed_z);
    };
    node.reads_left_out = [&c](graph::Reads& r) { r.value(c.scene.camera.reversed_z); };
    node.outputs = [&g] {
        Bundle b;
        lend(b, "position", g.position), lend(b, "normal", g.normal), lend(b, "albedo", g.albedo), lend(b, "emission", g.emission);
        lend(b, "depth", g.depth);
        lend(b, "id", {g.id.height, g.id.width, 2}, reinterpret_cast<const std::int32_t*>(g.id.data()));
        lend(b, "exact_depth", g.exact_depth);
        return b;
    };
    node.run = [&c, &g](const RunOptions& options, graph::NodeRun& run) {
        const World& w = c.world();
        raster::draw_gbuffer(w.geometry, w.plain, c.camera_view(), c.size, c.settings.layout, options, g, {}, c.memory ? &c.memory->workspace : nullptr);
        run.bytes = 4 * bytes_of(g.normal);
    };
    node.leave_out = [&c, &g, size = c.size] {
        g = {};
        g.position = g.normal = g.albedo = g.emission = Image4(size.x, size.y);
        g.depth = Image1(size.x, size.y, c.scene.camera.reversed_z ? 0.0f : 1.0f);
        g.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
        g.covered = raster::Covered(size);
    };
    node.dispatches = [&c] { return std::vector<StageData>{raster::gbuffer_data(c.world().geometry, c.world().plain, c.camera_view(), c.size)}; };
    node.explain = [&c](glm::ivec2 pixel) {
        return raster::explain_gbuffer(c.world().geometry, c.world().plain, c.camera_view(), c.size, pixel, c.settings.layout);
    };
    nodes.push_back(std::move(node));
}

// Light vectors of static surfaces, and irradiance along their normals with and without map.
void add_fixed(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    ReliefBuffers& r = p.relief;
    const auto of_static = [&p](const Image4& normal, std::size_t i) { return p.uv.texels[i].x < 0 ? glm::vec4(0) : normal.texels[i]; };
    add_join(c, nodes, "static normals", {&p.uv, &c.frame.gbuffer.normal}, {&r.fixed_normal},
             [=, &c, &r](std::size_t i) { r.fixed_normal.texels[i] = of_static(c.frame.gbuffer.normal, i); });
    add_volume(c, nodes, "static", "where static surfaces' light comes from", true, r.fixed_normal, r.fixed);
    if (!c.relief.maps) return;
    add_join(c, nodes, "static plain normals", {&p.uv, &r.plain.normal}, {&r.fixed_plain},
             [=, &r](std::size_t i) { r.fixed_plain.texels[i] = of_static(r.plain.normal, i); });
    add_volume(c, nodes, "static, plain", "what normal maps are held against", true, r.fixed_plain, r.fixed_unmapped);
}

// What probes.relief is told of the light vector, of either kind of surface; 0 where nothing is known.
void add_asked(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    ReliefBuffers& r = p.relief;
    const bool dynamic = c.relief.dynamic, fixed = c.relief.fixed;
    std::vector<const Image4*> inputs;
    if (dynamic) inputs.insert(inputs.end(), {&p.volume.irradiance, &p.volume.light, &p.volume.from_light});
    if (fixed) inputs.insert(inputs.end(), {&r.fixed.irradiance, &r.fixed.light, &r.fixed.from_light});
    add_join(c, nodes, "light vectors", inputs, {&r.asked.irradiance, &r.asked.light, &r.asked.from_light}, [=, &p, &r](std::size_t i) {
        const bool moves = dynamic && p.volume.irradiance.texels[i].w > 0;
        const probes::VolumeLight* of = moves ? &p.volume : fixed ? &r.fixed : nullptr;
        r.asked.irradiance.texels[i] = of ? of->irradiance.texels[i] : glm::vec4(0);
        r.asked.light.texels[i] = of ? of->light.texels[i] : glm::vec4(0);
        r.asked.from_light.texels[i] = of ? of->from_light.texels[i] : glm::vec4(0);
    });
    // Without static normal maps there is nothing to hold them against: 0, which changes nothing.
    if (!(fixed && c.relief.maps)) add_join(c, nodes, "no plain irradiance", {}, {&r.fixed_unmapped.irradiance}, [&r](std::size_t i) {
        r.fixed_unmapped.irradiance.texels[i] = glm::vec4(0);
    });
}

// k_s and the exponent of what each pixel sees.
void add_specular(Context& c, Nodes& nodes) {
    Image4& specular = c.frame.probes.relief.specular;
    PlannedNode node = begin_node(c, "specular", "", "", 0, {});
    node.listed = false;
    node.reads = [&c](graph::Reads& r) {
        const Image<glm::ivec2>& id = c.frame.gbuffer.id;
        r.image(id);
        r.source("geometry", c.keys.geometry);
        for (const Material& m : c.scene.materials) r.value(m.specular, m.exponent);
    };
    node.outputs = [&specular] { return lent("specular", specular); };
    node.run = [&c, &specular](const RunOptions&, graph::NodeRun&) {
        specular = Image4(c.size.x, c.size.y);
        const std::vector<std::int32_t>& of_triangle = c.world().geometry.material;
        for (std::size_t i = 0; i < specular.size(); ++i) {
            const std::int32_t triangle = c.frame.gbuffer.id.texels[i].y;
            if (triangle < 0) continue;
            const Material& m = c.scene.materials[std::size_t(of_triangle[std::size_t(triangle)])];
            specular.texels[i] = glm::vec4(m.specular, m.exponent);
        }
    };
    node.leave_out = [&specular, size = c.size] { specular = Image4(size.x, size.y); };
    nodes.push_back(std::move(node));
}

void add_relief_stage(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    ReliefBuffers& r = p.relief;
    const StageBinding& binding = stage<probes::ReliefKernel>();
    PlannedNode node = begin_node(c, binding, "relief", "normal maps and highlights", double(c.size.x) * c.size.y * (1 + double(c.lights.size())));
    const auto inputs = [&c, &p, &r] {
        probes::ReliefInputs in;
        in.maps = c.relief.maps, in.highlights = c.relief.highlights;
        in.eye = glm::vec3(c.camera_view().eye);
        in.position = &c.frame.gbuffer.position, in.normal = &c.frame.gbuffer.normal, in.irradiance = &p.joined;
        in.mapped = &r.asked.irradiance, in.plain = &r.fixed_unmapped.irradiance;
        in.light = &r.asked.light, in.from_light = &r.asked.from_light, in.specular = &r.specular;
        in.lights = &c.lights, in.visibility = &c.lit(0);
        return in;
    };
    node.dispatches = [=] { return std::vector<StageData>{data_of(inputs())}; };
    node.reads = [=, &binding](graph::Reads& reads) { reads.dispatch(binding, data_of(inputs())); };
    node.reads_left_out = [&p](graph::Reads& reads) { reads.image(p.joined); };
    node.outputs = [&c, &r] {
        Bundle b;
        lend(b, "relieved", indirect_to_shade(c)), lend(b, "glossy", r.made.glossy);
        return b;
    };
    node.run = [=, &c, &r](const RunOptions& options, graph::NodeRun& run) {
        std::swap(r.made.relieved, indirect_to_shade(c));  // written in place
        probes::run(inputs(), options, r.made);
        std::swap(r.made.relieved, indirect_to_shade(c));
        run.bytes = 2 * bytes_of(indirect_to_shade(c));
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, data_of(inputs()), at); };
    node.leave_out = [&c, &p, &r] {
        indirect_to_shade(c) = p.joined;
        r.made.glossy = Image4(c.size.x, c.size.y);
    };
    node.results = {{"relieved", "relieved", "relieved"}, {"glossy", "glossy", "glossy"}};
    nodes.push_back(std::move(node));
}

}  // namespace

void add_relief(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    ReliefBuffers& r = p.relief;
    const ReliefUse& use = c.relief;
    if (use.dynamic) add_volume(c, nodes, "", "indirect light of what moves", false, c.frame.gbuffer.normal, p.volume);
    if (use.draws_plain()) add_plain(c, nodes);
    if (use.fixed) add_fixed(c, nodes);
    // Static pixels have the lightmap's, others the grid's.
    std::vector<const Image4*> inputs = {&p.looked_up, &c.frame.gbuffer.normal};
    if (use.dynamic) inputs.push_back(&p.volume.irradiance);
    add_join(c, nodes, "indirect", inputs, {&p.joined}, [&c, &p, dynamic = use.dynamic](std::size_t i) {
        const bool moves = dynamic && p.volume.irradiance.texels[i].w > 0;
        const float w = c.frame.gbuffer.normal.texels[i].w > 0 ? 1.0f : 0.0f;  // as probes.relief writes it
        p.joined.texels[i] = glm::vec4(glm::vec3(moves ? p.volume.irradiance.texels[i] : p.looked_up.texels[i]), w);
    });
    add_asked(c, nodes);
    add_specular(c, nodes);
    add_relief_stage(c, nodes);
    if (!use.highlights) return;
    const Image4& emission = c.frame.gbuffer.emission;
    add_join(c, nodes, "sent", {&emission, &r.made.glossy}, {&r.sent}, [&c, &r](std::size_t i) {
        const glm::vec4 m = c.frame.gbuffer.emission.texels[i], s = r.made.glossy.texels[i];
        r.sent.texels[i] = m + glm::vec4(float(host::pi) * glm::vec3(s), 0);
    });
}

// ---- The layers of IPR figure 5.20 -----------------------------------------------------------------------------------

void add_relief_layers(Context& c, Nodes& nodes) {
    if (!c.relief.layers) return;
    ProbeBuffers& p = c.frame.probes;
    ReliefBuffers& r = p.relief;
    const bool dynamic = c.relief.dynamic;
    if (dynamic) add_volume(c, nodes, "plain", "the layer diffuse", false, r.plain.normal, r.unmapped);
    std::vector<const Image4*> inputs = {&p.looked_up};
    if (dynamic) inputs.push_back(&r.unmapped.irradiance);
    add_join(c, nodes, "plain indirect", inputs, {&r.plain_indirect, &r.white}, [=, &p, &r](std::size_t i) {
        const bool moves = dynamic && r.unmapped.irradiance.texels[i].w > 0;
        r.plain_indirect.texels[i] = moves ? glm::vec4(glm::vec3(r.unmapped.irradiance.texels[i]), 0) : p.looked_up.texels[i];
        r.white.texels[i] = glm::vec4(1, 1, 1, 0);
    });
    PlannedNode direct = begin_node(c, stage<direct::DirectKernel>(), "direct", "the layer diffuse", double(c.pixels(0)) * double(c.lights.size()));
    set_form(direct, "plain");
    direct.by_name = false, direct.direct = true;
    compute(c, direct, c.settings.direct,
            [&c, &r] {
                return direct::DirectInputs{&c.frame.gbuffer.position, &r.plain.normal, &c.lights, &c.lit(0), nullptr,
                                            compose::reads_density(c.settings.compose)};
            },
            [&r]() -> Image4& { return r.plain_direct; });
    nodes.push_back(std::move(direct));
    const Image4& emission = c.frame.gbuffer.emission;
    const auto add_layer = [&](ReliefBuffers::Layer& layer, const Image4& direct_light, const Image4& indirect, const Image4& sent) {
        PlannedNode node = begin_node(c, stage<compose::ComposeKernel>(), "compose", "a layer of IPR figure 5.20", double(c.size.x) * c.size.y);
        set_form(node, layer.name);
        node.by_name = false;
        compute(c, node, c.settings.compose,
                [&c, &r, &sent, &direct_light, &indirect] {
                    return compose::ComposeInputs{&c.frame.gbuffer.normal, &r.white, &sent, &direct_light, &indirect, c.scene.environment.radiance};
                },
                [&layer]() -> Image4& { return layer.radiance; });
        nodes.push_back(std::move(node));
        PlannedNode shown = begin_node(c, "display " + layer.name, "", "", 0, {});
        shown.listed = false;
        compute(c, shown, c.settings.tonemap, [&layer] { return compose::TonemapInputs{&layer.radiance}; },
                [&layer]() -> Image4& { return layer.display; });
        nodes.push_back(std::move(shown));
    };
    add_layer(r.layers[0], r.plain_direct, r.plain_indirect, emission);
    add_layer(r.layers[1], c.frame.direct, c.frame.indirect, emission);
    add_layer(r.layers[2], c.frame.direct, c.frame.indirect, c.relief.highlights ? r.sent : emission);
}

// ---- Static lamps (IPR 5.2.1.5) --------------------------------------------------------------------------------------

void add_static_visibility(Context& c, Nodes& nodes) {
    if (c.static_lamps.empty()) return;
    Buffer<float>& made = c.frame.probes.relief.visibility;
    PlannedNode node = begin_node(c, "static lamps", "", "", 0, {});
    node.listed = false;
    node.reads = [&c](graph::Reads& r) {
        r.list(c.shadows(0)), r.image(c.frame.gbuffer.id);
        for (const bool is : c.static_lamps) r.value(is);
        for (const Mesh& mesh : c.scene.meshes) r.value(mesh.dynamic);
    };
    const std::size_t pixels = c.pixels(0);
    node.outputs = [&c, &made] {
        Bundle b;
        const bool there = made.size() == c.lights.size() * c.pixels(0);
        lend(b, "visibility", there ? Shape{std::int64_t(c.lights.size()), c.size.y, c.size.x} : Shape{0}, there ? made.data() : nullptr);
        return b;
    };
    node.run = [=, &c, &made](const RunOptions&, graph::NodeRun&) {
        made = c.shadows(0);
        for (std::size_t l = 0; l < c.lights.size(); ++l) {
            if (!c.is_static(int(l))) continue;
            for (std::size_t i = 0; i < pixels; ++i) {
                const int object = c.frame.gbuffer.id.texels[i].x;
                if (object >= 0 && c.scene.meshes[std::size_t(object)].dynamic) made[l * pixels + i] = 0;
            }
        }
    };
    node.leave_out = [&c, &made] { made = c.shadows(0); };
    nodes.push_back(std::move(node));
}

void add_static_light(Context& c, Nodes& nodes) {
    ProbeBuffers& p = c.frame.probes;
    if (c.static_lamps.empty()) return;
    PlannedNode node = begin_node(c, probes::info_static_light().name, "probes", "static lamps, for what moves", 0, {});
    node.of_pixels = false, node.by_name = false;
    node.size = [] { return glm::ivec2(1, 1); };
    const auto lamps = [&c] {
        std::vector<Light> of;
        for (std::size_t l = 0; l < c.lights.size(); ++l)
            if (c.is_static(int(l))) of.push_back(c.lights[l]);
        return of;
    };
    node.reads = [=, &c, &p](graph::Reads& r) {
        r.source("bake", c.bake_key);
        r.list(p.data.matrix);
        r.source("what stands still", c.keys.fixed), r.source("surfaces", c.keys.surfaces);
        for (const Light& light : lamps()) {
            const auto& [name, type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius] = light;
            r.value(type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, radius);
        }
    };
    node.outputs = [&p] {
        Bundle b;
        lend(b, "light", {std::int64_t(p.static_light.size()), 4}, p.static_light.empty() ? nullptr : &p.static_light[0].x);
        return b;
    };
    node.run = [=, &c, &p](const RunOptions&, graph::NodeRun& run) {
        const World& w = c.world();
        const auto query = reference::build_ray_query(w.fixed, w.surfaces, Rays::exact);
        const probes::Bake& b = *c.settings.bake;
        p.static_light = probes::static_light(b.spatial, b.params.spatial_weight, lamps(), *query, probes::offset_of(probes::extent_of(w.fixed)));
        run.bytes = p.static_light.size() * sizeof(glm::vec4);
    };
    node.leave_out = [&p] { p.static_light.clear(); };
    node.fill = [] {};
    nodes.push_back(std::move(node));
}

}  // namespace plumb::frame
