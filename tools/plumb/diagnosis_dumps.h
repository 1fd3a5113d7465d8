// Guesses at what a shader read: another dump of the manifest, as of another frame.
#pragma once

#include <vector>

#include "gi/parity/hypothesis.h"
#include "io/manifest.h"

namespace plumb::cli {

// Of each input those images that other stages read or wrote under its name, in files of their own; a file is read when
// its guess is tried. All arguments have to outlive what is returned.
std::vector<parity::Hypothesis> other_dumps(const io::Manifest& manifest, const io::ManifestStage& stage,
                                            const StageBinding& binding);

}  // namespace plumb::cli
