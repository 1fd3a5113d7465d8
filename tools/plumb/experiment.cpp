// plumb experiment: the subcommand; the experiments themselves are in tools/experiments.
#include "tools/experiments/experiments.h"
#include "tools/plumb/cli.h"

namespace plumb::cli {

void add_experiment(CLI::App& program, Action& action) {
    CLI::App* command =
        program.add_subcommand("experiment", "repeat what is known or published: closed-forms, one-bounce, vrsm, isr, probes, probe-ladder, ddgi, ipr, hemicube, lra, screen, indirect-shadow, shadows, defaults");
    command->require_subcommand(1);
    command->footer(
        "Experiments:\n"
        "  plumb experiment closed-forms --rays exact\n"
        "  plumb experiment one-bounce SCENE --sizes 64,128,256\n"
        "  plumb experiment vrsm -o out\n"
        "  plumb experiment isr -o out\n"
        "  plumb experiment probes SCENE\n"
        "  plumb experiment probe-ladder SCENE --html page.html\n"
        "  plumb experiment ddgi SCENE -o out\n"
        "  plumb experiment ipr SCENE -o out\n"
        "  plumb experiment hemicube -o out\n"
        "  plumb experiment lra -o out\n"
        "  plumb experiment screen SCENES... -o out\n"
        "  plumb experiment indirect-shadow SCENE -o out\n"
        "  plumb experiment shadows SCENES... -o out\n"
        "  plumb experiment defaults -o out\n"
        "plumb experiment NAME --help tells more.");
    add_closed_forms(*command, action);
    add_one_bounce(*command, action);
    add_vrsm(*command, action);
    add_isr(*command, action);
    add_probes(*command, action);
    add_probe_ladder(*command, action);
    add_ddgi(*command, action);
    add_ipr(*command, action);
    add_hemicube(*command, action);
    add_lra(*command, action);
    add_screen(*command, action);
    add_indirect_shadow(*command, action);
    add_shadows(*command, action);
    add_defaults(*command, action);
}

}  // namespace plumb::cli
