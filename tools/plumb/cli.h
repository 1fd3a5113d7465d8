// The program's frame: every subcommand adds itself to the parser and returns an exit code when it runs.
#pragma once

#include "tools/shared/command.h"

namespace plumb::cli {

void add_render(CLI::App& program, Action& action);
void add_plan(CLI::App& program, Action& action);
void add_graph(CLI::App& program, Action& action);
void add_bake(CLI::App& program, Action& action);
void add_lightmap(CLI::App& program, Action& action);
void add_compare(CLI::App& program, Action& action);
void add_explain(CLI::App& program, Action& action);
void add_validate(CLI::App& program, Action& action);
void add_export(CLI::App& program, Action& action);
void add_sweep(CLI::App& program, Action& action);
void add_stability(CLI::App& program, Action& action);
void add_stages(CLI::App& program, Action& action);
void add_devices(CLI::App& program, Action& action);
void add_probe_device(CLI::App& program, Action& action);
void add_experiment(CLI::App& program, Action& action);
void add_make_scene(CLI::App& program, Action& action);
void add_pov(CLI::App& program, Action& action);
void add_cameras(CLI::App& program, Action& action);
void add_batch(CLI::App& program, Action& action);
void add_formfactor(CLI::App& program, Action& action);

// Parses, runs, and turns every exception into one line on standard error and an exit code.
int run_program(int argc, char** argv);

}  // namespace plumb::cli
