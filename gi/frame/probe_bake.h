// The bake that a frame of the method probes reads, made in memory, for programs and tests that keep none.
#pragma once

#include "core/isa.h"
#include "gi/frame/settings.h"

namespace plumb::frame {

// The settings' parameters; with dynamic meshes, where no spatial receivers are asked for, 1440 of them (IPR table 5.3, VG3).
probes::BakeParams bake_params(const Scene& scene, const Settings& settings);

// Sets settings.bake where the method is probes and it is missing. Throws what probes::BakeGraph throws.
void add_bake(const Scene& scene, Settings& settings, const RunOptions& options = {});

}  // namespace plumb::frame
