// plumb experiment probe-ladder: the command.
#include "tools/experiments/probe_ladder.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "core/error.h"
#include "gi/probes/run_stages.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

struct LadderOptions {
    SceneOptions scene;
    Common common;
    LadderRequest request;
    std::vector<std::string> axes;
    std::string output, html;
    bool without_sky = false;
};

int run_ladder(LadderOptions given) {
    for (const std::string& axis : given.axes) {
        if (std::find(ladder_axes.begin(), ladder_axes.end(), axis) == ladder_axes.end())
            throw InputError(fmt::format("--axes {}: expected {}", io::printable(axis), fmt::join(ladder_axes, ", ")));
        given.request.axes.insert(axis);
    }
    if (given.request.check.truth_rays % 2 != 0) throw InputError("--truth-rays: expected an even number");
    Scene scene = load(given.scene);
    if (given.without_sky) scene.environment = {};
    const probes::BakeParams params = settings_of(scene, given.scene).probes;
    // Some eight rungs an axis, each a bake: 0.5 ms of one core a receiver; and rays of the truth.
    const std::size_t axes = given.request.axes.empty() ? ladder_axes.size() : given.request.axes.size();
    const double receivers = probes::expected_bake(scene, params).receivers;
    announce(fmt::format("experiment probe-ladder: {} axes, about {:.0f} receivers a bake", axes, receivers),
             8 * double(axes) * 5e-4 * receivers + 1e-6 * given.request.check.receivers * given.request.check.truth_rays,
             given.common.run_options());
    const Ladder ladder = climb(scene, params, given.request, given.common.run_options(), show_progress);
    show_progress("");
    std::string command = "plumb experiment probe-ladder " + given.scene.file;
    for (const std::string& set : given.scene.sets) command += " --set " + set;
    if (given.request.check.most_sky < 1) command += fmt::format(" --most-sky {:g}", given.request.check.most_sky);
    if (given.without_sky) command += " --without-sky";
    const std::string text = ladder_text(ladder);
    if (!given.output.empty()) io::write_text(given.output, text);
    if (!given.html.empty()) io::write_text(given.html, ladder_html(ladder, command));
    std::fputs((given.common.json ? ladder_json(ladder) : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_probe_ladder(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<LadderOptions>();
    CLI::App* command =
        experiment.add_subcommand("probe-ladder", "what each number of a bake buys: error against cost, a curve a number");
    command->add_option("scene", given->scene.file, "the scene")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->output, "the tables, as text")->check(some_word())->type_name("FILE");
    command->add_option("--html", given->html, "one page with the curves")->check(some_word())->type_name("FILE");
    command->add_option("--axes", given->axes, fmt::format("some of {}; all otherwise", fmt::join(ladder_axes, ", ")))
        ->delimiter(',')
        ->type_name("A,A");
    command->add_option("--receivers", given->request.check.receivers, "held against the truth; 1024 otherwise")
        ->check(CLI::Range(1, 1 << 20).description(""))
        ->type_name("N");
    command->add_option("--truth-rays", given->request.check.truth_rays, "of each of them; 8192 otherwise")
        ->check(CLI::Range(64, 1 << 20).description(""))
        ->type_name("N");
    command
        ->add_option("--most-sky", given->request.check.most_sky,
                     "receivers of which more than this share of the rays meets nothing are not held against it; 1 otherwise")
        ->check(number_within(0, 1))
        ->type_name("S");
    command->add_option("--most-probes", given->request.most_probes, "the last rung of that axis; 512 otherwise")
        ->check(CLI::Range(1, 1 << 16).description(""))
        ->type_name("N");
    command->add_flag("--without-sky", given->without_sky, "the environment sends nothing: what surfaces send, alone");
    command->add_option("--set", given->scene.sets, "probes.key=value in place of the scene file's; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer(
        "The truth is a sum over the rays of each receiver, in double, without probes; the radiance that leaves a surface is "
        "direct\n"
        "light with shadow rays. One number at a time is changed about the scene's [probes]. Every rung is a whole bake: "
        "choose a\n"
        "lightmap of some thousand receivers (--set probes.lightmap_size=128). Errors have the same bits every time, seconds "
        "have not.");
    command->callback([given, &action] { action = [=] { return run_ladder(*given); }; });
}

}  // namespace plumb::cli
