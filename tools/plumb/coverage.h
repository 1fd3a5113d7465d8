// Where a manifest says that nothing is seen.
#pragma once

#include "io/manifest.h"
#include "tools/plumb/stage_case.h"

namespace plumb::cli {

// Where something is seen, for each pixel; empty where the manifest does not say it. Throws InputError.
std::vector<bool> read_coverage(const io::ManifestStage& stage, glm::ivec2 expected);

// Of `out.covered`: sets the inputs of the frame's size, and the outputs that were packed, to the zeros that stages hold for nothing: a
// packed normal or a biased one always decodes to a direction. Outputs that were dumped as they are stay.
void apply_coverage(const io::ManifestStage& stage, StageCase& out);

}  // namespace plumb::cli
