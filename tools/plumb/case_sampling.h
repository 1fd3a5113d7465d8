// The words of a manifest for samplers of a light's map, and for patterns that differ over a tile of pixels.
#pragma once

#include "tools/plumb/stage_case.h"

namespace plumb::cli {

// The stage as the manifest's words have it: `binding`, or where there are some of these words gi/rsm/sampled.h's, with its
// input "sampling" in `data`. Throws InputError where they stand at what has no such words.
const StageBinding& sampled_binding(const io::ManifestStage& stage, const StageBinding& binding, StageData& data);

}  // namespace plumb::cli
