// Reflections (gi/screen): which pixels are mirrors, where their rays meet what the camera sees, its layers and the lights'
// maps, what lights what was met behind the picture, and the picture with what mirrors show.
#include <fmt/format.h>

#include <span>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/frame/filters.h"
#include "gi/frame/mirrors.h"
#include "gi/frame/nodes_reflect.h"
#include "gi/screen/screen.h"

namespace plumb::frame {

bool reflects(const Settings& settings) {
    return settings.reflect.march != screen::March::off && settings.method != Method::reference;
}

Image4& composed_picture(Context& c) { return reflects(c.settings) ? c.frame.reflect.composed : c.frame.radiance; }

namespace {

using screen::March;

double pixels(const Context& c) { return double(c.size.x) * c.size.y; }

// What was asked behind the picture: a layer of the camera's, which is a view of the frame, or a map of a light.
struct Asked {
    int layer = 0;  // 0: none
    int light = -1, map = 0;
};
constexpr int camera_number = 1;
// As of a frame: numbers of a sheet have indices of 32 bits.
constexpr double most_sheet_pixels = 1 << 28;

bool has_lobes(const Context& c) { return c.settings.reflect.lobe == screen::Lobe::phong; }

// Of one picture, or of all rays' pictures.
glm::ivec2 sheet(const Context& c) { return screen::sheet_of(c.size, screen::lobe_blocks(c.settings.reflect)); }

// What pixels mirror, by their triangles' materials.
void add_mirrors(Context& c, Nodes& nodes) {
    Image4 &mirror = c.frame.reflect.mirror, &lobe = c.frame.reflect.lobe;
    PlannedNode node = begin_node(c, "mirrors", "", "", 0, {});
    node.listed = false;
    node.reads = [&c](graph::Reads& r) {
        r.image(c.frame.gbuffer.id);
        r.source("geometry", c.keys.geometry);
        for (const Material& m : c.scene.materials) r.value(m.mirror, m.specular, m.exponent);
    };
    node.outputs = [&mirror, &lobe] {
        Bundle b = lent("mirror", mirror);
        lend(b, "lobe", lobe);
        return b;
    };
    node.run = [&c, &mirror, &lobe](const RunOptions&, graph::NodeRun&) {
        mirror = mirrors_of(c.scene, c.world().geometry, c.frame.gbuffer.id);
        lobe = lobes_of(c.scene, c.world().geometry, c.frame.gbuffer.id);
    };
    node.leave_out = [&mirror, &lobe, size = c.size] { mirror = lobe = Image4(size.x, size.y); };
    nodes.push_back(std::move(node));
}

// The rays of mirrors and lobes, where there is more than the mirrored one of each pixel.
void add_rays(Context& c, Nodes& nodes) {
    if (!has_lobes(c)) return;
    const glm::ivec2 size = sheet(c);
    PlannedNode node = begin_node(c, stage<screen::LobeKernel>(), "reflect", "rays of mirrors and lobes", double(size.x) * size.y);
    node.of_pixels = false;
    node.size = [=] { return size; };
    node.results = {{"ray", "", "ray"}};
    compute(c, node, c.settings.reflect,
            [&c] {
                const raster::GBuffer& g = c.frame.gbuffer;
                return screen::LobeInputs{&g.position, &g.normal, &c.frame.reflect.mirror, &c.frame.reflect.lobe,
                                          c.scene.camera.position, c.settings.seed};
            },
            [&c]() -> Image4& { return c.frame.reflect.rays; });
    nodes.push_back(std::move(node));
}

screen::ReflectInputs rays_of(Context& c) {
    const raster::GBuffer& g = c.frame.gbuffer;
    screen::ReflectInputs in;
    in.position = &g.position, in.normal = &g.normal, in.mirror = &c.frame.reflect.mirror;
    in.eye = c.scene.camera.position;
    if (has_lobes(c)) in.rays = &c.frame.reflect.rays;
    return in;
}

bool by_cells(const Context& c) { return c.settings.reflect.march == March::hierarchical; }

// The node that follows rays in a view, by steps or from texel to texel; `inputs` as screen.reflect reads them.
template <class InputsOf>
PlannedNode begin_march(Context& c, const std::string& work, const std::string& why, int light, int index, InputsOf inputs) {
    const screen::ReflectParams& p = c.settings.reflect;
    const bool cells = by_cells(c);
    const glm::ivec2 size = sheet(c);
    PlannedNode node = begin_node(c, cells ? stage<screen::CellsKernel>() : stage<screen::ReflectKernel>(), work, why,
                                  double(size.x) * size.y * (cells ? 32 : p.steps), light);
    node.results = {{"hit", "", "hit"}};
    if (has_lobes(c)) {
        node.of_pixels = false;
        node.size = [=] { return size; };
        node.covered = [] { return raster::Covered(); };  // all of them
    }
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

// A layer behind the picture.
void add_march_of_layer(Context& c, int view, Nodes& nodes) {
    const int index = c.reflect_views++;
    const auto before = [=, &c] { return &c.frame.reflect.hits[std::size_t(index - 1)]; };
    const auto add = [&](PlannedNode node) {
        set_form(node, c.views[std::size_t(view)].name);
        nodes.push_back(std::move(node));
    };
    if (by_cells(c)) add(begin_nearest(c, "reflect", c.size, -1, index, [=, &c] { return &c.gbuffer(view).position; }));
    add(begin_march(c, "reflect", "where mirrored rays meet what is hidden", -1, index, [=, &c] {
        screen::ReflectInputs in = rays_of(c);
        in.seen = &c.gbuffer(view).position, in.seen_normal = &c.gbuffer(view).normal;
        in.view = c.camera_view(), in.number = camera_number + index, in.before = before();
        return in;
    }));
}

// One map of a light, for the rays that met nothing that the camera sees: of itself alone, so that a light at rest keeps
// what its maps show while another moves (choose_nearest). `first`: of the hits that were found before any map was asked;
// where the map sees nothing they stay.
void add_march_of_map(Context& c, const Asked& seen, int first, Nodes& nodes) {
    const int light = seen.light, index = c.reflect_views++;
    const std::size_t map = std::size_t(seen.map);
    const Light& of = c.lights[std::size_t(light)];
    auto result = [=, &c]() -> Image4& { return c.frame.reflect.hits[std::size_t(index)]; };
    auto before = [=, &c]() -> Image4& { return c.frame.reflect.hits[std::size_t(first)]; };
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

// Of the hits of views, of which the first has what was found before the others were asked, the camera's or, where it has none,
// the nearest; of equals the first.
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

// The nearest hits, and the surfaces that were met behind the picture, a ray each, as if a view saw them. asked[i]: the view of
// number i + 2; first: as of add_march_of_map().
void add_met(Context& c, int view, const std::vector<Asked>& asked, int first, Nodes& nodes) {
    PlannedNode node = begin_node(c, "surfaces in mirrors", "", "", 0, {});
    node.listed = false;
    const bool maps = c.reflect_views - 1 > first;
    const int index = maps ? c.reflect_views++ : first;
    auto hits = [=, &c]() -> Image4& { return c.frame.reflect.hits[std::size_t(index)]; };
    auto views = [=, &c] { return std::span<const Image4>(c.frame.reflect.hits).subspan(std::size_t(first), std::size_t(maps ? index - first : 1)); };
    auto known = [&c](const Asked& a) -> const raster::GBuffer& {
        return a.layer > 0 ? c.gbuffer(a.layer) : c.frame.reflect.seen[std::size_t(a.light)][std::size_t(a.map)];
    };
    auto positions = [&c](const Asked& a) -> const Image4& {
        return a.layer > 0 ? c.gbuffer(a.layer).position : c.maps(a.light)[std::size_t(a.map)].position;
    };
    // Whether something was drawn there.
    auto is_drawn = [&c](const Asked& a) {
        return a.layer > 0 || (c.maps(a.light).size() > std::size_t(a.map) && c.maps(a.light)[std::size_t(a.map)].size > 0);
    };
    node.reads = [=](graph::Reads& r) {
        for (const Image4& of : views()) r.image(of);
        for (const Asked& a : asked) {
            if (!is_drawn(a)) continue;
            const raster::GBuffer& of = known(a);
            r.image(positions(a)), r.image(of.normal), r.image(of.albedo), r.image(of.emission);
        }
    };
    node.outputs = [=, &c] {
        Bundle b;
        const raster::GBuffer& g = c.gbuffer(view);
        if (maps) lend(b, "hit", hits());
        lend(b, "position", g.position), lend(b, "normal", g.normal), lend(b, "albedo", g.albedo), lend(b, "emission", g.emission);
        lend(b, "id", {g.id.height, g.id.width, 2}, reinterpret_cast<const std::int32_t*>(g.id.data()));
        return b;
    };
    auto clear = [=, &c, size = sheet(c)] {
        raster::GBuffer& g = c.gbuffer(view);
        g.position = g.normal = g.albedo = g.emission = Image4(size.x, size.y);
        g.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
        g.covered = raster::Covered(size);
    };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun&) {
        clear();
        raster::GBuffer& g = c.gbuffer(view);
        Image4& nearest = hits();
        if (maps) choose_nearest(views(), options, nearest);
        parallel_bands(nearest.height, 16, options, [&](int from, int to) {
            const std::size_t end = std::size_t(to) * nearest.width;
            for (std::size_t i = std::size_t(from) * nearest.width; i < end; ++i) {
                const glm::vec4 hit = nearest.texels[i];
                const int number = int(hit.w);
                if (number <= camera_number) continue;
                const Asked& a = asked[std::size_t(number - camera_number - 1)];
                const glm::ivec2 at(int(hit.x), int(hit.y));
                const raster::GBuffer& of = known(a);
                g.position.texels[i] = positions(a)(at.x, at.y);
                g.normal.texels[i] = of.normal(at.x, at.y);
                g.albedo.texels[i] = of.albedo(at.x, at.y), g.emission.texels[i] = of.emission(at.x, at.y);
                g.id.texels[i] = of.id(at.x, at.y);
            }
        });
        g.covered = covered_by(g.normal);
    };
    node.leave_out = [=, &c] {
        clear();
        if (maps) hits() = c.frame.reflect.hits[std::size_t(first)];
    };
    nodes.push_back(std::move(node));
}

// Returns the view of what was met behind the picture; 0: none.
int add_behind(Context& c, Nodes& nodes) {
    if (c.views.back().kind != ViewKind::mirrored) return 0;
    const int view = int(c.views.size()) - 1;
    std::vector<Asked> asked;
    for (int v = views_before_mirrors(c.views); v < view; ++v) {
        asked.push_back({v, -1, 0});
        add_march_of_layer(c, v, nodes);
    }
    const int first = c.reflect_views - 1;
    for (int l = 0; l < int(c.lights.size()) && reflects_maps(c.settings); ++l) {
        const Light& light = c.lights[std::size_t(l)];
        if (!light.on || light.intensity == glm::vec3(0)) continue;
        add_seen(c, l, nodes);
        for (int m = 0; m < raster::map_count(light); ++m) {
            asked.push_back({0, l, m});
            add_march_of_map(c, asked.back(), first, nodes);
        }
    }
    add_met(c, view, asked, first, nodes);
    const auto light_met = [&](const std::string& work) { nodes.back().work = work, nodes.back().plan.reason = "lights what mirrors show"; };
    for (int l = 0; l < int(c.lights.size()) && casts_shadows(c.settings); ++l) add_shadow(c, l, view, nodes), light_met("reflect shadow");
    add_direct(c, view, nodes), light_met("reflect direct");
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
        if (has_lobes(c)) in.lobe = &made.lobe, in.rays = &made.rays;
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
    const glm::ivec2 all = sheet(c);
    if (has_lobes(c) && double(all.x) * all.y > most_sheet_pixels)
        throw InputError(fmt::format("reflect: rays = {} at {} x {}: a sheet of {:.0f} million pixels: expected at most {:.0f} million", c.settings.reflect.rays,
                                     c.size.x, c.size.y, double(all.x) * all.y / 1e6, most_sheet_pixels / 1e6));
    add_mirrors(c, nodes);
    add_rays(c, nodes);
    add_march_of_camera(c, nodes);
    add_mirror(c, add_behind(c, nodes), nodes);
}

}  // namespace plumb::frame
