// plumb validate --refill: out/ of an export as it was before anything was written to it.
#pragma once

#include <string>

namespace plumb::cli {

// Overwrites each output that has a filling with it, so that a run which writes nothing is not judged by what an earlier
// one wrote. Judges nothing. Throws InputError where no output has one, before anything is written.
int refill(const std::string& manifest, bool json);

}  // namespace plumb::cli
