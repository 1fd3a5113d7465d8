// Direct light: the shadows of each light, and what all lights send without a bounce.
#include <algorithm>

#include "gi/direct/direct.h"
#include "gi/direct/visibility_filter.h"
#include "gi/frame/frame_graph.h"

namespace plumb::frame {

// Two passes over all maps of the light (ISR 4.6). What leaves out its shadow leaves them out.
void add_map_blurs(Context& c, int l, Nodes& nodes) {
    const direct::ShadowParams& params = c.settings.shadow;
    if (!direct::blurs_maps(params)) return;
    const Light& light = c.lights[std::size_t(l)];
    const int maps = raster::map_count(light);
    const double side = light.rsm_size, texels = maps * side * side;
    for (const bool across : {true, false}) {
        const StageBinding& binding = stage<direct::LogBlurKernel>();
        PlannedNode node = begin_node(c, binding, "shadow", "shadow reads it", texels * (2 * params.esm_blur_radius + 1), l);
        set_form(node, across ? "horizontal" : "vertical");
        node.of_pixels = false, node.in_steps = node.direct = true;
        node.results = {{"depth", binding.outputs[0].name, "depth", 3, 1}};
        node.size = [=] { return glm::ivec2(maps * int(side), int(side)); };

        auto result = [=, &c]() -> std::vector<Image4>& {
            return (across ? c.frame.maps_blurred_across : c.frame.maps_blurred)[std::size_t(l)];
        };
        auto inputs = [=, &c](std::size_t m) {
            const std::vector<raster::Rsm>& drawn = c.maps(l);
            return direct::LogBlurInputs{across ? &drawn[m].position : &c.frame.maps_blurred_across[std::size_t(l)][m],
                                         across ? direct::Direction::horizontal : direct::Direction::vertical,
                                         direct::depth_range(drawn)};
        };
        node.dispatches = [=, &c, &params] {
            std::vector<StageData> all;
            each_map(c.maps(l), [&](const raster::Rsm&, int m, const std::string& face) {
                all.push_back(data_of(params, inputs(std::size_t(m))));
                all.back().id = face;
            });
            return all;
        };
        node.reads = [dispatches = node.dispatches, &binding](graph::Reads& r) {
            for (const StageData& data : dispatches()) r.text(data.id), r.dispatch(binding, data);
        };
        node.reads_left_out = [=](graph::Reads& r) { r.value(maps); };
        node.outputs = [=, &binding] {
            Bundle b;
            for (std::size_t m = 0; m < result().size(); ++m)
                lend(b, (result().size() > 1 ? std::string(raster::face_names[m]) + "." : "") + binding.outputs[0].name,
                     result()[m]);
            return b;
        };
        auto blur = [=, &c, &params](const RunOptions& options, bool all) {
            const std::vector<raster::Rsm>& drawn = c.maps(l);
            result().resize(drawn.size());
            for (std::size_t m = 0; m < drawn.size(); ++m) {
                if (drawn[m].size == 0)
                    result()[m] = {};
                else if (all || result()[m].empty())
                    direct::run(params, inputs(m), options, result()[m]);
            }
        };
        node.run = [=](const RunOptions& options, graph::NodeRun& run) {
            blur(options, true);
            for (const Image4& image : result()) run.bytes += bytes_of(image);
        };
        node.leave_out = [=] { result().clear(); };
        node.fill = [=] { blur({}, false); };
        // A texel of the blurred map, or of its six maps side by side.
        node.explain = [=, &c, &params](glm::ivec2 texel) {
            const int face = texel.x / int(side);
            std::vector<TapValue> values;
            if (maps > 1) values.push_back({"face", -1, {double(face)}, "of the point light: +x -x +y -y +z -z"});
            if (c.maps(l)[std::size_t(face)].size == 0) {
                values.push_back({"depth", -1, {0.0}, "the face sees nothing"});
                return values;
            }
            const std::vector<TapValue> taps =
                direct::explain(params, inputs(std::size_t(face)), {texel.x - face * int(side), texel.y});
            values.insert(values.end(), taps.begin(), taps.end());
            return values;
        };
        nodes.push_back(std::move(node));
    }
}

void add_shadow(Context& c, int l, int view, Nodes& nodes) {
    const direct::ShadowParams& params = c.settings.shadow;
    const StageBinding& binding = stage<direct::ShadowKernel>();
    const glm::ivec2 size = c.views[std::size_t(view)].size;
    const std::size_t pixels = c.pixels(view);
    const std::string reader = filters_shadows(c.settings) ? std::string(direct::visibility_filter_stage) + " reads it" : "direct light reads it";
    PlannedNode node = begin_node(c, binding, "shadow", view > 0 ? "" : reader, double(pixels), l);
    set_view(c, node, view);
    node.of_pixels = node.by_name = view == 0, node.direct = true;
    node.results = {{binding.outputs[0].name, binding.outputs[0].name, binding.outputs[0].name, 0, 1, true}};
    node.size = [=] { return size; };

    auto inputs = [=, &c, &params] {
        const raster::GBuffer& g = c.gbuffer(view);
        direct::ShadowInputs in{&g.position, &g.normal, c.maps(l)};
        if (direct::blurs_maps(params)) in.blurred = c.frame.maps_blurred[std::size_t(l)];
        in.rounding = direct::rounding_of(c.settings.layout);
        in.picture = true;
        return in;
    };
    node.dispatches = [=, &c, &params] {
        std::vector<StageData> all;
        each_map(c.maps(l), [&](const raster::Rsm&, int m, const std::string& face) {
            all.push_back(data_of(params, inputs(), m));
            all.back().id = face;
        });
        return all;
    };
    node.reads = [dispatches = node.dispatches, &binding, &c](graph::Reads& r) {
        r.value(c.settings.layout.visibility);
        for (const StageData& data : dispatches()) r.dispatch(binding, data);
    };
    node.outputs = [=, &c, &binding] {
        Bundle b;
        const Buffer<float>& all = c.visibility(view);
        const bool there = all.size() >= (std::size_t(l) + 1) * pixels;
        lend(b, binding.outputs[0].name, there ? Shape{size.y, size.x} : Shape{0, 0},
             there ? all.data() + std::size_t(l) * pixels : nullptr);
        return b;
    };
    node.run = [=, &c, &params, work = node.tile_work()](const RunOptions& options, graph::NodeRun& run) {
        const raster::Covered tiles = c.tiles_to_shade(work, c.gbuffer(view).covered, run);
        direct::ShadowInputs in = inputs();
        in.tiles = or_all(tiles);
        direct::run(params, in, options, c.visibility(l, view));
        raster::quantise(c.settings.layout.visibility, c.visibility(l, view), size, options.threads);
        run.bytes = pixels * sizeof(float);
    };
    node.leave_out = [=, &c] {
        std::fill_n(c.visibility(l, view), pixels, 1.0f);
    };
    node.explain = [=, &c, &params, &binding](glm::ivec2 pixel) {
        return with_stored(direct::explain(params, inputs(), pixel), binding.outputs[0].name.c_str(),
                           c.settings.layout.visibility, c.settings.layout);
    };
    nodes.push_back(std::move(node));
}

// Two passes over the screen (ISR 4.7). What leaves out the shadow leaves them out.
void add_shadow_filter(Context& c, int l, Nodes& nodes) {
    if (!filters_shadows(c.settings)) return;
    const direct::ShadowParams& params = c.settings.shadow;
    const StageBinding& binding = stage<direct::VisibilityFilterKernel>();
    const glm::ivec2 size = c.size;
    const std::size_t pixels = c.pixels(0);
    for (const bool across : {true, false}) {
        PlannedNode node = begin_node(c, binding, "shadow", "direct light reads it",
                                      double(pixels) * (2 * params.filter_radius + 1), l);
        set_form(node, across ? "horizontal" : "vertical");
        const std::string& output = binding.outputs[0].name;
        node.in_steps = node.direct = true;
        node.results = {{output, output, output, 0, 1, true}};
        node.size = [=] { return size; };

        auto all = [=, &c]() -> Buffer<float>& { return across ? c.frame.visibility_across : c.frame.visibility_filtered; };
        auto result = [=] { return all().data() + std::size_t(l) * pixels; };
        auto data = [=, &c, &params] {
            const float* read = across ? c.visibility(l, 0) : c.frame.visibility_across.data() + std::size_t(l) * pixels;
            return data_of(params, direct::VisibilityFilterInputs{
                                       read, &c.frame.gbuffer.position, &c.frame.gbuffer.normal,
                                       across ? direct::Direction::horizontal : direct::Direction::vertical});
        };
        node.dispatches = [=] { return std::vector<StageData>{data()}; };
        node.reads = [=, &c, &binding](graph::Reads& r) {
            r.value(c.settings.layout.visibility);
            r.dispatch(binding, data());
        };
        node.outputs = [=] {
            Bundle b;
            const bool there = all().size() >= (std::size_t(l) + 1) * pixels;
            lend(b, output, there ? Shape{size.y, size.x} : Shape{0, 0}, there ? result() : nullptr);
            return b;
        };
        node.run = [=, &c, &binding](const RunOptions& options, graph::NodeRun& run) {
            plumb::run(binding, data(), options, result());
            raster::quantise(c.settings.layout.visibility, result(), size, options.threads);
            run.bytes = pixels * sizeof(float);
        };
        node.leave_out = [=] { std::fill_n(result(), pixels, 1.0f); };
        node.explain = [=, &c, &binding](glm::ivec2 pixel) {
            return with_stored(plumb::explain(binding, data(), pixel), output.c_str(), c.settings.layout.visibility,
                               c.settings.layout);
        };
        nodes.push_back(std::move(node));
    }
}

void add_direct(Context& c, int view, Nodes& nodes) {
    const glm::ivec2 size = c.views[std::size_t(view)].size;
    PlannedNode node = begin_node(c, stage<direct::DirectKernel>(), "direct", view > 0 ? "" : "direct light",
                                  double(c.pixels(view)) * double(c.lights.size()));
    set_view(c, node, view);
    node.of_pixels = node.by_name = view == 0, node.direct = true;
    node.size = [=] { return size; };
    node.covered = [=, &c] { return c.gbuffer(view).covered; };
    auto inputs = [=, &c] {
        const raster::GBuffer& g = c.gbuffer(view);
        return direct::DirectInputs{&g.position, &g.normal, &c.lights, &c.lit(view), nullptr,
                                    compose::reads_density(c.settings.compose)};
    };
    compute(c, node, c.settings.direct, inputs, [=, &c]() -> Image4& { return c.direct(view); });
    nodes.push_back(std::move(node));
}

}  // namespace plumb::frame
