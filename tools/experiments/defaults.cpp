// plumb experiment defaults: the command, and what it writes.
#include "tools/experiments/defaults.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "core/error.h"
#include "core/nearest_known.h"
#include "core/parallel.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/machine_load.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct DefaultsOptions {
    Common common;
    DefaultsRequest request;
    std::string folder;
};

const char* word(DefaultVerdict::Is is) {
    switch (is) {
        case DefaultVerdict::Is::on_front: return "on the front";
        case DefaultVerdict::Is::near_front: return "within 10 %";
        case DefaultVerdict::Is::not_told_apart: return "not told apart";
        default: return "OFF";
    }
}

std::string percent(double share) { return std::isnan(share) ? "not a number" : fmt::format("{:.2f}", 100 * share); }

std::string rows_text(const std::vector<DefaultsRow>& rows) {
    std::vector<std::vector<std::string>> cells;
    for (const DefaultsRow& r : rows)
        cells.push_back({r.scene, std::to_string(r.size.x), r.group, r.choice, r.setting, r.refused ? "" : milliseconds_text(r.ms),
                         r.refused ? "refused" : percent(r.error), r.refused ? r.why : percent(r.spread)});
    return format_table({{"scene"}, {"pixels", Align::right}, {"group"}, {"choice"}, {"setting"}, {"ms", Align::right},
                         {"error %", Align::right}, {"+-", Align::right}}, cells);
}

std::string verdicts_text(const std::vector<DefaultVerdict>& verdicts) {
    std::vector<std::vector<std::string>> cells;
    for (const DefaultVerdict& v : verdicts)
        cells.push_back({v.scene, std::to_string(v.size.x), v.choice, percent(v.own->error),
                         v.best ? percent(v.best->error) : "", v.best ? v.best->setting : "no other is as fast", word(v.is)});
    return format_table({{"scene"}, {"pixels", Align::right}, {"choice"}, {"error %", Align::right}, {"best as fast", Align::right},
                         {"with"}, {"default is"}}, cells);
}

std::string csv_of(const std::vector<DefaultsRow>& rows) {
    std::string csv = "scene,pixels,group,choice,setting,ms,error,standard_error\n";
    for (const DefaultsRow& r : rows)
        if (!r.refused)
            csv += fmt::format("{},{},{},{},\"{}\",{:.4g},{:.6g},{:.3g}\n", r.scene, r.size.x, r.group, r.choice, r.setting, r.ms, r.error, r.spread);
    return csv;
}

Json json_of(const std::vector<DefaultsRow>& rows, const std::vector<DefaultVerdict>& verdicts) {
    Json json = {{"rows", Json::array()}, {"verdicts", Json::array()}};
    for (const DefaultsRow& r : rows) {
        Json row = {{"scene", r.scene}, {"pixels", r.size.x}, {"group", r.group}, {"choice", r.choice}, {"setting", r.setting}};
        if (r.refused)
            row["refused"] = r.why;
        else
            row["ms"] = r.ms, row["error"] = r.error, row["standard_error"] = r.spread;
        json["rows"].push_back(row);
    }
    for (const DefaultVerdict& v : verdicts)
        json["verdicts"].push_back({{"scene", v.scene}, {"pixels", v.size.x}, {"group", v.group}, {"choice", v.choice},
                                    {"best", v.best ? Json(v.best->setting) : Json(nullptr)}, {"default", word(v.is)}});
    return json;
}

