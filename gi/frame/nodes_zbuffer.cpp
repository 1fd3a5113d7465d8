// The z-buffer techniques: light at vertices, interpolated, or at pixels; and the vertices' normals over the picture.
#include <cmath>

#include "gi/frame/frame_graph.h"
#include "gi/zbuffer/normal_lines.h"
#include "gi/zbuffer/zbuffer.h"

namespace plumb::frame {

namespace {

using zbuffer::Technique;

glm::vec3 eye_of(const Context& c) { return glm::vec3(c.camera_view().eye); }

// The vertices as stages read them.
void add_table(Context& c, Nodes& nodes) {
    zbuffer::VertexTable& t = c.frame.zbuffer.table;
    PlannedNode node = begin_node(c, "vertex table", "", "", 0, {});
    node.listed = false, node.of_pixels = false;
    node.reads = [&c](graph::Reads& r) {
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces);
        for (const Material& m : c.scene.materials) r.value(m.specular, m.exponent);
    };
    node.outputs = [&t] {
        Bundle b;
        const auto add = [&b](const char* name, std::size_t rows, int channels, const auto* first) {
            lend(b, name, {std::int64_t(rows), channels}, first);
        };
        add("vertices", t.vertices.size(), 4, t.vertices.empty() ? nullptr : &t.vertices[0].x);
        add("kinds", t.kinds.size(), 2, t.kinds.empty() ? nullptr : &t.kinds[0].x);
        add("corners", t.corners.size(), 4, t.corners.empty() ? nullptr : &t.corners[0].x);
        add("materials", t.materials.size(), 4, t.materials.empty() ? nullptr : &t.materials[0].x);
        add("objects", t.objects.size(), 4, t.objects.empty() ? nullptr : &t.objects[0].x);
        return b;
    };
    const auto make = [&c, &t] { t = zbuffer::vertex_table(c.scene, c.world().geometry); };
    node.run = [=](const RunOptions&, graph::NodeRun&) { make(); };
    node.leave_out = make;
    node.fill = [=, &t] {
        if (t.kinds.empty()) make();
    };
    nodes.push_back(std::move(node));
}

// A stage that writes two images. `inputs` returns what it reads; `Out` holds where it writes.
template <class InputsOf>
void two_images(Context& c, PlannedNode& node, InputsOf inputs, Image4& first, Image4& second) {
    using Inputs = decltype(inputs());
    const StageBinding& binding = stage<typename Inputs::Kernel>();
    const zbuffer::ZbufferParams& params = c.settings.zbuffer;
    node.dispatches = [=, &params] { return std::vector<StageData>{data_of(params, inputs())}; };
    node.reads = [=, &params, &binding](graph::Reads& r) { r.dispatch(binding, data_of(params, inputs())); };
    node.outputs = [&binding, &first, &second] {
        Bundle b;
        lend(b, binding.outputs[0].name, first), lend(b, binding.outputs[1].name, second);
        return b;
    };
    node.explain = [=, &params](glm::ivec2 at) { return plumb::explain(params, inputs(), at); };
    node.leave_out = [&first, &second, size = node.size] { first = second = Image4(size().x, size().y); };
    for (const Slot& slot : binding.outputs) node.results.push_back({slot.name, slot.name, slot.name});
}

void add_vertices(Context& c, Nodes& nodes) {
    ZbufferBuffers& z = c.frame.zbuffer;
    PlannedNode node = begin_node(c, stage<zbuffer::VerticesKernel>(), "zbuffer", "light at vertices",
                                  c.triangles * double(c.lights.size() + 1));
    node.of_pixels = false;
    node.size = [&c, &z] {
        const zbuffer::VerticesInputs in{&z.table, &c.lights, {}};
        return data_of(c.settings.zbuffer, in).size;
    };
    const auto inputs = [&c, &z] { return zbuffer::VerticesInputs{&z.table, &c.lights, eye_of(c)}; };
    two_images(c, node, inputs, z.vertex_light.diffuse, z.vertex_light.specular);
    node.run = [=, &c, &z](const RunOptions& options, graph::NodeRun& run) {
        zbuffer::run(c.settings.zbuffer, inputs(), options, z.vertex_light);
        run.bytes = 2 * bytes_of(z.vertex_light.diffuse);
    };
    nodes.push_back(std::move(node));
}

// Both stages write direct light and what is sent beside it.
template <class InputsOf>
void add_pixels(Context& c, double turns, const std::string& why, InputsOf inputs, Nodes& nodes) {
    using Inputs = decltype(inputs());
    Image4 &direct = c.frame.direct, &sent = c.frame.zbuffer.sent;
    PlannedNode node = begin_node(c, stage<typename Inputs::Kernel>(), "zbuffer", why, turns);
    node.direct = true;
    two_images(c, node, inputs, direct, sent);
    node.run = [=, &c, &direct, &sent](const RunOptions& options, graph::NodeRun& run) {
        zbuffer::PixelLight made{std::move(direct), std::move(sent)};  // written in place
        zbuffer::run(c.settings.zbuffer, inputs(), options, made);
        direct = std::move(made.irradiance), sent = std::move(made.sent);
        run.bytes = 2 * bytes_of(direct);
    };
    nodes.push_back(std::move(node));
}

}  // namespace

void add_zbuffer(Context& c, Nodes& nodes) {
    ZbufferBuffers& z = c.frame.zbuffer;
    const raster::GBuffer& g = c.frame.gbuffer;
    const double pixels = double(c.size.x) * c.size.y;
    add_table(c, nodes);
    if (zbuffer::per_pixel(c.settings.zbuffer.technique))
        return add_pixels(c, pixels * double(c.lights.size() + 1), "light at pixels", [&c, &g, &z] {
            return zbuffer::PixelsInputs{&g.position, &g.normal, &g.albedo, &g.emission, &g.id, &z.table, &c.lights, eye_of(c)};
        }, nodes);
    add_vertices(c, nodes);
    add_pixels(c, pixels, "light of vertices", [&c, &g, &z] {
        return zbuffer::InterpolateInputs{&g.position, &g.id, &g.emission, &z.table, &z.vertex_light, eye_of(c)};
    }, nodes);
}

void add_vertex_normals(Context& c, Nodes& nodes) {
    if (!c.settings.zbuffer.normals) return;
    Image4& made = c.frame.zbuffer.vertex_normals;
    PlannedNode node = begin_node(c, "vertex normals", "", "", 0, {});
    node.listed = false;
    const auto length = [&c] {
        const World& w = c.world();
        return double(c.settings.zbuffer.normal_length) * glm::length(glm::dvec3(w.high) - glm::dvec3(w.low));
    };
    node.reads = [=, &c](graph::Reads& r) {
        r.image(c.frame.display), r.image(c.frame.gbuffer.position), r.list(c.frame.zbuffer.table.vertices);
        r.value(length(), c.camera_view().world_to_clip(), c.camera_view().eye, c.camera_view().forward);
    };
    node.outputs = [&made] { return lent("display", made); };
    node.run = [=, &c, &made](const RunOptions&, graph::NodeRun&) {
        made = c.frame.display;
        zbuffer::draw_normals(c.frame.zbuffer.table, c.camera_view(), c.frame.gbuffer.position, length(), made);
    };
    node.leave_out = [&c, &made] { made = c.frame.display; };
    nodes.push_back(std::move(node));
}

}  // namespace plumb::frame
