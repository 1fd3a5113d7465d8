// How busy the machine is: what is said beside measured times.
#pragma once

namespace plumb::cli {

// Processes that ran or wanted to, mean of a minute; NaN where the system does not tell.
double machine_load();

}  // namespace plumb::cli
