// The experiments behind `plumb experiment`, a file each.
#pragma once

#include "tools/shared/command.h"

namespace plumb::cli {

void add_closed_forms(CLI::App& experiment, Action& action);
void add_one_bounce(CLI::App& experiment, Action& action);
void add_vrsm(CLI::App& experiment, Action& action);
void add_isr(CLI::App& experiment, Action& action);
void add_probes(CLI::App& experiment, Action& action);
void add_probe_ladder(CLI::App& experiment, Action& action);
void add_ddgi(CLI::App& experiment, Action& action);
void add_ipr(CLI::App& experiment, Action& action);
void add_hemicube(CLI::App& experiment, Action& action);
void add_lra(CLI::App& experiment, Action& action);
void add_screen(CLI::App& experiment, Action& action);
void add_indirect_shadow(CLI::App& experiment, Action& action);
void add_shadows(CLI::App& experiment, Action& action);
void add_defaults(CLI::App& experiment, Action& action);

}  // namespace plumb::cli
