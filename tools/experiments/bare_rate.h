// How much of a bake's ray time is rays: the same packets, in the same order, given to the ray query and nothing else.
#pragma once

#include "gi/probes/bake.h"

namespace plumb::cli {

struct BareRate {
    std::uint64_t rays = 0;       // of the blocks that were looked at
    double bake_seconds = 0;      // their ray time: directions, hits, counts and what is written of them
    double bare_seconds = 0;      // the queries alone
    double share() const { return bare_seconds / bake_seconds; }
};

// Of blocks spread over the bake, `rays` of them at least where it has as many. Each time is the least of `repeats`, in turns.
BareRate bare_rate(const probes::BakeGraph& graph, std::uint64_t rays, int repeats, const RunOptions& options);

}  // namespace plumb::cli
