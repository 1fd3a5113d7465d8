#include "gi/frame/frame_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "gi/frame/filters.h"
#include "gi/frame/rules.h"

namespace plumb::frame {

Context::Context(const Scene& s, const Settings& t, Frame& f)
    : scene(s), settings(t), frame(f), size(s.frame_size), views(isr_views(s, t)), relief(relief_use(s, t)), static_lamps(frame::static_lamps(s, t)) {
    for (const Light& light : s.lights) lights.push_back(shining(light));
}

World& Context::world() {
    if (memory) return memory->world;
    if (!own_world_) {
        own_world_ = std::make_unique<World>();
        own_world_->update(scene, settings, nullptr);
    }
    return *own_world_;
}

Image4& Context::term(int light) {
    if (memory) return memory->irradiance[std::size_t(light)];
    own_terms_.resize(lights.size());
    return own_terms_[std::size_t(light)];
}
Image4& Context::term_error(int light) {
    if (memory) return memory->irradiance_error[std::size_t(light)];
    own_errors_.resize(lights.size());
    return own_errors_[std::size_t(light)];
}

raster::Covered Context::tiles_to_shade(const TileWork& of, const raster::Covered& covered, graph::NodeRun& run) const {
    if (!plan) return {};
    RunFacts seen{frame.gbuffer, {}, covered};
    if (of.light >= 0) seen.maps = frame.rsms[std::size_t(of.light)];
    raster::Covered tiles = covered;
    Work work{of.work, "tile", of.light};
    const Rule* by = nullptr;
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < tiles.any.size(); ++i) {
        work.index = int(i);
        const Rule* rule = left_out_by(plan->run_rules, seen, work);
        tiles.any[i] = !rule;
        if (rule) by = rule, ++left_out;
    }
    if (!by) return {};
    const std::string reason = fmt::format("{} of {} tiles left out: each {}", left_out, tiles.any.size(), by->reason);
    const double saved_ms = of.expected_ms * double(left_out) / double(tiles.any.size());
    run.parts.push_back({by->name, reason, saved_ms});
    run.saved_ms += saved_ms;
    return tiles;
}

FrameGraph::FrameGraph(const Scene& scene, const Settings& settings, const Geometry& geometry)
    : own_frame_(std::make_unique<Frame>()), context_(std::make_unique<Context>(scene, settings, *own_frame_)) {
    context_->triangles = double(geometry.triangles.size());
    add_nodes();
}

// What nodes write they write when they run; fill() is for who owns the frame.
FrameGraph::FrameGraph(const Scene& scene, const Settings& settings, const Frame& frame)
    : context_(std::make_unique<Context>(scene, settings, const_cast<Frame&>(frame))) {
    add_nodes();
}

FrameGraph::FrameGraph(const Scene& scene, const Settings& settings, const Plan& plan, KeptMemory& memory)
    : context_(std::make_unique<Context>(scene, settings, memory.frame)) {
    context_->memory = &memory, context_->plan = &plan;
    add_nodes();
}

namespace {

// A name as a part of a file's: letters, digits and '-' stay.
std::string word_of(const std::string& name) {
    std::string word;
    for (const char c : name)
        word += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ? c : '_';
    return word;
}

// The words of the lights, no two alike.
std::vector<std::string> light_words(const Scene& scene) {
    std::vector<std::string> words;
    for (const Light& light : scene.lights) {
        std::string word = light.name.empty() ? "light" : word_of(light.name);
        while (std::find(words.begin(), words.end(), word) != words.end()) word += "_";
        words.push_back(word);
    }
    return words;
}

}  // namespace

