// What a shader does with a stage's result before it writes it, as the manifest says: times numbers and images, held to a
// range.
#pragma once

#include "tools/plumb/stage_case.h"

namespace plumb::cli {

// The stage as the manifest's words on its outputs have it: `binding`, or where there are some a stage that does the same
// and multiplies, with its inputs "<output>.scale", "<output>.factor" (of several their product) and "<output>.clamp" in
// `data`. Throws InputError where they stand at an output that is no image of floats, or a factor has another size.
const StageBinding& formed_binding(const io::ManifestStage& stage, const StageBinding& binding, const Precision& precision,
                                   StageData& data);

// Of what is named as its twin, that computes something else.
bool is_formed(const StageBinding& binding);

}  // namespace plumb::cli
