// Where a manifest says that nothing is seen.
#pragma once

#include "io/manifest.h"
#include "tools/plumb/stage_case.h"

namespace plumb::cli {

// Sets the inputs of the frame's size, and the outputs that were packed, to the zeros that stages hold for nothing: a
// packed normal or a biased one always decodes to a direction. Outputs that were dumped as they are stay. Throws
// InputError.
void apply_coverage(const io::ManifestStage& stage, StageCase& out);

}  // namespace plumb::cli
