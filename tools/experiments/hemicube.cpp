// plumb experiment hemicube: the command.
#include "tools/experiments/hemicube.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "core/error.h"
#include "core/parallel.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/machine_load.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

struct HemicubeOptions {
    Common common;
    HemicubeRequest request;
    std::vector<std::string> only;
    std::string folder;
    SceneOptions scene;  // --size alone
    int samples = 0, pixel_samples = 0, elements = 0, repeats = 0;  // 0: as --quick says
};

std::string command_line(const HemicubeOptions& given) {
    const HemicubeRequest& r = given.request;
    std::string text = fmt::format("plumb experiment hemicube --samples {} --elements {} --pixel-samples {} --size {}x{} --repeats {}", r.samples, r.elements, r.pixel_samples, r.size.x,
                                   r.size.y, r.repeats);
    if (r.quick) text += " --quick";
    if (!given.only.empty()) text += fmt::format(" --only {}", fmt::join(given.only, ","));
    if (given.common.threads > 0) text += fmt::format(" --threads {}", given.common.threads);
    if (given.common.isa != "auto") text += " --isa " + given.common.isa;
    return text;
}

void check(HemicubeOptions& given) {
    HemicubeRequest& r = given.request;
    for (const std::string& part : given.only) {
        if (std::find(hemicube_parts.begin(), hemicube_parts.end(), part) == hemicube_parts.end())
            throw InputError(fmt::format("--only {}: expected {}", io::printable(part), fmt::join(hemicube_parts, ", ")));
        r.parts.insert(part);
    }
    if (r.quick) r.samples = 256, r.elements = 64, r.pixel_samples = 32, r.size = {48, 48}, r.repeats = 1;
    if (given.samples > 0) r.samples = given.samples;
    if (given.elements > 0) r.elements = given.elements;
    if (given.repeats > 0) r.repeats = given.repeats;
    if (given.pixel_samples > 0) r.pixel_samples = given.pixel_samples;
    if (!given.scene.size.empty()) r.size = parse_size("--size", given.scene.size, 16);
}

int run_hemicube(HemicubeOptions given) {
    check(given);
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    // Of one core: ten minutes for all parts on two.
    const double parts = given.request.parts.empty() ? 1 : double(given.request.parts.size()) / double(hemicube_parts.size());
    announce("experiment hemicube", parts * (given.request.quick ? 60 : 1200), given.common.run_options());
    const Hemicube result = measure_hemicube(given.request, given.common.run_options(), [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
    const std::string json = json_text(hemicube_json(result));
    std::string text = hemicube_text(result);
    if (outputs) {
        outputs->write("hemicube.json", [&](const std::string& path) { io::write_text(path, json); });
        outputs->write("hemicube.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("hemicube.csv", [&](const std::string& path) { io::write_text(path, hemicube_csv(result)); });
        outputs->write("hemicube.html", [&](const std::string& path) { io::write_text(path, hemicube_html(result, command_line(given))); });
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

Hemicube measure_hemicube(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    Hemicube result{{}, processor_name(), "", thread_count(options.threads), machine_load()};
    const auto add = [&](std::vector<IprSheet> sheets) { result.sheets.insert(result.sheets.end(), sheets.begin(), sheets.end()); };
    if (request.wants("complexity")) add({measure_complexity(request, options, tell)});
    if (request.wants("sizes")) add({measure_sizes(request, options, tell)});
    if (request.wants("rows")) add({measure_rows(request, options, tell)});
    if (request.wants("plates")) add(measure_plates(request, options, tell));
    if (request.wants("projections")) add({measure_projections(request, options, tell)});
    if (request.wants("buffers")) add({measure_buffers(request, options, tell)});
    if (request.wants("solvers")) add(measure_solvers(request, options, tell));
    result.isa = isa_name(last_dispatched_isa());
    return result;
}

void add_hemicube(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<HemicubeOptions>();
    HemicubeRequest& r = given->request;
    CLI::App* command = experiment.add_subcommand("hemicube", "the benchmark and the plates of HEM again: hemicube radiosity, and its error against path tracing");
    command->add_option("-o,--output", given->folder, "folder for hemicube.html, hemicube.txt, hemicube.csv and hemicube.json")->check(some_word())->type_name("DIR");
    command->add_option("--only", given->only, fmt::format("some of {}; all otherwise", fmt::join(hemicube_parts, ", ")))->delimiter(',')->type_name("P,P");
    command->add_flag("--quick", r.quick, "small meshes, hemicubes and pictures: to see that all of it works");
    command->add_option("--samples", given->samples, "paths of the truth at an element; 2048 otherwise, quick 256")->check(CLI::Range(32, 1 << 20).description(""))->type_name("N");
    command->add_option("--elements", given->elements, "held against the truth, at most; 512 otherwise, quick 64")->check(CLI::Range(16, 1 << 16).description(""))->type_name("N");
    command->add_option("--pixel-samples", given->pixel_samples, "paths of the truth at a pixel of plates C.9 and C.10; 256 otherwise, quick 32")
        ->check(CLI::Range(32, 1 << 20).description(""))
        ->type_name("N");
    command->add_option("--repeats", given->repeats, "whose median is a time, where one takes less than two seconds; 3 otherwise, quick 1")
        ->check(CLI::Range(1, 1000).description(""))
        ->type_name("N");
    add_size_option(*command, given->scene);
    add_common(*command, given->common);
    command->footer(
        "complexity: test 1, figure 5.5. sizes: test 2, figures 5.6 and 5.7. rows: one row of form factors by hemicubes and by rays, error against\n"
        "time. plates: C.1 to C.10, the last two beside the thesis' 58 s and 203 s. projections: one picture in place of a hemicube (4.5.3). buffers:\n"
        "multiplier maps, eyes and RGBE as published (5.5 to 5.7). solvers: error against products with all rows. All but times has the same bits\n"
        "every time; times mean something on an idle machine only.");
    command->callback([given, &action] { action = [=] { return run_hemicube(*given); }; });
}

}  // namespace plumb::cli
