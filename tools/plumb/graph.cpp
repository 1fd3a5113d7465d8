// plumb graph: a frame as it ran: which stage read what another made, what each took, and what was left out.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/content_hash.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/kept.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/graph_page.h"
#include "tools/shared/file_store.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/progress.h"
#include "tools/shared/radiosity_report.h"
#include "tools/shared/reference_files.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct GraphOptions {
    SceneOptions scene;
    Common common;
    std::string html;
};

// A change of what the keys of the JSON mean is another version.
constexpr int version = 1;

Json graph_json(const std::vector<GraphNode>& nodes) {
    Json all = Json::array();
    for (const GraphNode& n : nodes) {
        Json node = {{"name", n.run.label}, {"stage", n.plan.name}};
        if (!n.plan.form.empty()) node["form"] = n.plan.form;
        if (!n.plan.layer.empty()) node["layer"] = n.plan.layer;
        if (!n.view.empty()) node["view"] = n.view;
        node.update(stage_runs_json({n.run}).at(0));
        node["read_until"] = n.read_until;
        all.push_back(node);
    }
    return {{"version", version}, {"nodes", all}};
}

std::string graph_text(const std::vector<GraphNode>& nodes) {
    std::vector<std::vector<std::string>> rows;
    for (const GraphNode& n : nodes)
        rows.push_back({n.run.label, n.run.needed ? milliseconds_text(n.run.ms) : "-",
                        n.run.needed ? megabytes_text(n.run.bytes) : "-", fmt::format("{}", fmt::join(n.run.reads, ", ")),
                        n.read_until, n.run.needed ? "" : n.run.reason});
    return format_table({{"stage"}, {"ms", Align::right}, {"MB", Align::right}, {"reads"}, {"is read until"}, {"left out"}},
                        rows);
}

std::vector<GraphNode> nodes_of(const frame::Plan& plan, const frame::Frame& frame, const frame::FrameGraph& graph) {
    std::vector<GraphNode> nodes;
    for (std::size_t i = 0; i < plan.stages.size(); ++i) {
        const frame::PlannedNode& node = graph.node(plan.stages[i]);
        nodes.push_back({plan.stages[i], frame.stages[i], node.view_name, "", node.outputs()});
    }
    for (const GraphNode& reader : nodes)
        for (const std::string& read : reader.run.reads)
            for (GraphNode& n : nodes)
                if (n.run.label == read) n.read_until = reader.run.label;
    return nodes;
}

int graph(const GraphOptions& given) {
    const RunOptions options = given.common.run_options();
    Scene scene = load(given.scene);
    frame::Settings settings = settings_of(scene, given.scene);
    note_idle(given.scene, settings, scene);
    scene = drawn(std::move(scene), settings, options);
    add_bake(scene, settings, {options, given.scene.no_cache ? "" : cache_folder(), !given.common.json});
    const frame::Plan plan = frame::plan(scene, settings);
    const std::string cache = given.scene.no_cache ? "" : cache_folder();
    ReferenceFiles references(cache);
    const std::unique_ptr<FileStore> rows = row_files(settings, given.scene.no_cache);
    frame::KeptStages kept;
    const frame::Frame& frame = [&]() -> const frame::Frame& {
        ProgressBar bar(plan);
        return frame::execute(scene, settings, plan, options, kept, bar.callback(), {cache.empty() ? nullptr : &references, rows.get()});
    }();
    frame::FrameGraph made(scene, settings, plan, kept.memory());
    made.context().keeps = true;
    const std::vector<GraphNode> nodes = nodes_of(plan, frame, made);
    if (!given.html.empty()) io::write_text(given.html, graph_page("plumb graph, " + scene.name, nodes));
    if (given.common.json) {
        std::fputs(json_text(graph_json(nodes)).c_str(), stdout);
        return success;
    }
    print_notes(scene);
    std::fputs(graph_text(nodes).c_str(), stdout);
    if (!given.html.empty()) fmt::print("\nwrote {}\n", io::shown(given.html));
    return success;
}

}  // namespace

void add_graph(CLI::App& program, Action& action) {
    auto given = std::make_shared<GraphOptions>();
    CLI::App* command =
        program.add_subcommand("graph", "render, and say which stage reads what, what each took and what was left out");
    add_scene_options(*command, given->scene);
    add_size_option(*command, given->scene);
    command->add_option("--html", given->html, "a page that draws it; a click on a stage shows what it made")->type_name("FILE");
    add_truth_options(*command, given->scene);
    command->add_flag("--no-cache", given->scene.no_cache, "trace even what is kept, and keep nothing");
    add_common(*command, given->common);
    command->footer(
        "A stage reads another where it binds memory that the other wrote: nobody states the edges. With --json every stage\n"
        "has its key too: a hash of all that it reads. Equal keys are equal bits, and --frames of `plumb render` runs again\n"
        "what has another key.");
    command->callback([given, &action] { action = [=] { return graph(*given); }; });
}

}  // namespace plumb::cli
