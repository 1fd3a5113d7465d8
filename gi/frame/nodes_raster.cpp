// What the rasterizer draws: the G-buffers of the frame and of views beside it, and the maps of each light.
#include <fmt/format.h>

#include "gi/direct/shadow.h"
#include "gi/frame/frame_graph.h"
#include "raster/bindings.h"
#include "raster/light_view.h"
#include "raster/screen_triangle.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million triangles and pixels on one core with AVX-512, by the benchmarks on a 2.x GHz server core:
// they order stages by cost and promise nothing.
constexpr double ms_pixels = 60;
// What a part takes of that, for a million pixels: the light of a map, by `tools/bench pruning` (the Cornell box with
// direct light alone); the two colours of a G-buffer with their textures and one of them alone, estimated.
constexpr double ms_light = 45, ms_colours = 12, ms_colour = 4;

void add_camera(const Camera& camera, graph::Reads& r) {
    const auto& [position, look_at, up, fov_y_deg, near, far, reversed_z] = camera;
    r.value(position, look_at, up, fov_y_deg, near, far, reversed_z);
}

// What the rasterizer reads of geometry and surfaces, and how it stores what it draws.
void add_drawn(Context& c, graph::Reads& r, bool fixed = false) {
    r.source(fixed ? "what stands still" : "geometry", fixed ? c.keys.fixed : c.keys.geometry), r.source("surfaces", c.keys.surfaces);
    r.text(c.settings.layout.name);
    raster::Layout layout = c.settings.layout;
    r.fields(raster::fields(layout));
}

View view_of(Context& c, int view) {
    const IsrView& v = c.views[std::size_t(view)];
    return make_view(v.camera, double(v.size.x) / v.size.y, c.scene.convention, v.size);
}

bool is_layer(const IsrView& v) { return v.kind == ViewKind::layer || v.kind == ViewKind::mirror_layer; }

// What a layer has to lie behind; null for a view that is none.
const Image1* behind(Context& c, int view) {
    const IsrView& v = c.views[std::size_t(view)];
    return is_layer(v) ? &raster::peeled_depth(c.gbuffer(v.behind)) : nullptr;
}

void lend_gbuffer(const raster::GBuffer& g, Bundle& b) {
    lend(b, "position", g.position), lend(b, "normal", g.normal), lend(b, "albedo", g.albedo);
    lend(b, "emission", g.emission), lend(b, "depth", g.depth);
    lend(b, "id", {g.id.height, g.id.width, 2}, reinterpret_cast<const std::int32_t*>(g.id.data()));
    lend(b, "exact_depth", g.exact_depth);
}

// Under names that start with `prefix`.
void lend_map(const raster::Rsm& map, const std::string& prefix, Bundle& b) {
    lend(b, prefix + "position", map.position), lend(b, prefix + "normal", map.normal), lend(b, prefix + "flux", map.flux);
    const Shape shape = map.flux.empty() ? Shape{0} : Shape{map.size, map.size, 16};
    if (map.half)
        lend(b, prefix + "records", shape, map.half_records.data());
    else
        lend(b, prefix + "records", shape, map.records.data());
}

std::size_t bytes_of_map(const raster::Rsm& r) {
    return bytes_of(r.position) + bytes_of(r.normal) + bytes_of(r.flux) + r.records.size() * sizeof(float) +
           r.half_records.size() * sizeof(Half);
}

// Where a pass draws the vertices, under a name that starts with `prefix`.
void add_clip_positions(const Geometry& g, const View& view, const std::string& prefix, Bundle& b) {
    const Buffer<glm::vec4> clip = raster::clip_positions(g, view, 0);
    add(b, prefix + "clip_positions", {std::int64_t(clip.size()), 4}, clip.empty() ? nullptr : &clip.data()->x);
}

// What a light's maps are drawn of, and its bounds: of a static lamp what stands still.
struct MapScene {
    const Geometry& geometry;
    glm::vec3 low, high;
};
MapScene map_scene(Context& c, int light) {
    const World& w = c.world();
    return c.is_static(light) ? MapScene{w.fixed, w.fixed_low, w.fixed_high} : MapScene{w.geometry, w.low, w.high};
}