int run_defaults(const DefaultsOptions& given) {
    DefaultsRequest request = given.request;
    if (request.scenes.empty())
        for (const char* name : {"cornell", "atrium", "hall", "rooms"}) request.scenes.push_back(fmt::format("data/scenes/{0}/{0}.toml", name));
    std::vector<std::string> names;
    for (const ChoiceGroup& group : default_choices()) names.push_back(group.name);
    for (const std::string& group : request.groups)
        if (std::find(names.begin(), names.end(), group) == names.end())
            throw InputError(fmt::format("--only {}: unknown group{}", io::printable(group), nearest_known(group, names)));
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    double pixels = 0;
    for (const int size : request.sizes) pixels += double(size) * size;
    // Of one core: 60 settings, 2 us a pixel each.
    announce(fmt::format("experiment defaults: {} scenes, {} sizes", request.scenes.size(), request.sizes.size()),
             double(request.scenes.size()) * pixels * (1 + request.runs) * 60 * 2e-6, given.common.run_options());
    const double load = machine_load();
    const std::vector<DefaultsRow> rows = measure_defaults(request, given.common.run_options(), [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
    const std::vector<DefaultVerdict> verdicts = judge_defaults(rows);
    for (const DefaultsRow& row : rows)
        if (verdicts.empty() && row.refused) throw InputError(row.why);
    if (verdicts.empty()) throw InputError("experiment defaults: nothing could be judged: no scene has light of any group");
    const auto off = std::count_if(verdicts.begin(), verdicts.end(), [](const DefaultVerdict& v) { return v.is == DefaultVerdict::Is::off; });
    const std::string where = fmt::format("{}, {} threads, {}; load of the machine before: {:.1f}", processor_name(), thread_count(given.common.threads), isa_name(last_dispatched_isa()), load);
    const std::string text = where + "\n\n" + rows_text(rows) + "\n" + verdicts_text(verdicts) +
                             fmt::format("\n{} of {} defaults are off the front of error against time\n", off, verdicts.size());
    Json json = json_of(rows, verdicts);
    json["processor"] = processor_name(), json["load_before"] = load, json["off"] = off;
    if (outputs) {
        outputs->write("defaults.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("defaults.csv", [&](const std::string& path) { io::write_text(path, csv_of(rows)); });
        outputs->write("defaults.json", [&](const std::string& path) { io::write_text(path, json_text(json)); });
        outputs->commit();
    }
    std::fputs((given.common.json ? json_text(json) : text).c_str(), stdout);
    if (outputs && !given.common.json)
        for (const std::string& file : outputs->files()) std::printf("wrote %s\n", file.c_str());
    return off > 0 ? disagreement : success;
}

}  // namespace

void add_defaults(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<DefaultsOptions>();
    DefaultsRequest& request = given->request;
    CLI::App* command = experiment.add_subcommand("defaults", "whether every default lies on the front of error against time");
    command->add_option("scenes", request.scenes, "scenes: .toml, or bare .obj, .gltf or .glb; cornell, atrium, hall and rooms of data/scenes otherwise")->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for defaults.txt, defaults.csv and defaults.json")->check(some_word())->type_name("DIR");
    command->add_option("--sizes", request.sizes, "pixels a side; 256,512,1024 otherwise")->delimiter(',')->check(CLI::Range(8, 4096).description(""))->type_name("N,N");
    command->add_option("--only", request.groups, "shadow, rsm, rsm.disc, isr, ao, ao.horizon, probes or radiosity; may be repeated")->type_name("GROUP");
    add_preset_option(*command, request.preset);
    command->add_option("--set", request.sets, "table.key=value in place of a default, to see what would become of it; may be repeated")->allow_extra_args(false)->type_name("T.K=V");
    command->add_option("--spp", request.samples, "paths a pixel of the truths; 64 otherwise")->check(CLI::Range(4, 65536).description(""))->type_name("N");
    command->add_option("--runs", request.runs, "each with a seed of its own; the time is their median; 3 otherwise")->check(CLI::Range(1, 1000).description(""))->type_name("N");
    command->add_flag("--no-cache", request.no_cache, "trace truths anew");
    add_common(*command, given->common);
    command->footer(
        "A setting's error is the RMSE of the layer that it decides over (direct or indirect irradiance, open share, or the picture) against\n"
        "a path traced one, over the truth's mean and without the truth's noise; +- is its standard error over seeds. A default is off the\n"
        "front where an alternative that takes no longer errs less by more than a tenth and by more than two standard errors. Exit code 1:\n"
        "one is. Times are of a frame, with the bake or the solution that it shows; they need an idle machine.");
    command->callback([given, &action] { action = [=] { return run_defaults(*given); }; });
}

}  // namespace plumb::cli
