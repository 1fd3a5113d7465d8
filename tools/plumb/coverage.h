// Where a manifest says that nothing is seen.
#pragma once

#include "io/manifest.h"
#include "tools/plumb/stage_case.h"

namespace plumb::cli {

// Where something is seen, for each pixel: as [stage.coverage] says, else a depth buffer of which positions of the frame are
// made; empty where neither is there. Throws InputError.
std::vector<bool> read_coverage(const io::ManifestStage& stage, const StageBinding& binding, glm::ivec2 expected);

// Where nothing is seen, inputs of the frame's size are the zeros that stages hold for it: a packed normal always decodes to
// a direction. The judge leaves such pixels out. Not so of a stage that draws, whose outputs say what is seen: there packed
// ones are zeros, too, outputs that were dumped as they are stay, and `out.covered` is emptied.
void apply_coverage(const io::ManifestStage& stage, StageCase& out);

}  // namespace plumb::cli
