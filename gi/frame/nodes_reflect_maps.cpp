// What mirrors show of the lights' maps: each map drawn once more, as a G-buffer.
#include "gi/frame/nodes_reflect.h"

#include "raster/bindings.h"
#include "raster/screen_triangle.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million triangles and texels, as nodes_raster.cpp has them.
constexpr double ms_texels = 60;

// Maps have positions of their own: none is rebuilt from depth, which parallel rays do not allow.
raster::Layout layout_of_maps(const Context& c) {
    raster::Layout layout = c.settings.layout;
    layout.name = "custom";
    layout.position_from_depth = layout.depth_over_far = false;
    return layout;
}

}  // namespace

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
        // Of the last frame what is as large is drawn over.
        drawn().resize(c.maps(light).size());
        for (std::size_t m = 0; m < drawn().size(); ++m)
            if (c.maps(light)[m].size == 0) drawn()[m] = {};
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

}  // namespace plumb::frame
