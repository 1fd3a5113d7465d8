// plumb sweep: error against run time, over methods and settings.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/sweep_choose.h"
#include "tools/plumb/sweep_page.h"
#include "tools/shared/outputs.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

struct SweepOptions {
    SweepRequest request;
    Common common;
    std::vector<std::string> scenes, sets;
    std::string folder, preset, size, budget, error, longest, compare_to;
};

// "direct, rsm.disc, rsm.all, rsm.all_rays, reference": without those that one more parameter sets apart.
std::string curve_names() {
    std::string names;
    for (const SweptMethod& curve : swept_methods(frame::Settings(), {}, {}))
        if (curve.name.find(',') == std::string::npos) names += (names.empty() ? "" : ", ") + curve.name;
    return names;
}

// Of each scene the point that --budget or --error picks.
struct Picked {
    std::string scene;
    const SweepPoint* point = nullptr;
};

Json picked_json(const std::vector<Picked>& picked) {
    Json json = Json::array();
    for (const Picked& p : picked)
        json.push_back({{"scene", p.scene}, {"point", p.point ? point_json(*p.point) : Json(nullptr)}});
    return json;
}

std::string picked_text(const std::vector<Picked>& picked, const std::string& what) {
    std::string text;
    for (const Picked& p : picked)
        text += fmt::format("{}: {}: {}\n", p.scene, what, p.point ? point_text(*p.point) : "no point of this sweep");
    return text;
}

Json comparison_json(const SweepComparison& c) {
    auto sentences = [](const std::vector<Regression>& list) {
        Json json = Json::array();
        for (const Regression& r : list) json.push_back(r.what);
        return json;
    };
    return {{"compared", c.compared}, {"worse", sentences(c.worse)}, {"better", sentences(c.better)}, {"notes", c.notes}};
}

std::string comparison_text(const SweepComparison& c, const std::string& file) {
    std::string text;
    for (const Regression& r : c.worse) text += "WORSE: " + r.what + "\n";
    for (const Regression& r : c.better) text += "better: " + r.what + "\n";
    for (const std::string& note : c.notes) text += "note: " + note + "\n";
    return text + fmt::format("{} points against {}: {} worse, {} better\n", c.compared, file, c.worse.size(),
                              c.better.size());
}

SweepRequest request_of(const SweepOptions& given) {
    SweepRequest request = given.request;
    for (const std::string& file : given.scenes) {
        SceneOptions scene;
        scene.file = file, scene.preset = given.preset, scene.sets = given.sets;
        request.scenes.push_back(scene);
    }
    if (!given.size.empty()) request.size = parse_size("--size", given.size);
    if (!given.longest.empty()) request.longest_ms = parse_milliseconds("--longest", given.longest);
    return request;
}

// What to type to measure it again.
std::string command_line(const SweepOptions& given) {
    std::string text = "plumb sweep";
    for (const std::string& scene : given.scenes) text += " " + scene;
    auto add = [&](const char* option, const std::string& value) {
        if (!value.empty()) text += fmt::format(" {} {}", option, value);
    };
    add("-o", given.folder);
    for (const std::string& m : given.request.methods) add("--method", m);
    for (const std::string& v : given.request.vary) add("--vary", v);
    add("--preset", given.preset);
    for (const std::string& s : given.sets) add("--set", s);
    if (given.request.runs != 5) add("--runs", std::to_string(given.request.runs));
    add("--size", given.size), add("--spp", given.request.samples), add("--until-error", given.request.until_error);
    add("--longest", given.longest), add("--budget", given.budget), add("--error", given.error);
    add("--compare-to", given.compare_to);
    if (given.common.threads > 0) add("--threads", std::to_string(given.common.threads));
    if (given.common.isa != "auto") add("--isa", given.common.isa);
    return text;
}

