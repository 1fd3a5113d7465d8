// plumb render: a scene goes in; pictures, times and memory come out.
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/outputs.h"
#include "tools/plumb/pictures.h"
#include "tools/plumb/progress.h"
#include "tools/plumb/reference_files.h"
#include "tools/plumb/reports.h"
#include "tools/plumb/scene_command.h"
#include "tools/plumb/truth.h"

namespace plumb::cli {

namespace {

struct RenderOptions {
    SceneOptions scene;
    Common common;
    std::string folder = "out";
    bool dump = false;
};

std::size_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return std::size_t(usage.ru_maxrss) * 1024;
}

int render(const RenderOptions& given) {
    const RunOptions options = given.common.run_options();
    const Scene scene = load(given.scene);
    const frame::Settings settings = settings_of(scene, given.scene);
    const frame::Plan plan = frame::plan(scene, settings);
    Outputs outputs(given.folder);
    if (!given.common.json) print_notes(scene);

    // Render.
    const auto start = std::chrono::steady_clock::now();
    const std::string cache = given.scene.no_cache ? "" : cache_folder();
    ReferenceFiles kept(cache);
    const frame::Frame frame = [&] {
        ProgressBar bar(plan);
        return frame::execute(scene, settings, plan, options, bar.callback(), cache.empty() ? nullptr : &kept);
    }();
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();

    // Write.
    const std::vector<TruthRow> rows = compare_layers(frame, given.common.threads);
    const Json truth = frame.traced.empty() ? Json(nullptr) : truth_json(frame, rows, kept.notes());
    const RunReport report{scene, settings, options, frame.stages, ms, peak_bytes(), truth};
    const std::string json = json_text(run_json(report));
    write_pictures(scene, plan, frame, outputs);
    if (given.dump) write_dump(scene, settings, plan, frame, options, outputs);
    outputs.write("run.json", [&](const std::string& path) { io::write_text(path, json); });
    outputs.commit();

    // Tell.
    for (const std::string& warning : truth_warnings(frame)) std::fprintf(stderr, "plumb: %s\n", warning.c_str());
    if (given.common.json) {
        std::fputs(json.c_str(), stdout);
        return success;
    }
    std::string text = run_text(report) + "\n";
    if (!frame.traced.empty()) text += truth_text(frame, rows, kept.notes()) + "\n";
    std::size_t dumped = 0;
    for (const std::string& file : outputs.files()) {
        if (file.find("/dump/") == std::string::npos && file.rfind("dump/", 0) != 0)
            text += "wrote " + file + "\n";
        else
            ++dumped;
    }
    if (dumped > 0) text += fmt::format("wrote {} files that stages read and write: {}/dump\n", dumped, given.folder);
    std::fputs(text.c_str(), stdout);
    return success;
}

}  // namespace

void add_render(CLI::App& program, Action& action) {
    auto given = std::make_shared<RenderOptions>();
    CLI::App* command = program.add_subcommand("render", "render a scene: EXR with a layer a buffer, PNG, run.json");
    add_scene_options(*command, given->scene);
    command->add_option("-o,--output", given->folder, "folder for what is written; \"out\" otherwise")
        ->type_name("DIR");
    command->add_flag("--dump", given->dump, "also write every stage's inputs and outputs, to DIR/dump");
    add_truth_options(*command, given->scene);
    command->add_flag("--no-cache", given->scene.no_cache, "trace even what is kept, and keep nothing");
    add_common(*command, given->common);
    command->footer(
        "Files: <scene>.exr (32-bit float; layers color, direct, indirect, albedo, emission, position, normal,\n"
        "depth: linear, in metres; zbuffer: the depth buffer, z/w; id, shadow.<light>), <scene>.rsm.<light>.exr\n"
        "(rsm.<light>.position, normal, flux, depth: its size is its own; of a point light rsm.<light>.px.position and\n"
        "so on: px, nx, py, ny, pz, nz, but for faces that can see nothing), <scene>.png (tone mapped), run.json (time\n"
        "and memory by stage). On a surface, color = (albedo (direct + indirect) + emission) / pi. Equal pictures are\n"
        "equal files.\n"
        "--truth adds the layers truth (outgoing radiance, all light), truth.direct and for rsm truth.indirect\n"
        "(irradiance, the lamps' light alone, as the method counts it), each with a layer .error, its standard error,\n"
        "<scene>.truth.png, and in run.json how far color, direct and indirect are from them. The method reference\n"
        "writes its color, truth.error and no direct and indirect.\n"
        "What was path traced is kept in $PLUMB_CACHE, else $XDG_CACHE_HOME/plumbline, else ~/.cache/plumbline, at\n"
        "most 4 GiB, those used last; the same scene and settings take it from there. Nothing else is in that folder.");
    command->callback([given, &action] { action = [=] { return render(*given); }; });
}

}  // namespace plumb::cli
