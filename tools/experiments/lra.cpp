// plumb experiment lra: the command.
#include "tools/experiments/lra.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "core/error.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

namespace {

// 0: as --quick says.
struct LraOptions {
    Common common;
    bool quick = false;
    std::vector<std::string> only;
    std::string folder;
    std::int64_t triangles = 0;
    int divide = 0, map = 0, lights = 0, repeats = 0;
};

LraRequest request_of(const LraOptions& given) {
    LraRequest r;
    for (const std::string& part : given.only) {
        if (std::find(lra_parts.begin(), lra_parts.end(), part) == lra_parts.end())
            throw InputError(fmt::format("--only {}: expected {}", io::printable(part), fmt::join(lra_parts, ", ")));
        r.parts.insert(part);
    }
    if (given.quick) r.quick = true, r.triangles = 40'000, r.divide = 8, r.map = 128, r.most_lights = 8, r.repeats = 1;
    if (given.triangles > 0) r.triangles = given.triangles;
    if (given.divide > 0) r.divide = given.divide;
    if (given.map > 0) r.map = given.map;
    if (given.lights > 0) r.most_lights = given.lights;
    if (given.repeats > 0) r.repeats = given.repeats;
    return r;
}

std::string command_line(const LraOptions& given, const LraRequest& r) {
    std::string text = fmt::format("plumb experiment lra --triangles {} --divide {} --map {} --lights {} --repeats {}", r.triangles, r.divide, r.map, r.most_lights, r.repeats);
    if (!given.only.empty()) text += fmt::format(" --only {}", fmt::join(given.only, ","));
    if (given.common.threads > 0) text += fmt::format(" --threads {}", given.common.threads);
    if (given.common.isa != "auto") text += " --isa " + given.common.isa;
    return text;
}

int run_lra(const LraOptions& given) {
    const LraRequest request = request_of(given);
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    // Of one core: half an hour on two for 4 million triangles and all parts.
    const double parts = request.parts.empty() ? 1 : double(request.parts.size()) / double(lra_parts.size());
    announce(fmt::format("experiment lra: a city of {} triangles", request.triangles), 3600 * parts * double(request.triangles) / 4e6, given.common.run_options());
    const Lra result = measure_lra(request, given.common.run_options(), [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
    const std::string json = json_text(lra_json(result));
    std::string text = lra_text(result);
    if (outputs) {
        outputs->write("lra.json", [&](const std::string& path) { io::write_text(path, json); });
        outputs->write("lra.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("lra.csv", [&](const std::string& path) { io::write_text(path, lra_csv(result)); });
        outputs->write("lra.html", [&](const std::string& path) { io::write_text(path, lra_html(result, command_line(given, request))); });
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_lra(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<LraOptions>();
    CLI::App* command = experiment.add_subcommand("lra", "chapter 7 of LRA again, on a city: algorithms, share of the model, lights, sizes, what moves");
    command->add_option("-o,--output", given->folder, "folder for lra.html, lra.txt, lra.csv and lra.json")->check(some_word())->type_name("DIR");
    command->add_option("--only", given->only, fmt::format("some of {}; all otherwise", fmt::join(lra_parts, ", ")))->delimiter(',')->type_name("P,P");
    command->add_flag("--quick", given->quick, "a city of 40,000 triangles, sides of frames by 8, maps of 128, 8 lights, once: to see that all of it works");
    command->add_option("--triangles", given->triangles, "of the city, about; 4,000,000 otherwise")->check(CLI::Range(20'000, 16'000'000).description(""))->type_name("N");
    command->add_option("--divide", given->divide, "sides of frames by that; 1 otherwise")->check(CLI::Range(1, 30).description(""))->type_name("N");
    command->add_option("--map", given->map, "texels of a side of a light's map; 2048 otherwise")->check(CLI::Range(16, 8192).description(""))->type_name("N");
    command->add_option("--lights", given->lights, "most of them, above 5; 32 otherwise")->check(CLI::Range(5, 256).description(""))->type_name("N");
    command->add_option("--repeats", given->repeats, "whose median is a time; 3 otherwise")->check(CLI::Range(1, 1000).description(""))->type_name("N");
    add_common(*command, given->common);
    command->footer(
        "algorithms: table 7.1. share: table 7.2. types: table 7.3. lights: table 7.4 and on. sizes: table 7.5. moving: table 7.6, with and without\n"
        "what is kept. kept: one of up to 16 lights moves. A light holds about half a gigabyte at the thesis' 2048 x 2048 texels. Counts are the same\n"
        "every time; times mean something on an idle machine only.");
    command->callback([given, &action] { action = [=] { return run_lra(*given); }; });
}

}  // namespace plumb::cli
