// The bake that a frame of the method probes reads, made in memory, for programs and tests that keep none.
#pragma once

#include "core/isa.h"
#include "gi/frame/settings.h"

namespace plumb::frame {

// Sets settings.bake where the method is probes and it is missing. Throws what probes::BakeGraph throws.
void add_bake(const Scene& scene, Settings& settings, const RunOptions& options = {});

}  // namespace plumb::frame
