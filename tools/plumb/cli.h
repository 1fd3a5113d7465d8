// The program's frame: every subcommand adds itself to the parser and returns an exit code when it runs.
//
// Exit codes: 0 success, 1 disagreement, 2 bad usage or bad input, 3 internal error.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "core/isa.h"

namespace plumb::cli {

enum ExitCode : int { success = 0, disagreement = 1, bad_input = 2, internal_error = 3, interrupted = 130 };

// Options that every command has; none changes a bit of a result, but the instruction set the last ones of native rays.
struct Common {
    int threads = 0;  // 0: all processors
    std::string isa = "auto";
    bool json = false;

    RunOptions run_options() const;
};
void add_common(CLI::App& command, Common& common);

// A number from `min` to `max`; CLI::Range takes "nan" for one.
CLI::Validator number_within(double min, double max);
// Anything but "".
CLI::Validator some_word();

// What to do once the whole command line has been read.
using Action = std::function<int()>;

void add_render(CLI::App& program, Action& action);
void add_plan(CLI::App& program, Action& action);
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

// Parses, runs, and turns every exception into one line on standard error and an exit code.
int run_program(int argc, char** argv);

}  // namespace plumb::cli