int sweep(const SweepOptions& given) {
    SweepRequest request = request_of(given);
    if (!given.budget.empty() && !given.error.empty())
        throw InputError("--error: --budget is given, too: expected one of them");
    const double budget = given.budget.empty() ? 0 : parse_milliseconds("--budget", given.budget);
    const double error = given.error.empty() ? 0 : parse_error("--error", given.error);
    const std::optional<Sweep> old = given.compare_to.empty() ? std::nullopt : std::optional(read_sweep(given.compare_to));
    Outputs outputs(given.folder);

    SweepPictures pictures;
    const Sweep result = run_sweep(request, given.common.run_options(), &pictures);

    Json json = sweep_json(result);
    std::string text = sweep_text(result);
    std::vector<Picked> picked;
    if (!given.budget.empty() || !given.error.empty()) {
        for (const SweptScene& s : result.scenes)
            picked.push_back({s.name, given.error.empty() ? best_within(result, s.name, budget)
                                                          : fastest_with(result, s.name, error)});
        json["picked"] = picked_json(picked);
        text += picked_text(picked, given.error.empty() ? fmt::format("within {} ms", budget)
                                                        : fmt::format("RMSE of at most {}", error));
    }
    SweepComparison comparison;
    if (old) {
        comparison = compare_sweeps(*old, result);
        if (comparison.compared == 0 && comparison.worse.empty())
            throw InputError(given.compare_to + ": no point of this sweep stands there: nothing can be compared");
        json["comparison"] = comparison_json(comparison);
        text += comparison_text(comparison, given.compare_to);
    }

    const std::string json_file = json_text(json), csv = sweep_csv(result);
    const std::string html = sweep_html(result, &pictures, command_line(given));
    outputs.write("sweep.json", [&](const std::string& path) { io::write_text(path, json_file); });
    outputs.write("sweep.csv", [&](const std::string& path) { io::write_text(path, csv); });
    outputs.write("sweep.html", [&](const std::string& path) { io::write_text(path, html); });
    outputs.commit();
    for (const std::string& file : outputs.files()) text += "wrote " + file + "\n";
    std::fputs((given.common.json ? json_file : text).c_str(), stdout);
    return comparison.worse.empty() ? success : disagreement;
}

}  // namespace

void add_sweep(CLI::App& program, Action& action) {
    auto given = std::make_shared<SweepOptions>();
    CLI::App* command = program.add_subcommand("sweep", "measure error against run time, over methods and settings");
    command->add_option("scenes", given->scenes, "scenes: .toml, or bare .obj, .gltf or .glb")
        ->required()
        ->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for what is written")->required()->type_name("DIR");
    command->add_option("--method", given->request.methods,
                        "a method or a curve: rsm, rsm.disc; may be repeated; all otherwise")
        ->allow_extra_args(false)
        ->check(some_word())
        ->type_name("M");
    command->add_option("--vary", given->request.vary,
                        "table.key=a,b,c: what varies along the curves that it concerns; may be repeated:\n"
                        "the last along, a curve for each value of the others")
        ->allow_extra_args(false)
        ->type_name("T.K=V,V");
    add_preset_option(*command, given->preset);
    command->add_option("--set", given->sets, "table.key=value in place of the scene files'; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    command->add_option("--runs", given->request.runs, "runs of each point, in turns; 5 otherwise")
        ->check(CLI::Range(5, 1000).description(""))
        ->type_name("N");
    command->add_option("--size", given->size, "pixels, in place of the scenes' own")->check(some_word())->type_name("WxH");
    command->add_option("--spp", given->request.samples, "paths a pixel of the truth: reference.samples")
        ->check(some_word())
        ->type_name("N");
    command->add_option("--until-error", given->request.until_error,
                        "in place of --spp: until the standard error is this part of the mean, 0.01 say")
        ->check(some_word())
        ->type_name("E");
    command->add_option("--longest", given->longest, "leave out points that take longer: 500ms, 2s")
        ->check(some_word())
        ->type_name("TIME");
    command->add_option("--budget", given->budget, "say which point has the least error within this time: 100ms")
        ->check(some_word())
        ->type_name("TIME");
    command->add_option("--error", given->error, "say which point is the fastest with at most this RMSE")
        ->check(some_word())
        ->type_name("E");
    command->add_option("--compare-to", given->compare_to, "an earlier sweep.json; exit code 1 where points got worse")
        ->check(some_word())
        ->type_name("FILE");
    command->add_flag("--no-cache", given->request.no_cache, "trace even what is kept, and keep nothing");
    add_common(*command, given->common);
    command->footer(
        "Files: sweep.json, sweep.csv, sweep.html (opens without a network). Times are medians of whole frames; errors\n"
        "are of color, outgoing radiance, against path traced truths: full global illumination, and the method's own\n"
        "transport (for rsm the lamps' direct light and one bounce). Curves: " + curve_names() + ".\n"
        "A point got worse, exit code 1, where its median rose by more than 5 % and by more than the spread of the runs\n"
        "of both, or its error by more than rounding, or where it is left out now (--longest, refused); times of another\n"
        "processor, instruction set or number of threads are not compared. On a busy machine times drift from one sweep\n"
        "to the next, which the runs of one sweep do not show: compare on a quiet machine, with --runs 15 or more, and\n"
        "measure again what is called slower.");
    command->callback([given, &action] { action = [=] { return sweep(*given); }; });
}

}  // namespace plumb::cli
