// A command that takes long says so before it begins.
#pragma once

#include <string>

#include "core/isa.h"

namespace plumb::cli {

// "about 40 s", "about 3 minutes", "about 2 hours": one digit, from ten on in steps of five, as an estimate deserves.
std::string about(double seconds);

// One line on standard error: "WHAT: about 3 minutes on 2 threads"; nothing where it is less than 20 s. core_seconds: of one core, as
// measured on one of 2 GHz or more with AVX-512; all of it is shared by the threads.
void announce(const std::string& what, double core_seconds, const RunOptions& options);

}  // namespace plumb::cli
