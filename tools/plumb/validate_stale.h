// Whether what a manifest of an export names is what was exported, told by content.
#pragma once

#include <string>
#include <vector>

#include "io/manifest.h"

namespace plumb::cli {

// Names the stage's inputs and uniform block that have changed since they were exported; "" where none has, and of files
// that the export did not write. `notes` takes what does not decide: an expected output that has changed, an output that
// is as `plumb export --device` left it, one that is older than its export by its time.
std::string find_stale(const io::Manifest& manifest, const io::ManifestStage& stage, std::vector<std::string>& notes);

}  // namespace plumb::cli
