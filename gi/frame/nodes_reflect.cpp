// Reflections (gi/screen): which pixels are mirrors, where their rays meet what the camera and the lights see, what lights
// what was met in a light's map, and the picture with what mirrors show.
#include <fmt/format.h>

#include <span>

#include "core/parallel.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/isr.h"
#include "gi/frame/mirrors.h"
#include "gi/screen/screen.h"
#include "raster/bindings.h"
#include "raster/screen_triangle.h"

namespace plumb::frame {

bool reflects(const Settings& settings) {
    return settings.reflect.march != screen::March::off && settings.method != Method::reference;
}

Image4& composed_picture(Context& c) { return reflects(c.settings) ? c.frame.reflect.composed : c.frame.radiance; }

namespace {

using screen::March;

// Milliseconds for a million triangles and texels, as nodes_raster.cpp has them.
constexpr double ms_texels = 60;

double pixels(const Context& c) { return double(c.size.x) * c.size.y; }

// Which map a view is; the camera's is none.
struct SeenMap {
    int light = -1, map = 0;
};
constexpr int camera_number = 1;

// What pixels mirror, by their triangles' materials.
void add_mirrors(Context& c, Nodes& nodes) {
    Image4& mirror = c.frame.reflect.mirror;
    PlannedNode node = begin_node(c, "mirrors", "", "", 0, {});
    node.listed = false;
    node.reads = [&c](graph::Reads& r) {
        r.image(c.frame.gbuffer.id);
        r.source("geometry", c.keys.geometry);
        for (const Material& m : c.scene.materials) r.value(m.mirror);
    };
    node.outputs = [&mirror] { return lent("mirror", mirror); };
    node.run = [&c, &mirror](const RunOptions&, graph::NodeRun&) {
        mirror = mirrors_of(c.scene, c.world().geometry, c.frame.gbuffer.id);
    };
    node.leave_out = [&mirror, size = c.size] { mirror = Image4(size.x, size.y); };
    nodes.push_back(std::move(node));
}

screen::ReflectInputs rays_of(Context& c) {
    const raster::GBuffer& g = c.frame.gbuffer;
    screen::ReflectInputs in;
    in.position = &g.position, in.normal = &g.normal, in.mirror = &c.frame.reflect.mirror;
    in.eye = c.scene.camera.position;
    return in;
}

bool by_cells(const Context& c) { return c.settings.reflect.march == March::hierarchical; }

// The node that follows rays in a view, by steps or from texel to texel; `inputs` as screen.reflect reads them.
template <class InputsOf>
PlannedNode begin_march(Context& c, const std::string& work, const std::string& why, int light, int index, InputsOf inputs) {
    const screen::ReflectParams& p = c.settings.reflect;
    const bool cells = by_cells(c);
    PlannedNode node = begin_node(c, cells ? stage<screen::CellsKernel>() : stage<screen::ReflectKernel>(), work, why,
                                  pixels(c) * (cells ? 32 : p.steps), light);
    node.results = {{"hit", "", "hit"}};
    auto result = [=, &c]() -> Image4& { return c.frame.reflect.hits[std::size_t(index)]; };
    if (cells)
        compute(c, node, p,
                [=, &c] { return screen::CellsInputs{inputs(), &c.frame.reflect.nearest[std::size_t(index)], nullptr}; }, result);
    else
        compute(c, node, p, inputs, result);
    node.in_steps = true;
    return node;
}

// The blocks of a view's texels. `seen` returns its positions.
template <class SeenOf>
PlannedNode begin_nearest(Context& c, const std::string& work, glm::ivec2 view, int light, int index, SeenOf seen) {
    const glm::ivec2 blocks = screen::blocks_of(view);
    PlannedNode node = begin_node(c, stage<screen::NearestKernel>(), work, "blocks that rays pass at once",
                                  double(blocks.x) * blocks.y, light);
    node.of_pixels = false;
    node.size = [=] { return blocks; };
    node.results = {{"nearest", "", "least", 0, 1}};
    compute(c, node, c.settings.reflect, [=] { return screen::NearestInputs{seen()}; },
            [=, &c]() -> Image4& { return c.frame.reflect.nearest[std::size_t(index)]; });
    return node;
}

void add_march_of_camera(Context& c, Nodes& nodes) {
    const int index = c.reflect_views++;
    if (by_cells(c)) nodes.push_back(begin_nearest(c, "reflect", c.size, -1, index, [&c] { return &c.frame.gbuffer.position; }));
    nodes.push_back(begin_march(c, "reflect", "where mirrored rays meet what is seen", -1, index, [&c] {
        screen::ReflectInputs in = rays_of(c);
        in.seen = &c.frame.gbuffer.position, in.seen_normal = &c.frame.gbuffer.normal;
        in.view = c.camera_view(), in.number = camera_number;
        return in;
    }));
}

// ---- In the lights' maps -------------------------------------------------------------------------------------------------

// Maps have positions of their own: none is rebuilt from depth, which parallel rays do not allow.
raster::Layout layout_of_maps(const Context& c) {
    raster::Layout layout = c.settings.layout;
    layout.name = "custom";
    layout.position_from_depth = layout.depth_over_far = false;
    return layout;
}

// What the maps of a light do not hold of their texels: normals where no gather reads them, reflectance, emission, triangles.
void add_seen(Context& c, int light, Nodes& nodes) {
    const Light& of = c.lights[std::size_t(light)];
    const int maps = raster::map_count(of), side = of.rsm_size;
    PlannedNode node = begin_node(c, raster::gbuffer_binding().info.name, "reflect light", "what mirrors show of its maps",
                                  maps * (c.triangles + double(side) * side), {ms_texels, "triangles + texels"}, light);
    set_form(node, "map");
    node.by_name = node.of_pixels = false;
    node.size = [=] { return glm::ivec2(maps * side, side); };
    auto geometry = [=, &c]() -> const Geometry& { return c.is_static(light) ? c.world().fixed : c.world().geometry; };
    auto drawn = [=, &c]() -> std::vector<raster::GBuffer>& { return c.frame.reflect.seen[std::size_t(light)]; };
    auto each = [=, &c](auto one) { each_map(c.maps(light), one); };
    node.inputs = [=, &c] {
        Bundle b;
        lend_surfaces(geometry(), c.world().surfaces, b);
        each([&](const raster::Rsm& map, int, const std::string& face) {
            const Buffer<glm::vec4> clip = raster::clip_positions(geometry(), map.view, 0);
            add(b, (face.empty() ? "" : face + ".") + "clip_positions", {std::int64_t(clip.size()), 4},
                clip.empty() ? nullptr : &clip.data()->x);
        });
        lend(b, "objects", {std::int64_t(geometry().object.size())}, geometry().object.data());
        return b;
    };
    node.reads = [=, &c](graph::Reads& r) {
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces), r.source("emission", c.keys.emission);
        if (c.is_static(light)) r.source("what stands still", c.keys.fixed);
        raster::Layout layout = c.settings.layout;
        r.text(layout.name), r.fields(raster::fields(layout));
        const auto& [name, type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius] =
            c.lights[std::size_t(light)];
        r.value(type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius);
        for (const raster::Rsm& map : c.maps(light)) r.value(map.size);
    };
    node.reads_left_out = [=](graph::Reads& r) { r.value(maps); };
    node.outputs = [=] {
        Bundle b;
        for (std::size_t m = 0; m < drawn().size(); ++m) {
            const raster::GBuffer& g = drawn()[m];
            const std::string face = maps > 1 ? std::string(raster::face_names[m]) + "." : "";
            lend(b, face + "normal", g.normal), lend(b, face + "albedo", g.albedo), lend(b, face + "emission", g.emission);
            lend(b, face + "id", {g.id.height, g.id.width, 2}, reinterpret_cast<const std::int32_t*>(g.id.data()));
        }
        return b;
    };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun& run) {
        drawn().assign(c.maps(light).size(), {});
        raster::GBufferWants wants;
        wants.position = false;
        each([&](const raster::Rsm& map, int m, const std::string&) {
            raster::GBuffer& g = drawn()[std::size_t(m)];
            raster::draw_gbuffer(geometry(), c.world().surfaces, map.view, glm::ivec2(map.size), layout_of_maps(c), options, g, wants,
                                 c.memory ? &c.memory->workspace : nullptr);
            run.bytes += bytes_of(g.normal) + bytes_of(g.albedo) + bytes_of(g.emission) + bytes_of(g.id);
        });
    };
    node.leave_out = [=] { drawn().assign(std::size_t(maps), {}); };
    node.fill = [] {};
    node.dispatches = [=, &c] {
        std::vector<StageData> all;
        each([&](const raster::Rsm& map, int, const std::string& face) {
            all.push_back(raster::gbuffer_data(geometry(), c.world().surfaces, map.view, glm::ivec2(map.size)));
            all.back().id = face;
        });
        return all;
    };
    node.explain = [=, &c](glm::ivec2 texel) {
        const int m = texel.x / side;
        const raster::Rsm& map = c.maps(light)[std::size_t(m)];
        if (map.size == 0) return std::vector<TapValue>{{"face", -1, {double(m)}, "sees nothing"}};
        return raster::explain_gbuffer(geometry(), c.world().surfaces, map.view, glm::ivec2(side), {texel.x - m * side, texel.y},
                                       layout_of_maps(c));
    };
    nodes.push_back(std::move(node));
}

