// plumb experiment screen: the command, and what it writes.
#include "tools/experiments/screen.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/parallel.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/page/markup.h"
#include "tools/shared/announce.h"
#include "tools/shared/machine_load.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

struct ScreenOptions {
    Common common;
    ScreenRequest request;
    std::vector<std::string> scenes;
    std::string folder;
};

struct OfScene {
    std::string name;
    std::vector<IprSheet> sheets;
};

std::string command_line(const ScreenOptions& given) {
    const ScreenRequest& r = given.request;
    std::string text = fmt::format("plumb experiment screen {} --size {} --spp {} --repeats {} --frames {}",
                                   fmt::join(given.scenes, " "), r.size, r.paths, r.repeats, r.frames);
    if (!r.preset.empty()) text += " --preset " + r.preset;
    for (const std::string& set : r.sets) text += " --set " + set;
    return text;
}

std::string html_of(const std::vector<OfScene>& all, const ScreenOptions& given, const std::string& where) {
    page::Page page("Screen space: error against time");
    page.paragraph("A curve is a choice of settings, along the one that buys accuracy. Times are those of its own stages, medians; what a mouse over a point shows are its settings.");
    for (const OfScene& scene : all) {
        page.heading(scene.name);
        for (const IprSheet& sheet : scene.sheets) show_sheet(page, scene.name, sheet);
    }
    page.heading("How it was measured");
    page.paragraph(where + ". A row's stages run again with all else kept.");
    page.raw("<p><code>" + page::escaped(command_line(given)) + "</code></p>\n");
    return page.html();
}

int run_screen(const ScreenOptions& given) {
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    // Of one core: 900 s a scene at 480 x 270 with 64 paths, half of which is lights' maps and what does not grow with the picture.
    const glm::ivec2 size = parse_size("--size", given.request.size);
    const double paths = double(size.x) * size.y * given.request.paths / (480.0 * 270 * 64);
    announce(fmt::format("experiment screen: {} scene{}", given.scenes.size(), given.scenes.size() == 1 ? "" : "s"),
             double(given.scenes.size()) * 450 * (1 + paths), given.common.run_options());
    const double load = machine_load();
    std::vector<OfScene> all;
    for (const std::string& file : given.scenes) {
        const std::string name = std::filesystem::path(file).stem();
        all.push_back({name, measure_screen(file, given.request, given.common.run_options(), [&](const std::string& line) { std::fprintf(stderr, "%s: %s\n", name.c_str(), line.c_str()); })});
    }
    const int threads = thread_count(given.common.threads);
    const std::string isa = isa_name(last_dispatched_isa()), where = fmt::format("{}, {} threads, {}; load of the machine before: {:.1f}", processor_name(), threads, isa, load);
    Json json = {{"version", 1}, {"processor", processor_name()}, {"isa", isa}, {"threads", threads}, {"load_before", load}, {"size", given.request.size}, {"scenes", Json::array()}};
    std::string text = where + "\n", csv = "scene,table,setting,of,quantity,value\n";
    for (const OfScene& scene : all) {
        Json sheets = Json::array();
        text += "\n" + scene.name + "\n";
        for (const IprSheet& sheet : scene.sheets) sheets.push_back(sheet_json(sheet)), text += sheet_text(sheet), csv += sheet_csv(scene.name, sheet);
        json["scenes"].push_back({{"name", scene.name}, {"sheets", sheets}});
    }
    if (outputs) {
        outputs->write("screen.json", [&](const std::string& path) { io::write_text(path, json_text(json)); });
        outputs->write("screen.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("screen.csv", [&](const std::string& path) { io::write_text(path, csv); });
        outputs->write("screen.html", [&](const std::string& path) { io::write_text(path, html_of(all, given, where)); });
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json_text(json) : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_screen(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<ScreenOptions>();
    CLI::App* command = experiment.add_subcommand("screen", "ambient occlusion, reflections and shared frames: what each setting costs and errs by");
    command->add_option("scenes", given->scenes, "scenes: .toml, or bare .obj, .gltf or .glb")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for screen.html, screen.txt, screen.csv and screen.json")->check(some_word())->type_name("DIR");
    command->add_option("--size", given->request.size, "pixels; 480x270 otherwise")->type_name("WxH");
    add_preset_option(*command, given->request.preset);
    command->add_option("--set", given->request.sets, "table.key=value in place of the scene files'; may be repeated")->type_name("T.K=V");
    command->add_option("--spp", given->request.paths, "rays and paths a pixel of the truths; 64 otherwise")->check(CLI::Range(1, 65536).description(""))->type_name("N");
    command->add_option("--repeats", given->request.repeats, "whose median is a time; 5 otherwise")->check(CLI::Range(1, 1000).description(""))->type_name("N");
    command->add_option("--frames", given->request.frames, "that share gathered light before they are compared; 32 otherwise")->check(CLI::Range(2, 4096).description(""))->type_name("N");
    add_common(*command, given->common);
    command->footer(
        "Ambient occlusion against rays of the same radius; reflections, where a material mirrors, against rays that meet the scene, each\n"
        "pixel's classified, and against mirrored paths; light that frames share against many samples of the same disc.");
    command->callback([given, &action] { action = [=] { return run_screen(*given); }; });
}

}  // namespace plumb::cli
