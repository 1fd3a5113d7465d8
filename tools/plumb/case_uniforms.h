// The uniform block of a stage of a manifest: from its file or its members, from views, and from what is harmless.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// The block from its file or the scene's, members by name over it, and what the stage's size gives. Throws InputError.
void set_uniforms(const io::ManifestStage& stage, const StageBinding& binding, StageData& data);

// Once inputs are there: what the manifest's views give; and where there is neither a file nor a scene (`whole`) what is
// harmless, which is noted. Throws InputError that names the members that are missing. `pattern`: it has set its members.
void complete_uniforms(const io::ManifestStage& stage, const StageBinding& binding, bool whole, bool pattern,
                       StageData& data, std::vector<std::string>& notes);

}  // namespace plumb::cli