// One map of a light, for the rays that met nothing that the camera sees: of itself alone, so that a light at rest keeps
// what its maps show while another moves (choose_nearest). Where the map sees nothing the camera's hits stay.
void add_march_of_map(Context& c, SeenMap seen, Nodes& nodes) {
    const int light = seen.light, index = c.reflect_views++;
    const std::size_t map = std::size_t(seen.map);
    const Light& of = c.lights[std::size_t(light)];
    auto result = [=, &c]() -> Image4& { return c.frame.reflect.hits[std::size_t(index)]; };
    auto before = [&c]() -> Image4& { return c.frame.reflect.hits.front(); };
    auto is_drawn = [=, &c] { return c.maps(light).size() > map && c.maps(light)[map].size > 0; };
    // Adds a node that is left out where the map sees nothing.
    auto add = [&](PlannedNode node, std::function<void()> otherwise, std::function<void(graph::Reads&)> reads_otherwise) {
        if (raster::map_count(of) > 1) set_form(node, raster::face_names[map]);
        node.leave_out = otherwise, node.reads_left_out = reads_otherwise;
        node.run = [=, run = node.run](const RunOptions& options, graph::NodeRun& row) {
            if (is_drawn()) return run(options, row);
            otherwise();
        };
        node.reads = [=, reads = node.reads](graph::Reads& r) { return is_drawn() ? reads(r) : reads_otherwise(r); };
        node.dispatches = [=, dispatches = node.dispatches] {
            return is_drawn() ? dispatches() : std::vector<StageData>();
        };
        node.explain = [=, explain = node.explain](glm::ivec2 item) {
            if (is_drawn()) return explain(item);
            return std::vector<TapValue>{{"map", -1, {double(map)}, "sees nothing: as before"}};
        };
        nodes.push_back(std::move(node));
    };
    if (by_cells(c))
        add(begin_nearest(c, "reflect light", glm::ivec2(of.rsm_size), light, index, [=, &c] { return &c.maps(light)[map].position; }),
            [=, &c] { c.frame.reflect.nearest[std::size_t(index)] = {}; }, [](graph::Reads&) {});
    add(begin_march(c, "reflect light", "where mirrored rays meet what it lights", light, index,
                    [=, &c] {
                        screen::ReflectInputs in = rays_of(c);
                        in.seen = &c.maps(light)[map].position;
                        in.seen_normal = &c.frame.reflect.seen[std::size_t(light)][map].normal;
                        in.view = c.maps(light)[map].view, in.number = camera_number + index, in.before = &before();
                        return in;
                    }),
        [=] { result() = before(); }, [=](graph::Reads& r) { r.image(before()); });
}

