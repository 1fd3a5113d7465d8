// Form factors of hemicube radiosity against the naive way (HEM 5.6): five pictures from every vertex, in every pass.
#pragma once

#include "tools/bench_raster/experiments.h"

namespace plumb::bench {

// Prints a table: rows of HEM 5.8's box and a pass with them, all of its vertices; with a peer, five of its pictures from each of 100
// vertices, extrapolated to all. What the naive way would read back and sum is not counted.
void compare_hemicubes(const Options& options);

}  // namespace plumb::bench
