// How much memory plumb export and plumb validate take, told before they take it, from the sizes of what stages bind.
#pragma once

#include <cstdint>
#include <vector>

#include "gi/frame/frame_graph.h"
#include "io/manifest.h"

namespace plumb::cli {

// The frame with all that it holds, and beside it a copy of the largest dispatch's inputs with its outputs: as our kernels make
// them, as a device does, and what fills out/; and a tenth for stages without a twin, buffers and the scene, of which nothing is known.
std::uint64_t bytes_to_export(const frame::FrameGraph& graph, const std::vector<frame::PlannedStage>& stages, int lights);

// The largest stage's files as they are read, its inputs and outputs as numbers, ours beside them, and of all stages their maps of
// verdicts, with --html or -o their pictures. Of files that say no size until they are read (EXR) the stage's counts.
std::uint64_t bytes_to_validate(const io::Manifest& manifest, bool pictures);

}  // namespace plumb::cli
