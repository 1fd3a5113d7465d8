// plumb plan: what a render would do.
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "gi/frame/refusals.h"
#include "tools/plumb/cli.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/radiosity_report.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

int plan(const SceneOptions& given, const Common& common) {
    const RunOptions options = common.run_options();
    Scene scene = load(given);
    frame::Settings settings = settings_of(scene, given);
    note_idle(given, settings, scene);
    note_lobes(settings, scene);
    const auto start = std::chrono::steady_clock::now();
    scene = drawn(std::move(scene), settings, options);
    const double mesh_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!settings.probe_run.file.empty()) add_bake(scene, settings, {options, "", false});  // reads it
    const frame::Plan plan = frame::plan(scene, settings);
    std::optional<RadiosityPlan> radiosity;
    if (settings.method == frame::Method::radiosity) radiosity = plan_radiosity(scene, settings, options), radiosity->mesh_seconds = mesh_seconds;
    const std::vector<std::string> warnings = frame::warnings(scene, settings);
    if (common.json) {
        Json json = plan_json(scene, settings, plan);
        json["warnings"] = warnings;
        if (radiosity) json["radiosity"] = radiosity_plan_json(*radiosity);
        std::fputs(json_text(json).c_str(), stdout);
    } else {
        print_notes(scene);
        for (const std::string& warning : warnings) std::printf("warning: %s\n", warning.c_str());
        if (!warnings.empty()) std::printf("\n");
        std::fputs(plan_text(plan).c_str(), stdout);
        if (radiosity) std::fputs(radiosity_plan_text(*radiosity).c_str(), stdout);
    }
    return success;
}

}  // namespace

void add_plan(CLI::App& program, Action& action) {
    auto common = std::make_shared<Common>();
    auto given = std::make_shared<SceneOptions>();
    CLI::App* command =
        program.add_subcommand("plan", "say which stages a scene needs, which not and why; renders nothing");
    add_scene_options(*command, *given);
    add_size_option(*command, *given);
    add_truth_options(*command, *given);
    add_common(*command, *common);
    command->callback([common, given, &action] { action = [=] { return plan(*given, *common); }; });
}

}  // namespace plumb::cli