// Of the hits of all views the camera's or, where it has none, the nearest; of equals the first.
void choose_nearest(std::span<const Image4> views, const RunOptions& options, Image4& nearest) {
    nearest = views.front();
    parallel_bands(nearest.height, 16, options, [&](int first, int last) {
        const std::size_t begin = std::size_t(first) * nearest.width, end = std::size_t(last) * nearest.width;
        for (const Image4& view : views.subspan(1))
            for (std::size_t i = begin; i < end; ++i) {
                const glm::vec4 hit = view.texels[i];
                glm::vec4& chosen = nearest.texels[i];
                if (hit.w > camera_number && (chosen.w == 0 || (chosen.w > camera_number && hit.z < chosen.z))) chosen = hit;
            }
    });
}

// The nearest hits, and the surfaces that were met in maps, a pixel each, as if a view saw them.
void add_met(Context& c, int view, const std::vector<SeenMap>& maps, Nodes& nodes) {
    PlannedNode node = begin_node(c, "surfaces in mirrors", "", "", 0, {});
    node.listed = false;
    const std::size_t index = std::size_t(c.reflect_views++);
    auto hits = [=, &c]() -> Image4& { return c.frame.reflect.hits[index]; };
    auto known = [&c](SeenMap m) -> const raster::GBuffer& {
        return c.frame.reflect.seen[std::size_t(m.light)][std::size_t(m.map)];
    };
    node.reads = [=, &c](graph::Reads& r) {
        for (std::size_t i = 0; i < index; ++i) r.image(c.frame.reflect.hits[i]);
        for (const SeenMap m : maps) {
            const std::vector<raster::Rsm>& drawn = c.maps(m.light);
            if (drawn.size() <= std::size_t(m.map) || drawn[std::size_t(m.map)].size == 0) continue;
            const raster::GBuffer& of = known(m);
            r.image(drawn[std::size_t(m.map)].position), r.image(of.normal), r.image(of.albedo), r.image(of.emission);
        }
    };
    node.outputs = [=, &c] {
        Bundle b;
        const raster::GBuffer& g = c.gbuffer(view);
        lend(b, "hit", hits()), lend(b, "position", g.position), lend(b, "normal", g.normal), lend(b, "albedo", g.albedo), lend(b, "emission", g.emission);
        lend(b, "id", {g.id.height, g.id.width, 2}, reinterpret_cast<const std::int32_t*>(g.id.data()));
        return b;
    };
    auto clear = [=, &c, size = c.size] {
        raster::GBuffer& g = c.gbuffer(view);
        g.position = g.normal = g.albedo = g.emission = Image4(size.x, size.y);
        g.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
        g.covered = raster::Covered(size);
    };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun&) {
        clear();
        raster::GBuffer& g = c.gbuffer(view);
        Image4& nearest = hits();
        choose_nearest(std::span(c.frame.reflect.hits).first(index), options, nearest);
        parallel_bands(nearest.height, 16, options, [&](int first, int last) {
            const std::size_t end = std::size_t(last) * nearest.width;
            for (std::size_t i = std::size_t(first) * nearest.width; i < end; ++i) {
                const glm::vec4 hit = nearest.texels[i];
                const int number = int(hit.w);
                if (number <= camera_number) continue;
                const SeenMap m = maps[std::size_t(number - camera_number - 1)];
                const glm::ivec2 at(int(hit.x), int(hit.y));
                const raster::GBuffer& of = known(m);
                g.position.texels[i] = c.maps(m.light)[std::size_t(m.map)].position(at.x, at.y);
                g.normal.texels[i] = of.normal(at.x, at.y);
                g.albedo.texels[i] = of.albedo(at.x, at.y), g.emission.texels[i] = of.emission(at.x, at.y);
                g.id.texels[i] = of.id(at.x, at.y);
            }
        });
        g.covered = covered_by(g.normal);
    };
    node.leave_out = [=, &c] {
        clear();
        hits() = c.frame.reflect.hits.front();
    };
    nodes.push_back(std::move(node));
}