Camera camera_of(Context& c, int view) { return c.views[std::size_t(view)].camera; }

// A point light's maps lie side by side.
std::string face_of(int maps, int face) { return maps > 1 ? std::string(raster::face_names[face]) + "." : ""; }

}  // namespace

void lend_surfaces(const Geometry& g, const raster::Surfaces& s, Bundle& b) {
    const std::int64_t triangles = std::int64_t(g.triangles.size());
    lend(b, "vertices", {std::int64_t(g.vertices.size()), 8}, reinterpret_cast<const float*>(g.vertices.data()));
    lend(b, "triangles", {triangles, 3}, reinterpret_cast<const std::uint32_t*>(g.triangles.data()));
    lend(b, "triangle_material", {triangles}, g.material.data());
    lend(b, "materials", {std::int64_t(s.masked.size()), 16}, s.materials.data());
    lend(b, "textures", {std::int64_t(s.textures.size() / 4), 4}, s.textures.data());
    lend(b, "texels", {std::int64_t(s.texels.size())}, s.texels.data());
    lend(b, "decode", {2, 256}, s.decode.data());
    lend(b, "tangents", {std::int64_t(g.tangents.size()), 4}, reinterpret_cast<const float*>(g.tangents.data()));
}

void add_gbuffer(Context& c, int view, Nodes& nodes) {
    const IsrView& v = c.views[std::size_t(view)];
    const glm::ivec2 size = v.size;
    const double pixels = double(size.x) * size.y;
    const bool layer = is_layer(v), mirrored = v.kind == ViewKind::mirror_layer, paths = c.settings.method == Method::reference;
    const StageBinding& binding = layer ? raster::gbuffer_layer_binding() : raster::gbuffer_binding();
    const std::string why = mirrored ? "mirrored rays are followed in it" : view > 0 ? "" : paths ? "its layers" : "every later stage reads it";
    PlannedNode node = begin_node(c, binding.info.name, mirrored ? "reflect" : view > 0 ? "isr view" : "camera", why, c.triangles + pixels,
                                  {ms_pixels, "triangles + pixels"});
    set_view(c, node, view);
    node.of_pixels = view == 0, node.by_name = view == 0 || layer, node.in_steps = layer;
    node.of_scene = !layer, node.direct = true;
    node.results = {{"position", "position", "position", 0, 3, true, true}, {"depth", "position", "depth", 3, 1, true, true},
                    {"normal", "normal", "normal", 0, 3, true, true},       {"albedo", "albedo", "albedo", 0, 3, true, true},
                    {"emission", "emission", "emission", 0, 3, true, true}};
    node.inputs = [=, &c] {
        Bundle b;
        const Geometry& g = c.world().geometry;
        lend_surfaces(g, c.world().surfaces, b);
        add_clip_positions(g, view_of(c, view), "", b);
        lend(b, "objects", {std::int64_t(g.object.size())}, g.object.data());
        if (const Image1* depth = behind(c, view)) lend(b, "behind", *depth);
        return b;
    };
    node.size = [=] { return size; };
    if (view == 0)
        node.parts = {{"albedo", -1, [=](const Plan&) { return pixels * 1e-6 * ms_colour; },
                       [](Plan& p) { p.gbuffer.albedo = false; }},
                      // Without either colour no texture is read.
                      {"emission", -1,
                       [=](const Plan& p) { return pixels * 1e-6 * (p.gbuffer.albedo ? ms_colour : ms_colours - ms_colour); },
                       [](Plan& p) { p.gbuffer.emission = false; }}};

    node.reads = [=, &c](graph::Reads& r) {
        const auto [position, normal, albedo, emission, id] = c.plan ? c.plan->gbuffer : raster::GBufferWants{};
        r.value(position, normal, albedo, emission, id);
        add_drawn(c, r);
        r.source("emission", c.keys.emission);
        r.value(c.scene.convention);
        add_camera(camera_of(c, view), r);
        if (const Image1* depth = behind(c, view)) r.image(*depth);
    };
    // What an empty depth buffer holds.
    node.reads_left_out = [=, &c](graph::Reads& r) { r.value(camera_of(c, view).reversed_z); };
    node.outputs = [=, &c] {
        Bundle b;
        lend_gbuffer(c.gbuffer(view), b);
        return b;
    };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun& run) {
        raster::GBuffer& g = c.gbuffer(view);
        const World& w = c.world();
        raster::draw_gbuffer(w.geometry, w.surfaces, view_of(c, view), size, c.settings.layout, options, g,
                             c.plan ? c.plan->gbuffer : raster::GBufferWants{}, c.memory ? &c.memory->workspace : nullptr,
                             behind(c, view));
        // Buffers that were not wanted are 0 where others read them.
        for (Image4* image : {&g.position, &g.normal, &g.albedo, &g.emission})
            if (image->empty()) *image = Image4(size.x, size.y);
        run.bytes = bytes_of(g.position) + bytes_of(g.normal) + bytes_of(g.albedo) + bytes_of(g.emission) +
                    bytes_of(g.depth) + bytes_of(g.id);
    };
    // A G-buffer that sees nothing: what the pass would write for an empty scene.
    node.leave_out = [=, &c] {
        raster::GBuffer& g = c.gbuffer(view) = {};
        g.position = g.normal = g.albedo = g.emission = Image4(size.x, size.y);
        g.depth = Image1(size.x, size.y, camera_of(c, view).reversed_z ? 0.0f : 1.0f);
        g.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
        g.covered = raster::Covered(size);
    };
    node.dispatches = [=, &c] {
        const World& w = c.world();
        const Image1* depth = behind(c, view);
        return std::vector<StageData>{depth ? raster::gbuffer_layer_data(w.geometry, w.surfaces, view_of(c, view), size, *depth)
                                            : raster::gbuffer_data(w.geometry, w.surfaces, view_of(c, view), size)};
    };
    node.explain = [=, &c](glm::ivec2 pixel) {
        const World& w = c.world();
        return raster::explain_gbuffer(w.geometry, w.surfaces, view_of(c, view), size, pixel, c.settings.layout,
                                       behind(c, view));
    };
    nodes.push_back(std::move(node));
}