void FrameGraph::add_nodes() {
    Context& c = *context_;
    light_words_ = light_words(c.scene);
    const int lights = casts_shadows(c.settings) ? int(c.lights.size()) : 0;
    // What mirrored rays meet is known, and lit, when the maps are there; the layers that they are followed in are not lit.
    const int drawn = int(c.views.size()) - (c.views.back().kind == ViewKind::mirrored ? 1 : 0);
    const int lit = views_before_mirrors(c.views);
    add_gbuffer(c, 0, nodes_);
    add_filters_before(c, nodes_);
    if (reuses_light(c.settings)) add_light_clock(c, nodes_);
    for (int v = 1; v < drawn; ++v)
        if (c.views[std::size_t(v)].kind == ViewKind::probe_rays)
            add_probe_hits(c, v, nodes_);
        else
            add_gbuffer(c, v, nodes_);
    for (int l = 0; l < lights; ++l) {
        add_maps(c, l, nodes_);
        add_map_blurs(c, l, nodes_);
        for (int v = 0; v < lit; ++v) add_shadow(c, l, v, nodes_);
        add_shadow_filter(c, l, nodes_);
        if (c.settings.method == Method::rsm) add_gather(c, l, nodes_);
    }
    add_sum(c, nodes_);
    add_filters_after(c, nodes_);
    add_static_visibility(c, nodes_);
    if (c.settings.method == Method::zbuffer)
        add_zbuffer(c, nodes_);
    else
        for (int v = 0; v < lit; ++v) add_direct(c, v, nodes_);
    add_isr(c, nodes_);
    add_probes(c, nodes_);
    add_radiosity(c, nodes_);
    add_ao(c, nodes_);
    add_compose(c, nodes_);
    add_reflect(c, nodes_);
    add_relief_layers(c, nodes_);
    if (c.settings.method == Method::reference) add_traced(c, "color", "the picture", nodes_);
    add_tonemap(c, nodes_);
    if (c.settings.method == Method::zbuffer) add_vertex_normals(c, nodes_);
    if (!c.settings.truth) return;
    add_traced(c, "truth", "the truth of color", nodes_);
    add_traced(c, "truth.direct", "the truth of direct: lamps alone", nodes_);
    const std::vector<std::string>& own = methods().at(std::size_t(c.settings.method)).transport;
    if (std::find(own.begin(), own.end(), "truth.indirect") != own.end())
        add_traced(c, "truth.indirect", "the truth of indirect: one bounce of the lamps' light", nodes_);
    if (occludes(c.settings)) add_traced(c, "truth.ao", "the truth of ao: rays of its radius", nodes_);
    if (reflects(c.settings)) add_traced(c, "truth.reflection", "the truth of reflection: mirrored rays, all light", nodes_);
}

const PlannedNode& FrameGraph::node(const PlannedStage& stage) const {
    for (const PlannedNode& node : nodes_)
        if (node.listed && graph::same_node(node.plan, stage)) return node;
    throw std::logic_error(fmt::format("no frame of these settings has a node {}", stage.label));
}

std::vector<const graph::Node*> FrameGraph::planned(const Plan& plan) {
    std::vector<const graph::Node*> nodes;
    auto traces = [&](const std::string& layer) {
        return std::any_of(plan.stages.begin(), plan.stages.end(),
                           [&](const PlannedStage& s) { return s.layer == layer && s.needed; });
    };
    for (PlannedNode& node : nodes_) {
        if (!node.listed) {
            node.plan.needed = node.of_layer.empty() || traces(node.of_layer);
            nodes.push_back(&node);
            continue;
        }
        const auto row = std::find_if(plan.stages.begin(), plan.stages.end(),
                                      [&](const PlannedStage& s) { return graph::same_node(node.plan, s); });
        if (row == plan.stages.end()) continue;
        node.plan = *row;
        nodes.push_back(&node);
    }
    return nodes;
}

std::vector<StageData> FrameGraph::dispatches(const PlannedNode& node) const {
    std::vector<StageData> all;
    if (node.dispatches) all = node.dispatches();
    for (StageData& data : all) {
        const std::string part = data.id;  // the face
        data.label = node.plan.label + (part.empty() ? "" : " " + part);
        data.id = file_name(node, part);
    }
    return all;
}

std::string FrameGraph::file_name(const PlannedNode& node, const std::string& part) const {
    const graph::NodePlan& p = node.plan;
    std::string id = p.name;
    if (!p.form.empty()) id += "." + word_of(p.form);
    if (p.light >= 0) id += "." + light_words_.at(std::size_t(p.light));
    if (!part.empty()) id += "." + part;
    if (p.view > 0) id += "." + word_of(node.view_name);
    if (!p.layer.empty()) id += "." + p.layer;
    return id;
}