// Returns the view of what was met; 0: none.
int add_lights(Context& c, Nodes& nodes) {
    if (c.views.back().kind != ViewKind::mirrored) return 0;
    std::vector<SeenMap> maps;
    for (int l = 0; l < int(c.lights.size()); ++l) {
        const Light& light = c.lights[std::size_t(l)];
        if (!light.on || light.intensity == glm::vec3(0)) continue;
        add_seen(c, l, nodes);
        for (int m = 0; m < raster::map_count(light); ++m) {
            maps.push_back({l, m});
            add_march_of_map(c, maps.back(), nodes);
        }
    }
    const int view = int(c.views.size()) - 1;
    add_met(c, view, maps, nodes);
    for (int l = 0; l < int(c.lights.size()); ++l) add_shadow(c, l, view, nodes);
    add_direct(c, view, nodes);
    return view;
}

void add_mirror(Context& c, int view, Nodes& nodes) {
    const screen::ReflectParams& p = c.settings.reflect;
    const StageBinding& binding = stage<screen::MirrorKernel>();
    ReflectBuffers& made = c.frame.reflect;
    PlannedNode node = begin_node(c, binding, "reflect", "what mirrors show", pixels(c));
    node.results = {{"reflection", "reflection", "reflection"}, {"radiance", "radiance", "radiance"}};
    const auto inputs = [=, &c, &made] {
        screen::MirrorInputs in{&made.hits.back(), &made.mirror, &made.composed};
        if (view == 0) return in;
        const raster::GBuffer& g = c.gbuffer(view);
        in.albedo = &g.albedo, in.emission = &g.emission, in.direct = &c.direct(view);
        return in;
    };
    node.dispatches = [=, &p] { return std::vector<StageData>{data_of(p, inputs())}; };
    node.reads = [=, &p, &binding](graph::Reads& r) { r.dispatch(binding, data_of(p, inputs())); };
    node.reads_left_out = [&made](graph::Reads& r) { r.image(made.composed); };
    node.outputs = [&c, &made] {
        Bundle b;
        lend(b, "reflection", made.reflection), lend(b, "radiance", c.frame.radiance);
        return b;
    };
    node.run = [=, &c, &p, &made](const RunOptions& options, graph::NodeRun& run) {
        screen::run(p, inputs(), options, made.reflection, c.frame.radiance);
        run.bytes = bytes_of(made.reflection) + bytes_of(c.frame.radiance);
    };
    node.explain = [=, &p](glm::ivec2 pixel) { return plumb::explain(p, inputs(), pixel); };
    node.leave_out = [&c, &made] {
        made.reflection = Image4(c.size.x, c.size.y);
        c.frame.radiance = made.composed;
    };
    nodes.push_back(std::move(node));
}

}  // namespace

void add_reflect(Context& c, Nodes& nodes) {
    if (!reflects(c.settings)) return;
    screen::validate(c.settings.reflect);
    add_mirrors(c, nodes);
    add_march_of_camera(c, nodes);
    add_mirror(c, add_lights(c, nodes), nodes);
}

}  // namespace plumb::frame
