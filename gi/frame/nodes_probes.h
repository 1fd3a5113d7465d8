// What the files that add nodes of the method probes share. Private to gi/frame.
//
//     nodes_probe_hits.cpp   the bake, and what relight rays meet       nodes_volume.cpp   spatial receivers
//     nodes_probes.cpp       bounces, the lightmap, its lookups         nodes_relief.cpp   normal maps, highlights, what moves
#pragma once

#include "gi/frame/frame_graph.h"
#include "gi/probes/bake.h"
#include "gi/probes/lookup.h"
#include "gi/probes/run_loop.h"
#include "gi/probes/run_stages.h"

namespace plumb::frame {

// Throws InputError where there is none.
const probes::Bake& bake_of(const Context& c);
bool pipelined(const Context& c);
// Whether spatial receivers light something, or tell where its light comes from.
bool has_volume(const Context& c);
// Where each stage of an update reads and writes: in a pipeline it reads what the frame before has left.
probes::UpdateBuffers buffers_of(Context& c);

// A step of the host's: it draws no pixels and is asked for by no name.
PlannedNode begin_host(Context& c, const StageInfo& info, const std::string& why, glm::ivec2 size);

// Which spatial receivers something reads, before levels of detail are chosen.
void add_active(Context& c, Nodes& nodes);
// Their update; what pixels read of them is in nodes_relief.cpp.
void add_volume(Context& c, Nodes& nodes);

// The node of a stage of the lightmap's update. size(bake): of its domain. inputs(): its typed inputs.
template <class SizeOf, class InputsOf, class To>
void add_stage(Context& c, Nodes& nodes, const std::string& why, const std::string& tap, double turns, SizeOf size, InputsOf inputs, To result) {
    using Kernel = typename decltype(inputs())::Kernel;
    const StageBinding& binding = stage<Kernel>();
    PlannedNode node = begin_node(c, binding, "probes", why, turns);
    node.of_pixels = false;
    node.size = [=, &c] { return c.settings.bake ? size(*c.settings.bake) : glm::ivec2(0); };
    node.dispatches = [=] { return std::vector<StageData>{data_of(inputs())}; };
    node.reads = [=, &binding](graph::Reads& r) { r.dispatch(binding, data_of(inputs())); };
    node.outputs = [=, &binding] { return lent(binding.outputs[0].name, result()); };
    node.run = [=, &binding](const RunOptions& options, graph::NodeRun& run) {
        plumb::run(binding, data_of(inputs()), options, result());
        run.bytes = bytes_of(result());
    };
    node.explain = [=, &binding](glm::ivec2 at) { return plumb::explain(binding, data_of(inputs()), at); };
    node.leave_out = [=] { result() = {}; };
    node.fill = [] {};
    node.results = {{binding.outputs[0].name, binding.outputs[0].name, tap}};
    nodes.push_back(std::move(node));
}

// Of what pixels of the frame read.
template <class InputsOf, class To>
void add_of_pixels(Context& c, Nodes& nodes, const std::string& why, const std::string& tap, InputsOf inputs, To result) {
    add_stage(c, nodes, why, tap, double(c.size.x) * c.size.y, [size = c.size](const probes::Bake&) { return size; }, inputs, result);
    PlannedNode& node = nodes.back();
    node.of_pixels = true;
    node.leave_out = [=, size = c.size] { result() = Image4(size.x, size.y); };
    node.fill = {};
}

}  // namespace plumb::frame
