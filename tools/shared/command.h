// Names the exit codes, adds the options that every command and every experiment has, and checks their values.
//
// Exit codes: 0 success, 1 disagreement, 2 bad usage or bad input, 3 internal error.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

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

// Runs a command once the whole command line has been read; returns the exit code.
using Action = std::function<int()>;

}  // namespace plumb::cli
