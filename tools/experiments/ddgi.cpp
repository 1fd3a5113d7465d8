// plumb experiment ddgi: the command.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "core/error.h"
#include "gi/frame/settings.h"
#include "io/file.h"
#include "tools/experiments/ddgi.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/outputs.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

struct DdgiOptions {
    SceneOptions scene;
    Common common;
    std::string folder;
    DdgiRequest request;
    std::vector<std::string> volume;
};

// --volume key=value: the parameters of DDGI that the table does not vary.
void set_volume(DdgiRequest& request, const std::vector<std::string>& sets) {
    std::vector<Field> all = ddgi::fields(request.volume);
    for (const std::string& set : sets) {
        const std::size_t at = set.find('=');
        if (at == std::string::npos) throw InputError("--volume " + set + ": expected KEY=VALUE");
        const std::string key = set.substr(0, at), text = set.substr(at + 1), place = "--volume " + set;
        Field& field = find_field(all, key, place);
        if (key == "side" || key == "depth_side" || key == "rays") throw InputError(place + ": --sides and --rays say it");
        if (text == "true" || text == "false") {
            set_field(field, text == "true", place);
            continue;
        }
        std::size_t read = 0;
        double value = 0;
        try {
            value = std::stod(text, &read);
        } catch (const std::exception&) {
            read = 0;
        }
        if (read == 0 || read != text.size()) throw InputError(place + ": expected a number, true or false");
        set_field(field, value, place);
    }
    validate_fields("ddgi", all);
}

std::string command_line(const DdgiOptions& given) {
    const DdgiRequest& r = given.request;
    std::string text = fmt::format("plumb experiment ddgi {} --lightmap {} --samples {} --grids {} --sides {} --rays {} --probes {}", given.scene.file,
                                   r.lightmap, r.samples, fmt::join(r.grids, ","), fmt::join(r.sides, ","), fmt::join(r.rays, ","),
                                   fmt::join(r.probes, ","));
    if (r.open < 1) text += fmt::format(" --open {:g}", r.open);
    for (const std::string& set : given.volume) text += " --volume " + set;
    for (const std::string& set : given.scene.sets) text += " --set " + set;
    return text;
}

std::string settings_text(const DdgiRequest& r) {
    return fmt::format("{} grids, {} sides, {} counts of rays, {} of probes", r.grids.size(), r.sides.size(), r.rays.size(), r.probes.size());
}

// Of one core: paths of the truth, half of the lightmap covered, and rays of all settings until the light has settled.
double expected_seconds(const DdgiRequest& r) {
    double probes = 0, rays = 0;
    for (const int side : r.grids) probes += double(side) * side * side;
    for (const int n : r.rays) rays += n;
    return 1.6e-6 * 0.5 * r.lightmap * r.lightmap * r.samples + 2.4e-5 * probes * rays * double(r.sides.size());
}

int run_ddgi(DdgiOptions given) {
    const RunOptions options = given.common.run_options();
    set_volume(given.request, given.volume);
    const Scene scene = load(given.scene);
    given.request.bake = settings_of(scene, given.scene).probes;
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    announce("experiment ddgi: " + settings_text(given.request), expected_seconds(given.request), options);
    DdgiResult result = measure_ddgi(scene, given.request, options, [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
    result.scene = io::stem_of(scene.name);
    const std::string json = json_text(ddgi_json(result));
    std::string text = ddgi_text(result);
    if (outputs) {
        const std::string html = ddgi_html(result, command_line(given), options);
        outputs->write("ddgi.json", [&](const std::string& path) { io::write_text(path, json); });
        outputs->write("ddgi.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("ddgi.html", [&](const std::string& path) { io::write_text(path, html); });
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_ddgi(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<DdgiOptions>();
    DdgiRequest& request = given->request;
    CLI::App* command = experiment.add_subcommand("ddgi", "DDGI's probes and clustered transport against path tracing, on a lightmap");
    command->add_option("scene", given->scene.file, "the scene")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for ddgi.html, ddgi.txt and ddgi.json")->check(some_word())->type_name("DIR");
    const auto list = [&](const char* name, std::vector<int>& values, const char* meaning, int low, int high) {
        command->add_option(name, values, meaning)->delimiter(',')->check(CLI::Range(low, high).description(""))->type_name("N,N");
    };
    list("--grids", request.grids, "probes of DDGI along each axis; 4,8,16 otherwise", 1, 31);
    list("--sides", request.sides, "texels a side of their irradiance; 6,8 otherwise", 1, 32);
    list("--rays", request.rays, "rays of each probe, of both methods; 64,128,256,512 otherwise", 1, 8192);
    list("--probes", request.probes, "probes with clustered transport; 8,30,78,300 otherwise", 1, 1 << 15);
    command->add_option("--lightmap", request.lightmap, "texels a side; 128 otherwise")->check(CLI::Range(8, 2048).description(""))->type_name("N");
    command->add_option("--samples", request.samples, "paths a receiver of the truth; 1024 otherwise")
        ->check(CLI::Range(16, 1 << 24).description(""))
        ->type_name("N");
    command->add_option("--open", request.open, "leave out receivers more open to the sky than this share, such as outer walls; 1 otherwise: none")
        ->check(number_within(0, 1))
        ->type_name("X");
    command->add_flag_callback("--no-variants", [given] { given->request.variants = false; }, "leave out what each part of DDGI is worth");
    command->add_option("--volume", given->volume, "a parameter of DDGI in place of its default; may be repeated")
        ->allow_extra_args(false)
        ->type_name("K=V");
    command->add_option("--set", given->scene.sets, "probes.key=value in place of the scene file's; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer(
        "Irradiance of the lightmap's receivers, but what lamps send straight to them. All but the seconds is the same on\n"
        "every machine with exact rays (probes.rays, the default). gi/ddgi/README.md has the tables of two scenes.\n"
        "A quick look: --lightmap 48 --samples 64 --grids 4 --sides 8 --rays 64,256 --probes 8 --no-variants.");
    command->callback([given, &action] { action = [=] { return run_ddgi(*given); }; });
}

}  // namespace plumb::cli
