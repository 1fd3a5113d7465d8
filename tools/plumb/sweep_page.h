// A sweep as one page of HTML: curves of error against time, the pictures of every point, the table.
#pragma once

#include <string>

#include "tools/shared/sweep.h"

namespace plumb::cli {

// Without pictures, as of a sweep that was read from a file, a click on a point shows its values alone. `command` is
// the command line that measured it.
std::string sweep_html(const Sweep& sweep, const SweepPictures* pictures, const std::string& command);

}  // namespace plumb::cli
