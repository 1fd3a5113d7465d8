// Hemicube radiosity: elements, their form factors, light at them, what leaves them, and irradiance of pixels.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "gi/frame/frame_graph.h"
#include "gi/frame/nodes_probes.h"
#include "gi/probes/lit_hits.h"
#include "gi/radiosity/explain_row.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/host_stages.h"
#include "gi/radiosity/kept_rows.h"
#include "gi/radiosity/lamp_light.h"
#include "gi/radiosity/lookup.h"
#include "gi/radiosity/own_light.h"
#include "gi/radiosity/rows.h"

namespace plumb::frame {

namespace {

using radiosity::RowBlock;

RadiosityBuffers& buffers(Context& c) { return c.frame.radiosity; }

template <class T>
void lend_list(Bundle& b, const char* name, const T& list) {
    lend(b, name, {std::int64_t(list.size()), 4}, list.empty() ? nullptr : &list[0].x);
}

void read_lists(graph::Reads& r, const std::initializer_list<const Buffer<glm::vec4>*>& lists) {
    for (const Buffer<glm::vec4>* list : lists) r.list(*list);
}

PlannedNode begin(Context& c, const StageInfo& info, const std::string& why, glm::ivec2 size) {
    PlannedNode node = begin_host(c, info, why, size);
    node.work = "radiosity";
    return node;
}

// Of a row on the mean: what an element sees of others' fronts.
double share_of_fronts(const radiosity::FormFactors& f) {
    double fronts = 0;
    for (const double sum : f.sums) fronts += sum;
    return f.count > 0 ? fronts / f.count : 1;
}
constexpr double few_fronts = 0.01;

bool has_alpha_masks(Context& c) {
    const std::vector<std::int32_t>& of = c.world().geometry.material;
    return std::any_of(of.begin(), of.end(), [&](std::int32_t m) { return m >= 0 && c.scene.materials[std::size_t(m)].alpha_cutoff > 0; });
}

void add_elements(Context& c, Nodes& nodes) {
    RadiosityBuffers& b = buffers(c);
    PlannedNode node = begin(c, radiosity::info_elements(), "irradiance is computed there", {1, 1});
    node.reads = [&c](graph::Reads& r) {
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces), r.source("emission", c.keys.emission);
        radiosity::RadiosityParams p = c.settings.radiosity;
        r.value(p.kind, p.crease_deg, p.offset, p.inset, p.split, p.small_emitters);
    };
    node.outputs = [&b] {
        Bundle all;
        lend_list(all, "position", b.elements.position), lend_list(all, "normal", b.elements.normal), lend_list(all, "eye", b.elements.eye);
        lend_list(all, "reflectance", b.elements.reflectance), lend_list(all, "exitance", b.elements.exitance);
        lend_list(all, "lamp_exitance", b.elements.lamp_exitance);
        lend_list(all, "corners", b.triangles.corners), lend_list(all, "of", b.triangles.of);
        return all;
    };
    node.run = [&c, &b](const RunOptions& options, graph::NodeRun& run) {
        b.elements = {};
        if (!c.world().geometry.triangles.empty())
            b.elements = radiosity::elements_of(c.scene, radiosity::element_params(c.settings.radiosity), options);
        b.triangles = radiosity::triangle_elements(b.elements);
        run.bytes = b.elements.position.size() * 80;
        run.reason = fmt::format("{} elements, {} triangles, {:.3g} m off the surface{}", b.elements.count(), b.triangles.of.size(), b.elements.offset_m,
                                 b.elements.nearer > 0 ? fmt::format("; geometry is nearer to {}", b.elements.nearer) : "");
        if (has_alpha_masks(c)) run.reason += "; of what an alpha mask cuts, triangles without anything left are not there, all others are seen whole";
    };
    node.leave_out = [&b] { b = {}; };
    nodes.push_back(std::move(node));
}

radiosity::RowExplained explained_row(const Context& c, const RadiosityBuffers& b, int element) {
    return radiosity::explain_row(b.elements, radiosity::row_params(c.settings.radiosity), b.factors, b.sky, b.radiosity, element);
}

std::vector<ItemPicture> pictures_of(const radiosity::RowPictures& p) {
    std::vector<ItemPicture> all;
    const auto keep = [&](const char* name, const char* unit, const char* meaning, DType dtype, auto& image) {
        using Texel = std::decay_t<decltype(image.texels[0])>;
        const int channels = int(sizeof(Texel) / 4);
        Bundle made;
        Array& array = add(made, name, dtype, {image.height, image.width, channels});
        std::memcpy(array.bytes.data(), image.texels.data(), image.size() * sizeof(Texel));
        all.push_back({{.name = name, .dtype = dtype, .channels = channels, .unit = unit, .meaning = meaning}, array});
    };
    keep("triangle", "", "that each texel sees, the top in the middle; -1: none", DType::i32, p.triangle);
    Image<float> weight(p.weight.width, p.weight.height);
    for (std::size_t i = 0; i < weight.size(); ++i) weight.texels[i] = p.weight.texels[i].x;
    keep("weight", "", "share of the hemisphere, weighted by cosine: all add up to 1", DType::f32, weight);
    keep("radiosity", "W/m2", "of what is seen; backs send none", DType::f32, p.radiosity);
    keep("brought", "W/m2", "weight times radiosity: all add up to the irradiance but for H0", DType::f32, p.brought);
    return all;
}

// Runs one(), whose refusals then name the scene.
template <class One>
auto of_scene(const Context& c, One one) {
    try {
        return one();
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", c.scene.name, error.what()));
    }
}

std::string rows_text(const RadiosityBuffers& b, const radiosity::RadiosityParams& p) {
    if (b.factors.count == 0) return "there are no elements";
    const int blocks = b.factors.block_count();
    const double bytes = double(b.factors.all_bytes());
    const double fronts = share_of_fronts(b.factors);
    const std::string note = fronts < few_fronts ? fmt::format("; elements see next to nothing of each other ({:.2g} %): do normals look outwards?", 100 * fronts) : "";
    return fmt::format("{}{:.1f} MB{}, {:.2f} bytes a texel{}{}", b.rows_found == 0 ? "" : b.rows_found == blocks ? "kept: they lie in the store; " : "",
                       bytes * 1e-6, b.factors.further ? fmt::format(", {:.1f} of them read from disk for each product", bytes * 1e-6 - double(b.factors.bytes()) * 1e-6) : "",
                       bytes / (3.0 * p.size * p.size * b.factors.count),
                       b.rows_found > 0 && b.rows_found < blocks ? fmt::format("; {} of {} files were in the store", b.rows_found, blocks) : "", note);
}

void add_rows(Context& c, Nodes& nodes) {
    RadiosityBuffers& b = buffers(c);
    PlannedNode node = begin(c, radiosity::info_rows(), "what elements see of each other", {1, 1});
    // A vertex for two triangles, as in any large mesh.
    const double elements = c.settings.radiosity.kind == radiosity::Kind::triangles ? c.triangles : c.triangles / 2;
    const int size = c.settings.radiosity.size;
    node.plan.work = elements * 3 * size * size, node.plan.work_unit = "texels";
    node.plan.expected_ms = 1e3 * radiosity::row_seconds(int(elements), std::size_t(c.triangles), size);
    // What elements reflect and emit is not in it.
    node.reads = [&c, &b](graph::Reads& r) {
        r.edge(radiosity::info_elements().name);
        if (r.hashes()) r.value(radiosity::rows_key(b.elements, radiosity::row_params(c.settings.radiosity)), c.settings.radiosity.memory_mb);
    };
    node.outputs = [&b] {
        Bundle all;
        lend(all, "escaped", {std::int64_t(b.factors.escaped.size()), 1}, b.factors.escaped.data());
        lend(all, "sums", {std::int64_t(b.factors.sums.size()), 1}, b.factors.sums.data());
        for (const RowBlock& block : b.factors.blocks) {
            const std::string at = fmt::format("{}", block.first);
            lend(all, "rows " + at, {block.count, 4}, &block.rows[0].x);
            lend(all, "scale " + at, {block.count, 1}, block.scale.data());
            if (!block.runs.empty()) lend(all, "runs " + at, {std::int64_t(block.runs.size()), 2}, &block.runs[0].x);
            lend(all, "weights " + at, {std::int64_t(block.weights.size()), 1}, block.weights.data());
        }
        return all;
    };
    node.run = [&c, &b](const RunOptions& options, graph::NodeRun& run) {
        const radiosity::RadiosityParams& p = c.settings.radiosity;
        radiosity::RowsMade made = of_scene(c, [&] {
            return radiosity::rows_within(b.elements, radiosity::row_params(p), {options, std::uint64_t(p.memory_mb) * 1'000'000, c.rows});
        });
        b.factors = std::move(made.factors), b.rows_found = made.found;
        run.bytes = b.factors.bytes();
        run.kept = made.found > 0 && made.found == b.factors.block_count();
        run.reason = rows_text(b, p);
    };
    node.of_pixels = false, node.by_name = true;
    node.size = [&b] { return glm::ivec2(b.elements.count(), 1); };
    node.explain = [&c, &b](glm::ivec2 at) { return explained_row(c, b, at.x).values; };
    node.pictures = [&c, &b](glm::ivec2 at) { return pictures_of(explained_row(c, b, at.x).pictures); };
    node.fill = [] {};
    node.leave_out = [&b] { b.factors = {}, b.rows_found = 0; };
    nodes.push_back(std::move(node));
}

void add_light(Context& c, Nodes& nodes) {
    RadiosityBuffers& b = buffers(c);
    PlannedNode node = begin(c, radiosity::info_light(), "what lamps, small emitters and the sky send to elements", {1, 1});
    node.reads = [&c, &b](graph::Reads& r) {
        read_lists(r, {&b.elements.eye, &b.elements.normal, &b.elements.lamp_exitance});
        r.source("lamps", c.keys.paths);
        r.value(c.scene.environment.radiance);
        if (!c.scene.environment.map.empty()) r.value(c.settings.radiosity.size, c.settings.radiosity.weights);
        r.list(b.factors.escaped);
    };
    node.outputs = [&b] {
        Bundle all;
        lend_list(all, "lamps", b.lamps), lend_list(all, "sky", b.sky), lend_list(all, "emitters", b.emitters);
        return all;
    };
    node.run = [&c, &b](const RunOptions& options, graph::NodeRun& run) {
        b.lamps = radiosity::lamps_on(c.scene, b.elements, options);
        b.sky = radiosity::own_light(c.scene, b.elements, b.factors, c.settings.radiosity, options, &b.emitters);
        run.bytes = 48 * b.lamps.size();
    };
    node.leave_out = [&b] { b.lamps.clear(), b.sky.clear(), b.emitters.clear(); };
    nodes.push_back(std::move(node));
}

void add_solve(Context& c, Nodes& nodes) {
    RadiosityBuffers& b = buffers(c);
    PlannedNode node = begin(c, radiosity::info_solve(), "light is reflected again and again", {1, 1});
    node.reads = [&c, &b](graph::Reads& r) {
        read_lists(r, {&b.elements.reflectance, &b.elements.exitance, &b.lamps, &b.sky});
        r.list(b.factors.sums);
        const radiosity::RadiosityParams& p = c.settings.radiosity;
        r.value(p.solver, p.tolerance, p.passes, p.memory_mb);
    };
    node.outputs = [&b] {
        Bundle all;
        lend_list(all, "radiosity", b.radiosity);
        return all;
    };
    node.run = [&c, &b](const RunOptions& options, graph::NodeRun& run) {
        b.solved = of_scene(c, [&] {
            return radiosity::solve(b.factors, b.elements, b.lamps, b.sky, c.settings.radiosity, options, b.radiosity);
        });
        run.bytes = 16 * b.radiosity.size();
        run.reason = text_of(b.solved);
    };
    node.leave_out = [&b] { b.radiosity.clear(), b.solved = {}; };
    nodes.push_back(std::move(node));
}

// Of the blocks a few, spread over all: what a device is given to compare.
std::vector<StageData> some_blocks(const RadiosityBuffers& b) {
    std::vector<StageData> data;
    const std::size_t n = b.factors.blocks.size(), some = std::min<std::size_t>(n, 4);
    for (std::size_t k = 0; k < some; ++k) {
        radiosity::GatherInputs in{&b.factors.blocks[k * n / some], &b.sky, &b.radiosity};
        in.decoded = true;
        data.push_back(data_of(in));
    }
    return data;
}

void add_gather(Context& c, Nodes& nodes) {
    RadiosityBuffers& b = buffers(c);
    const StageBinding& binding = stage<radiosity::GatherKernel>();
    PlannedNode node = begin_node(c, binding, "radiosity", "what elements get from each other", 1);
    node.of_pixels = false;
    node.size = [&b] { return glm::ivec2(int(b.irradiance.size()), 1); };
    node.dispatches = [&b] { return some_blocks(b); };
    node.reads = [&b](graph::Reads& r) {
        read_lists(r, {&b.sky, &b.radiosity});
        r.list(b.factors.sums);
    };
    node.outputs = [&b, &binding] {
        Bundle all;
        lend_list(all, binding.outputs[0].name.c_str(), b.irradiance);
        return all;
    };
    node.run = [&b](const RunOptions& options, graph::NodeRun& run) {
        radiosity::gather(b.factors, b.sky, b.radiosity, options, b.irradiance);
        run.bytes = 16 * b.irradiance.size();
    };
    node.explain = [&b, &binding](glm::ivec2 at) {
        std::vector<TapValue> values;
        b.factors.with_block(at.x / radiosity::rows_of_block, [&](const RowBlock& block) {
            radiosity::GatherInputs in{&block, &b.sky, &b.radiosity};
            in.decoded = true;
            const StageData data = data_of(in);
            const int own = at.x - block.first;
            values = plumb::explain(binding, data, {own % data.size.x, own / data.size.x});
        });
        return values;
    };
    node.leave_out = [&b] { b.irradiance.clear(); };
    node.fill = [] {};
    node.results = {{binding.outputs[0].name, binding.outputs[0].name, "irradiance"}};
    nodes.push_back(std::move(node));
}

void add_lookup(Context& c, Nodes& nodes) {
    RadiosityBuffers& b = buffers(c);
    const StageBinding& binding = stage<radiosity::LookupKernel>();
    PlannedNode node = begin_node(c, binding, "radiosity", "indirect light", double(c.size.x) * c.size.y);
    const auto data = [&c, &b] {
        return data_of(radiosity::LookupInputs{&c.frame.gbuffer.position, &c.frame.gbuffer.id, &b.triangles, &b.irradiance});
    };
    node.size = [size = c.size] { return size; };
    node.dispatches = [=] { return std::vector<StageData>{data()}; };
    node.reads = [=, &binding](graph::Reads& r) { r.dispatch(binding, data()); };
    node.outputs = [&c, &binding] { return lent(binding.outputs[0].name, c.frame.indirect); };
    node.run = [=, &c, &binding](const RunOptions& options, graph::NodeRun& run) {
        plumb::run(binding, data(), options, c.frame.indirect);
        run.bytes = bytes_of(c.frame.indirect);
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, data(), at); };
    node.leave_out = [&c, size = c.size] { c.frame.indirect = Image4(size.x, size.y); };
    node.results = {{binding.outputs[0].name, binding.outputs[0].name, "irradiance"}};
    nodes.push_back(std::move(node));
}

}  // namespace

void add_radiosity(Context& c, Nodes& nodes) {
    if (!solves_radiosity(c.settings)) return;
    add_elements(c, nodes);
    add_rows(c, nodes);
    add_light(c, nodes);
    add_solve(c, nodes);
    add_gather(c, nodes);
    add_lookup(c, nodes);
}

}  // namespace plumb::frame
