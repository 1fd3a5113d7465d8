// The words of a manifest for samplers of a light's map, and for patterns that differ over a tile of pixels.
#pragma once

#include "tools/plumb/stage_case.h"

namespace plumb::cli {

// The stage as the manifest's words have it: `binding`, or where there are some of these words gi/rsm/sampled.h's, with its
// input "sampling" in `data`. Throws InputError where they stand at what has no such words.
const StageBinding& sampled_binding(const io::ManifestStage& stage, const StageBinding& binding, const DeviceProfile& profile,
                                    StageData& data);

// Whether the shader makes normals unit once its sampler has filtered them, and not texel by texel.
bool is_unit_once_filtered(const io::DumpSpec& spec);

}  // namespace plumb::cli