void FrameGraph::make_room() {
    Context& c = *context_;
    Frame& f = c.frame;
    const std::size_t lights = c.lights.size();
    f.rsms.resize(lights), f.maps_blurred_across.resize(lights), f.maps_blurred.resize(lights);
    f.isr.gathered.resize(std::size_t(c.isr_gathers)), f.isr.radiosities.resize(std::size_t(c.isr_bounces));
    f.isr.unseen.resize(std::size_t(c.isr_unseen)), f.ao.views.resize(std::size_t(c.ao_views));
    f.reflect.hits.resize(std::size_t(c.reflect_views)), f.reflect.nearest.resize(std::size_t(c.reflect_views));
    f.reflect.seen.resize(reflects(c.settings) ? lights : 0);
    f.views.resize(c.views.size() > 1 ? c.views.size() : 0);
    for (std::size_t v = 1; v < c.views.size(); ++v)
        f.views[v].name = c.views[v].name, f.views[v].camera = c.views[v].camera, f.views[v].size = c.views[v].size;
    const bool lit = !casts_shadows(c.settings);  // everything is
    for (int v = 0; v < int(c.views.size()); ++v) {
        if (c.views[std::size_t(v)].kind == ViewKind::mirror_layer) continue;
        Buffer<float>& visibility = c.visibility(v);
        visibility.resize(lights * c.pixels(v), 1.0f);
        if (lit) std::fill(visibility.begin(), visibility.end(), 1.0f);
    }
    if (filters_shadows(c.settings))
        for (Buffer<float>* made : {&f.visibility_across, &f.visibility_filtered}) made->resize(lights * c.pixels(0), 1.0f);
    if (!sums_gathers(c.settings)) f.indirect_error = {};
}

void FrameGraph::fill() {
    make_room();
    for (const PlannedNode& node : nodes_) {
        const Bundle outputs = node.outputs();
        const bool missing = std::all_of(outputs.arrays.begin(), outputs.arrays.end(),
                                         [](const Array& a) { return a.bytes.empty(); });
        if (node.fill)
            node.fill();
        else if (missing)
            node.leave_out();
    }
}

// ---- For the files that add nodes --------------------------------------------------------------------------------------

PlannedNode begin_node(Context& c, const std::string& name, const std::string& work, const std::string& why, double turns,
                       const Cost& cost, int light) {
    PlannedNode node;
    graph::NodePlan& p = node.plan;
    p.name = name, p.light = light, p.reason = why;
    p.label = light < 0 ? name : fmt::format("{} ({})", name, c.scene.lights[std::size_t(light)].name);
    p.work = turns, p.work_unit = cost.unit, p.expected_ms = turns * 1e-6 * cost.ms_per_million;
    node.work = work;
    node.size = [&c] { return c.size; };
    return node;
}

PlannedNode begin_node(Context& c, const StageBinding& binding, const std::string& work, const std::string& why,
                       double turns, int light) {
    return begin_node(c, binding.info.name, work, why, turns, binding.cost, light);
}

namespace {

// "rsm.disc (key)" as "rsm.disc (key, word)".
void add_to_label(std::string& label, const std::string& word) {
    if (label.ends_with(')'))
        label.insert(label.size() - 1, ", " + word);
    else
        label += " (" + word + ")";
}

}  // namespace

void set_view(Context& c, PlannedNode& node, int view) {
    if (view == 0) return;
    graph::NodePlan& p = node.plan;
    node.view_name = c.views[std::size_t(view)].name;
    p.view = view;
    add_to_label(p.label, node.view_name);
    if (p.reason.empty()) p.reason = "indirect light reads it";
}

void set_form(PlannedNode& node, const std::string& form) {
    node.plan.form = form;
    if (!form.empty()) add_to_label(node.plan.label, form);
}

std::vector<TapValue> with_stored(std::vector<TapValue> values, const char* name, Format format,
                                  const raster::Layout& layout) {
    if (format == Format::r32f || format == Format::rgba32f) return values;
    const auto result = std::find_if(values.rbegin(), values.rend(), [&](const TapValue& v) { return v.name == name; });
    if (result == values.rend()) return values;
    glm::vec4 texel(0);
    for (std::size_t c = 0; c < result->value.size(); ++c) texel[int(c)] = float(result->value[c]);
    quantise(format, texel);
    TapValue stored{std::string("stored_") + name, -1, {}, "as layout " + layout.name + " stores it"};
    for (std::size_t c = 0; c < result->value.size(); ++c) stored.value.push_back(texel[int(c)]);
    values.push_back(std::move(stored));
    return values;
}

Bundle lent(const std::string& name, const Image4& image) {
    Bundle bundle;
    lend(bundle, name, image);
    return bundle;
}

}  // namespace plumb::frame
