// plumb experiment vrsm: the command. vrsm.h says what it repeats.
#include "tools/experiments/vrsm.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/parallel.h"
#include "io/file.h"
#include "io/make_scene.h"
#include "io/scene_file.h"
#include "io/scenes/generate.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/machine_load.h"
#include "tools/shared/outputs.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

struct VrsmOptions {
    VrsmRequest request;
    Common common;
    std::string folder, rays = "native";
};

// The atrium's three views, in place of the thesis' A, B and C, and the Cornell box.
std::vector<Scene> own_scenes(const std::string& folder) {
    std::vector<Scene> scenes;
    for (const std::uint32_t view : {1u, 2u, 3u}) {
        scenes.push_back(io::generate_scene("atrium", {262'000, view}, "atrium"));
        scenes.back().name = fmt::format("atrium, view {}", view);
    }
    Outputs scratch(folder);  // never committed
    scratch.write("", [&](const std::string& place) {
        io::make_scene("cornell", place);
        scenes.push_back(io::load_scene(place + "/cornell.toml", frame::method_tables()));
    });
    scenes.back().name = "cornell";
    return scenes;
}

std::vector<VrsmSubject> subjects(const VrsmOptions& given) {
    std::vector<Scene> scenes;
    for (const std::string& file : given.request.scenes) scenes.push_back(io::load_scene(file, frame::method_tables()));
    if (scenes.empty()) scenes = own_scenes(given.folder);
    std::vector<VrsmSubject> all;
    int views = 0;
    for (Scene& scene : scenes) {
        for (const VrsmSubject& other : all)
            if (other.scene.name == scene.name)
                throw InputError(fmt::format("--scene {}: given twice: expected different scenes", scene.name));
        all.push_back(vrsm_subject(std::move(scene), given.request));
        // The thesis' own numbers stand beside our version of its scene alone.
        if (all.back().scene.name.find("atrium") != std::string::npos && views < 3)
            all.back().test_case = std::string(1, char('A' + views++));
    }
    return all;
}

Vrsm measure(const VrsmOptions& given, const std::vector<VrsmSubject>& all) {
    const RunOptions options = given.common.run_options();
    Vrsm result{given.request, "", processor_name(), thread_count(options.threads), machine_load(), 0, {}};
    for (const VrsmSubject& subject : all) {
        VrsmScene& scene = result.scenes.emplace_back();
        scene.name = subject.scene.name, scene.test_case = subject.test_case;
        scene.triangles = flatten(subject.scene).triangles.size(), scene.size = subject.scene.frame_size;
        scene.settings = settings_json(vrsm_settings(subject, true, rsm::Visibility::algorithm_6, 5));
        if (given.request.times) scene.times = vrsm_times(subject, given.request, result.scenes.size() == 1, options);
        vrsm_look(subject, given.request, options, scene);
        result.isa = isa_name(last_dispatched_isa());
    }
    result.load_after = machine_load();
    return result;
}

std::string command_line(const VrsmOptions& given) {
    const VrsmRequest r, &now = given.request;
    std::string text = "plumb experiment vrsm -o " + given.folder;
    for (const std::string& scene : now.scenes) text += " --scene " + scene;
    for (const std::string& set : now.sets) text += " --set " + set;
    if (now.size != r.size) text += fmt::format(" --size {}", now.size);
    if (now.seeds != r.seeds) text += fmt::format(" --seeds {}", now.seeds);
    if (now.times) text += " --times";
    if (now.repeats != r.repeats) text += fmt::format(" --repeats {}", now.repeats);
    if (now.truth_rays != r.truth_rays) text += fmt::format(" --truth-rays {:g}", now.truth_rays);
    if (now.slots != r.slots) text += fmt::format(" --slots {}", fmt::join(now.slots, ","));
    if (!now.beyond) text += " --no-beyond";
    if (given.rays != "native") text += " --rays " + given.rays;
    if (given.common.threads > 0) text += fmt::format(" --threads {}", given.common.threads);
    if (given.common.isa != "auto") text += " --isa " + given.common.isa;
    return text;
}

int run_vrsm(VrsmOptions given) {
    const std::vector<int>& slots = given.request.slots;
    if (std::adjacent_find(slots.begin(), slots.end(), std::greater_equal<>()) != slots.end())
        throw InputError("--slots: expected each larger than the one before");
    given.request.rays = given.rays == "exact" ? Rays::exact : Rays::native;
    given.common.run_options();
    const std::vector<VrsmSubject> all = subjects(given);
    Outputs outputs(given.folder);
    // Of one core: rays of the truth, of which about half the texels are lit, and frames of every setting.
    const VrsmRequest& request = given.request;
    const double pixels = double(request.size) * request.size;
    const double rays = request.truth_rays > 0 ? request.truth_rays : 0.5 * pixels * pixels;
    const double settings = 2.0 * double(1 + 2 * request.slots.size()) + 18 + (request.beyond ? 24 : 0);
    const double a_scene = 3e-8 * rays + 6e-7 * pixels * settings * request.seeds +
                           (request.times ? 2.3e-5 * pixels * (request.repeats + 1) : 0);
    announce(fmt::format("experiment vrsm: {} scenes", all.size()), double(all.size()) * a_scene, given.common.run_options());
    const Vrsm result = measure(given, all);

    const std::vector<VrsmNumber> numbers = vrsm_numbers(result);
    const std::string json = json_text(vrsm_json(result, numbers)), csv = vrsm_csv(numbers);
    const std::string html = vrsm_html(result, numbers, command_line(given));
    outputs.write("vrsm.json", [&](const std::string& path) { io::write_text(path, json); });
    outputs.write("vrsm.csv", [&](const std::string& path) { io::write_text(path, csv); });
    outputs.write("vrsm.html", [&](const std::string& path) { io::write_text(path, html); });
    outputs.commit();
    std::string text = vrsm_text(result, numbers);
    for (const std::string& file : outputs.files()) text += "wrote " + file + "\n";
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_vrsm(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<VrsmOptions>();
    VrsmRequest& request = given->request;
    CLI::App* command = experiment.add_subcommand(
        "vrsm", "VRSM's evaluation: errors against shadow rays with their uncertainty, figures, times");
    command->add_option("-o,--output", given->folder, "folder for what is written")->required()->type_name("DIR");
    command
        ->add_option("--scene", request.scenes,
                     "a scene file; may be repeated; the atrium's three views and the Cornell box otherwise")
        ->allow_extra_args(false)
        ->check(some_word())
        ->type_name("FILE");
    command->add_option("--set", request.sets, "table.key=value in place of the thesis'; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    command->add_option("--size", request.size, "side of the frame in pixels and of the maps in texels; 256 otherwise, VRSM has 512")
        ->check(CLI::Range(16, 4096).description(""))
        ->type_name("N");
    command
        ->add_option("--seeds", request.seeds, "of the patterns and of the pixels' rotations: every error is their mean; 4 otherwise")
        ->check(CLI::Range(1, 1000).description(""))
        ->type_name("N");
    command->add_flag("--times", request.times, "also measure times, tables 5.1 to 5.3: on a machine that does nothing else");
    command->add_option("--repeats", request.repeats, "--times: frames of each setting, in turns; 9 otherwise")
        ->check(CLI::Range(1, 1000).description(""))
        ->type_name("N");
    command
        ->add_option("--truth-rays", request.truth_rays,
                     "about how many rays the truth of a scene asks; otherwise, and with 0, all of them")
        ->check(number_within(0, 1e15))
        ->type_name("N");
    command->add_option("--slots", request.slots, "slots of the micro linear buffer; 3,5,9,17,32 otherwise")
        ->delimiter(',')
        ->check(CLI::Range(2, 32).description(""))
        ->type_name("S,S");
    command->add_flag_callback(
        "--no-beyond", [given] { given->request.beyond = false; }, "leave out the settings beyond the thesis'");
    command->add_option("--rays", given->rays, "of the truth: native, or exact, the same bits everywhere")
        ->check(CLI::IsMember({"native", "exact"}).description(""))
        ->type_name("RAYS");
    add_common(*command, given->common);
    command->footer(
        "Files: vrsm.csv and vrsm.json (every number, beside what VRSM prints), vrsm.html (opens without a network).\n"
        "The setting is the thesis': RGBA16F targets, indirect light of half size from 15 paths of 10 samples with 5\n"
        "slots, blur of 17; --set changes it, for what the experiment does not vary itself. Every error is the mean over\n"
        "the seeds, with its standard error; what differs by less than two of them is not told apart, and no winner is\n"
        "named. Errors do not depend on the machine's load; times do. The truth takes most of the time: --truth-rays 2e7\n"
        "--size 128 is a quick look.");
    command->callback([given, &action] { action = [=] { return run_vrsm(*given); }; });
}

}  // namespace plumb::cli
