// The table [stage.uniforms] to be filled in by hand, for `plumb validate --init`.
#pragma once

#include <string>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// Lines of TOML: members that are known or harmless with their value, all others as comments with unit and meaning, and what
// a light's view_proj gives in their place. "" of a stage without a block.
std::string uniforms_stub(const StageBinding& binding, const io::ManifestStage& stage, int map_side);

}  // namespace plumb::cli
