// Ambient occlusion (gi/screen): of the camera, of the maps of each light that shines, their mean, and what it leaves of
// indirect light.
#include <fmt/format.h>

#include <memory>

#include "core/parallel.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/isr.h"
#include "gi/screen/screen.h"

namespace plumb::frame {

bool occludes(const Settings& settings) {
    return settings.ao.method != screen::AoMethod::off && settings.method != Method::reference;
}

namespace {

using screen::AoMethod;

// A view's image in their order.
Image4& of_view(Context& c, int index) { return c.frame.ao.views[std::size_t(index)]; }

double pixels(const Context& c) { return double(c.size.x) * c.size.y; }

void add_own(Context& c, Nodes& nodes) {
    const screen::AoParams& p = c.settings.ao;
    const bool horizon = p.method == AoMethod::horizon;
    const double turns = pixels(c) * (horizon ? 2.0 * p.slices * p.steps : double(p.samples));
    PlannedNode node = begin_node(c, horizon ? stage<screen::HorizonKernel>() : stage<screen::SsaoKernel>(), "ao",
                                  "how open points are", turns);
    node.results = {{"open share", "", "open", 2, 1}};
    const int index = c.ao_views++;
    auto result = [=, &c]() -> Image4& { return of_view(c, index); };
    if (horizon)
        compute(c, node, p,
                [&c] {
                    const raster::GBuffer& g = c.frame.gbuffer;
                    return screen::HorizonInputs{&g.position, &g.normal, c.camera_view(), nullptr};
                },
                result);
    else
        compute(c, node, p,
                [&c] {
                    const raster::GBuffer& g = c.frame.gbuffer;
                    return screen::SsaoInputs{&g.position, &g.normal, &g.position, c.camera_view(), true, nullptr, nullptr};
                },
                result);
    node.in_steps = true;
    nodes.push_back(std::move(node));
}

AoShare& share_of(Context& c, int index) {
    std::vector<AoShare>& all = c.memory->ao_shares;
    if (all.size() <= std::size_t(index)) all.resize(std::size_t(index) + 1);
    return all[std::size_t(index)];
}

// before + share, as the stage adds what it is given before: the same operations, the same bits.
void add_share(const Image4& before, const Image4& share, int threads, Image4& sum) {
    if (sum.width != before.width || sum.height != before.height) sum = Image4(before.width, before.height);
    parallel_bands(before.height, 16, threads, [&](int first, int last) {
        for (std::size_t i = std::size_t(first) * std::size_t(before.width); i < std::size_t(last) * std::size_t(before.width); ++i) {
            const glm::vec4 &a = before.texels[i], &b = share.texels[i];
            sum.texels[i] = {a.x + b.x, a.y + b.y, a.z, a.w};
        }
    });
}

// One map of a light. Where frames keep what they made, its share is kept apart: where only what was summed before it is another, it is
// added again and not sampled. Where it sees nothing what was summed before goes on.
void add_map(Context& c, int light, int map, Nodes& nodes) {
    const screen::AoParams& p = c.settings.ao;
    PlannedNode node = begin_node(c, stage<screen::SsaoKernel>(), "ao light", "how open points are to this light",
                                  pixels(c) * p.samples, light);
    if (raster::map_count(c.lights[std::size_t(light)]) > 1) set_form(node, raster::face_names[map]);
    node.results = {{"sum", "", "sum"}};
    const int index = c.ao_views++;
    auto result = [=, &c]() -> Image4& { return of_view(c, index); };
    auto before = [=, &c]() -> Image4& { return of_view(c, index - 1); };
    auto is_drawn = [=, &c] {
        return c.maps(light).size() > std::size_t(map) && c.maps(light)[std::size_t(map)].size > 0;
    };
    node.leave_out = [=] { result() = before(); };
    node.reads_left_out = [=](graph::Reads& r) { r.image(before()); };
    auto inputs = [=, &c](bool alone) {
        const raster::GBuffer& g = c.frame.gbuffer;
        const raster::Rsm& rsm = c.maps(light)[std::size_t(map)];
        return screen::SsaoInputs{&g.position, &g.normal, &rsm.position, rsm.view, false, alone ? nullptr : &before(), nullptr};
    };
    compute(c, node, p, [=] { return inputs(false); }, result);
    node.in_steps = true;
    const auto key = std::make_shared<graph::Key>(0);  // of its share
    node.run = [=, &c, &p, run = node.run, work = node.tile_work()](const RunOptions& options, graph::NodeRun& row) {
        if (!is_drawn()) {
            result() = before();
            return;
        }
        if (!c.keeps) return run(options, row);
        const raster::Covered tiles = c.tiles_to_shade(work, c.frame.gbuffer.covered, row);
        AoShare& share = share_of(c, index);
        if (share.key != *key || share.sum.empty()) {
            screen::SsaoInputs in = inputs(true);
            in.tiles = or_all(tiles);
            screen::run(p, in, options, share.sum);
            share.key = *key;
        }
        add_share(before(), share.sum, options.threads, result());
        row.bytes = bytes_of(result()) + bytes_of(share.sum);
    };
    node.reads = [=, &p, reads = node.reads](graph::Reads& r) {
        if (!is_drawn()) return r.image(before());
        graph::Reads alone = r;
        alone.dispatch(stage<screen::SsaoKernel>(), data_of(p, inputs(true)));
        *key = alone.key();
        reads(r);
    };
    node.dispatches = [=, dispatches = node.dispatches] {
        return is_drawn() ? dispatches() : std::vector<StageData>();
    };
    node.explain = [=, explain = node.explain](glm::ivec2 pixel) {
        if (is_drawn()) return explain(pixel);
        const glm::vec4 sum = before()(pixel.x, pixel.y);
        return std::vector<TapValue>{{"sum", -1, {sum.x, sum.y, sum.z}, "the map sees nothing: as before"}};
    };
    nodes.push_back(std::move(node));
}

void add_lights(Context& c, Nodes& nodes) {
    if (c.settings.ao.views != screen::AoViews::lights || !casts_shadows(c.settings)) return;
    for (int l = 0; l < int(c.lights.size()); ++l) {
        const Light& light = c.lights[std::size_t(l)];
        if (!light.on || light.intensity == glm::vec3(0)) continue;
        for (int m = 0; m < raster::map_count(light); ++m) add_map(c, l, m, nodes);
    }
}

void add_blur(Context& c, Nodes& nodes) {
    const double side = c.settings.ao.blur == screen::AoBlur::none ? 1 : 5;
    PlannedNode node = begin_node(c, stage<screen::BlurKernel>(), "ao", "the mean over views, without its pattern",
                                  pixels(c) * side * side);
    node.results = {{"open share", "", "open", 0, 1}};
    const int last = c.ao_views - 1;
    compute(c, node, c.settings.ao,
            [=, &c] {
                const raster::GBuffer& g = c.frame.gbuffer;
                return screen::BlurInputs{&of_view(c, last), &g.position, &g.normal, nullptr};
            },
            [&c]() -> Image4& { return c.frame.ao.open; });
    nodes.push_back(std::move(node));
}

void add_occlude(Context& c, Nodes& nodes) {
    PlannedNode node = begin_node(c, stage<screen::OccludeKernel>(), "ao", "what is left of indirect light", pixels(c));
    node.results = {{"occluded", "", "occluded"}};
    compute(c, node, c.settings.ao, [&c] { return screen::OccludeInputs{&c.frame.indirect, &c.frame.ao.open}; },
            [&c]() -> Image4& { return c.frame.ao.lit; });
    nodes.push_back(std::move(node));
}

}  // namespace

const Image4& indirect_to_compose(const Context& c) {
    return occludes(c.settings) ? c.frame.ao.lit : c.frame.indirect;
}

void add_ao(Context& c, Nodes& nodes) {
    if (c.memory && (!occludes(c.settings) || c.settings.ao.views != screen::AoViews::lights)) c.memory->ao_shares.clear();
    if (!occludes(c.settings)) return;
    screen::validate(c.settings.ao);
    add_own(c, nodes);
    add_lights(c, nodes);
    add_blur(c, nodes);
    add_occlude(c, nodes);
}

}  // namespace plumb::frame
