// plumb experiment ipr: the command.
#include "tools/experiments/ipr.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "core/error.h"
#include "io/camera_list.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/outputs.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

struct IprOptions {
    std::vector<std::string> scenes;
    SceneOptions scene;
    Common common;
    IprRequest request;
    std::vector<std::string> only;
    std::string folder, html, cameras;
    int samples = 0, receivers = 0;  // 0: as --quick says
};

std::string command_line(const IprOptions& given) {
    std::string text = fmt::format("plumb experiment ipr {} --samples {} --receivers {} --updates {}", fmt::join(given.scenes, " "), given.request.samples,
                                   given.request.receivers, given.request.updates);
    if (given.request.quick) text += " --quick";
    if (!given.only.empty()) text += fmt::format(" --only {}", fmt::join(given.only, ","));
    if (given.request.open < 1) text += fmt::format(" --open {:g}", given.request.open);
    if (!given.cameras.empty()) text += " --cameras " + given.cameras;
    if (!given.scene.preset.empty()) text += " --preset " + given.scene.preset;
    for (const std::string& set : given.scene.sets) text += " --set " + set;
    return text;
}

void check(IprOptions& given) {
    for (const std::string& part : given.only) {
        if (std::find(ipr_parts.begin(), ipr_parts.end(), part) == ipr_parts.end())
            throw InputError(fmt::format("--only {}: expected {}", io::printable(part), fmt::join(ipr_parts, ", ")));
        given.request.parts.insert(part);
    }
    IprRequest& r = given.request;
    if (r.quick) r.samples = 1024, r.receivers = 128, r.updates = 1, r.size = {96, 64};
    if (given.samples > 0) r.samples = given.samples;
    if (given.receivers > 0) r.receivers = given.receivers;
    if (!given.scene.size.empty()) r.size = parse_size("--size", given.scene.size, 16);
}

// Before hours of work.
void check_place(const std::string& file) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (file.empty()) return;
    if (fs::is_directory(file, error)) throw InputError(io::shown(file), "", "is a folder");
    const std::string folder = io::folder_of(file);
    if (!folder.empty() && !fs::is_directory(folder, error)) throw InputError(io::shown(file), "", "cannot be written: there is no folder of that name");
}

// Of the list, those of that scene's file.
std::vector<LodView> cameras_of(const io::CameraList& list, const std::string& file, const Scene& scene) {
    std::vector<LodView> views;
    for (const io::ListedCamera& c : list.cameras)
        if (io::stem_of(c.scene) == io::stem_of(file)) views.push_back({c.name, io::scene_of(list, c, scene).camera, {}});
    return views;
}