void add_maps(Context& c, int l, Nodes& nodes) {
    const Light& light = c.lights[std::size_t(l)];
    const int maps = raster::map_count(light);
    const double side = light.rsm_size, texels = maps * side * side;
    const StageBinding& binding = raster::rsm_binding();
    PlannedNode node = begin_node(c, binding.info.name, "rsm",
                                  maps > 1 ? fmt::format("shadow and gather read it; {} faces", maps)
                                           : "shadow and gather read it",
                                  maps * c.triangles + texels, {ms_pixels, "triangles + texels"}, l);
    node.map_texels = texels;
    node.of_pixels = false, node.of_scene = node.direct = true;
    node.results = {{"position", "position", "position", 0, 3, true, true}, {"depth", "position", "depth", 3, 1, true, true},
                    {"normal", "normal", "normal", 0, 3, true, true},       {"flux", "flux", "flux", 0, 3, true, true}};
    node.inputs = [=, &c] {
        Bundle b;
        lend_surfaces(map_scene(c, l).geometry, c.world().surfaces, b);
        each_map(c.maps(l), [&](const raster::Rsm& map, int, const std::string& face) {
            add_clip_positions(map_scene(c, l).geometry, map.view, face.empty() ? "" : face + ".", b);
        });
        return b;
    };
    node.size = [=] { return glm::ivec2(maps * int(side), int(side)); };
    const std::size_t at = std::size_t(l);
    node.parts = {{"light", -1, [=](const Plan&) { return texels * 1e-6 * ms_light; },
                   [=, &c](Plan& p) { p.maps[at].wants = {false, direct::reads_normals(c.settings.shadow)}; }}};
    for (int m = 0; maps > 1 && m < maps; ++m)
        node.parts.push_back({"face", m, [=, &c](const Plan&) { return (c.triangles + side * side) * 1e-6 * ms_pixels; },
                              [=](Plan& p) { p.maps[at].faces &= ~(1u << m); }});

    auto planned = [=, &c] { return c.plan ? c.plan->maps[at] : PlannedMaps{}; };
    auto views = [=, &c] {
        const MapScene seen = map_scene(c, l);
        return raster::light_views(c.lights[at], seen.low, seen.high);
    };
    node.reads = [=, &c](graph::Reads& r) {
        const auto [wants, faces] = planned();
        r.value(wants.light, wants.normal, faces);
        add_drawn(c, r, c.is_static(l));
        const auto& [name, type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius] =
            c.lights[at];
        r.value(type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius);
    };
    node.reads_left_out = [=](graph::Reads& r) { r.value(maps); };
    node.outputs = [=, &c] {
        Bundle b;
        const std::vector<raster::Rsm>& drawn = c.maps(l);
        for (std::size_t m = 0; m < drawn.size(); ++m)
            lend_map(drawn[m], face_of(int(drawn.size()), int(m)), b);
        return b;
    };
    // All maps of the light that the plan wants.
    node.run = [=, &c](const RunOptions& options, graph::NodeRun& run) {
        std::vector<raster::Rsm>& drawn = c.maps(l);
        const std::vector<View> seen = views();
        drawn.resize(seen.size());
        const auto [wants, faces] = planned();
        for (std::size_t m = 0; m < seen.size(); ++m) {
            if (!(faces >> m & 1)) {
                drawn[m] = {};
                drawn[m].view = seen[m];
                continue;
            }
            RunOptions part = options;
            if (part.progress)
                part.progress = [&, m](double done) { options.progress((double(m) + done) / double(seen.size())); };
            raster::draw_rsm(map_scene(c, l).geometry, c.world().surfaces, c.lights[at], seen[m], c.settings.layout, part, drawn[m],
                             c.memory ? &c.memory->workspace : nullptr, wants);
        }
        for (const raster::Rsm& map : drawn) run.bytes += bytes_of_map(map);
    };
    node.leave_out = [=, &c] { c.maps(l).assign(std::size_t(maps), {}); };
    // Maps that nothing was drawn into, of faces that may see something.
    node.fill = [=, &c] {
        std::vector<raster::Rsm>& drawn = c.maps(l);
        const MapScene of = map_scene(c, l);
        const std::vector<View> seen = views();
        drawn.resize(seen.size());
        for (std::size_t m = 0; m < seen.size(); ++m) {
            if (drawn[m].size > 0) continue;
            if (seen.size() == 1 || raster::may_see(seen[m], of.low, of.high))
                drawn[m] = raster::unseen_rsm(c.lights[at], seen[m]);
            else
                drawn[m].view = seen[m];
        }
    };
    node.dispatches = [=, &c] {
        std::vector<StageData> all;
        const World& w = c.world();
        each_map(c.maps(l), [&](const raster::Rsm& map, int, const std::string& face) {
            all.push_back(raster::rsm_data(map_scene(c, l).geometry, w.surfaces, c.lights[at], map.view));
            all.back().id = face;
        });
        return all;
    };
    // A texel of the map, or of the six maps side by side.
    node.explain = [=, &c](glm::ivec2 texel) {
        const int face = texel.x / int(side);
        const World& w = c.world();
        std::vector<TapValue> values;
        if (maps > 1) values.push_back({"face", -1, {double(face)}, "of the point light: +x -x +y -y +z -z"});
        const std::vector<TapValue> taps =
            raster::explain_rsm(map_scene(c, l).geometry, w.surfaces, c.lights[at], views()[std::size_t(face)],
                                {texel.x - face * int(side), texel.y}, c.settings.layout);
        values.insert(values.end(), taps.begin(), taps.end());
        return values;
    };
    nodes.push_back(std::move(node));
}

}  // namespace plumb::frame