int run_ipr(IprOptions given) {
    check(given);
    io::CameraList cameras;
    if (!given.cameras.empty()) cameras = io::read_camera_list(given.cameras);
    const RunOptions options = given.common.run_options();
    // All scenes are read before any is measured: what is wrong with the last one is said at once.
    std::vector<Scene> scenes;
    std::vector<frame::Settings> settings;
    SceneOptions of_scene = given.scene;
    of_scene.size.clear();
    for (const std::string& file : given.scenes) {
        of_scene.file = file;
        scenes.push_back(load(of_scene));
        settings.push_back(settings_of(scenes.back(), of_scene));
        probes::validate(settings.back().probes);
    }
    check_place(given.html);
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    std::vector<IprResult> results;
    std::size_t listed = 0;
    std::vector<IprRequest> requests(scenes.size(), given.request);
    for (std::size_t i = 0; i < scenes.size(); ++i) listed += (requests[i].cameras = cameras_of(cameras, given.scenes[i], scenes[i])).size();
    if (!given.cameras.empty() && listed == 0) throw InputError(io::shown(given.cameras), "", "has no camera of these scenes");
    // Of one core, a scene: a minute on two with --quick, else two hours.
    const double parts = given.request.parts.empty() ? 1 : double(given.request.parts.size()) / double(ipr_parts.size());
    announce(fmt::format("experiment ipr: {} scene{}", scenes.size(), scenes.size() == 1 ? "" : "s"),
             double(scenes.size()) * parts * (given.request.quick ? 120 : 14400), options);
    for (std::size_t i = 0; i < scenes.size(); ++i)
        results.push_back(measure_ipr(scenes[i], settings[i], requests[i], options,
                                      [&](const std::string& line) { std::fprintf(stderr, "%s: %s\n", io::stem_of(scenes[i].name).c_str(), line.c_str()); }));
    const std::string json = json_text(ipr_json(results));
    std::string text = ipr_text(results);
    const std::string html = outputs || !given.html.empty() ? ipr_html(results, command_line(given)) : "";
    if (!given.html.empty()) io::write_text(given.html, html);
    if (outputs) {
        outputs->write("ipr.json", [&](const std::string& path) { io::write_text(path, json); });
        outputs->write("ipr.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("ipr.csv", [&](const std::string& path) { io::write_text(path, ipr_csv(results)); });
        outputs->write("ipr_parts.csv", [&](const std::string& path) { io::write_text(path, ipr_parts_csv(results)); });
        outputs->write("ipr.html", [&](const std::string& path) { io::write_text(path, html); });
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_ipr(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<IprOptions>();
    CLI::App* command = experiment.add_subcommand("ipr", "chapter 5 of IPR again: irradiance probes at run time, and their error against path tracing");
    command->add_option("scenes", given->scenes, "the scenes: hall, cornell, rooms")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for ipr.html, ipr.txt, ipr.csv, ipr_parts.csv and ipr.json")->check(some_word())->type_name("DIR");
    command->add_option("--html", given->html, "the page alone")->check(some_word())->type_name("FILE");
    command->add_option("--only", given->only, fmt::format("some of {}; all otherwise", fmt::join(ipr_parts, ", ")))->delimiter(',')->type_name("P,P");
    command->add_flag("--quick", given->request.quick, "few receivers, probes, paths and pixels: to see that all of it works");
    command->add_option("--samples", given->samples, "paths a receiver of the truth, of a pixel a 64th; 16384 otherwise, quick 1024")
        ->check(CLI::Range(32, 1 << 20).description(""))
        ->type_name("N");
    command->add_option("--receivers", given->receivers, "held against the truth; 512 otherwise, quick 128")
        ->check(CLI::Range(16, 1 << 16).description(""))
        ->type_name("N");
    command->add_option("--updates", given->request.updates, "whose median is the time of one; 5 otherwise")
        ->check(CLI::Range(1, 1000).description(""))
        ->type_name("N");
    command->add_option("--open", given->request.open, "leave out receivers more open to the sky than this share, such as outer walls; 1 otherwise: none")
        ->check(number_within(0, 1))
        ->type_name("X");
    command->add_option("--cameras", given->cameras, "views of level of detail, the thesis' cameras 1 to 3: a list, data/cameras/ipr_hall.toml")
        ->check(some_word())
        ->type_name("FILE");
    add_size_option(*command, given->scene);
    add_preset_option(*command, given->scene.preset);
    command->add_option("--set", given->scene.sets, "table.key=value in place of the scene file's; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer(
        "tables: 5.1 and 5.2, figures 5.2 to 5.4, 5.6, 5.7. graphs: 5.5, 5.8. figures: 3.32, 5.9, 5.11 to 5.13, 5.15. goals: the default bake, and\n"
        "which resource limits it. quads: small emissive squares. lightmap: errors receiver by receiver, and leaks. spatial: table 5.3, figures\n"
        "5.16 to 5.19. objects: figures 5.20 to 5.23; both where something moves. lod: tables 5.4 to 5.11, figures 5.24 to 5.33. All but the\n"
        "milliseconds has the same bits every time (probes.rays = exact, the default); those mean something on an idle machine only. Whole, a\n"
        "scene takes hours on two cores: --only, --quick.");
    command->callback([given, &action] { action = [=] { return run_ipr(*given); }; });
}

}  // namespace plumb::cli
