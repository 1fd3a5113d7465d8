// What a reader promises of what it returns: every number finite, every index in range.
#pragma once

#include <vector>

#include "core/scene.h"

namespace plumb::fuzz {

// Throws std::logic_error, which no target catches, for a model that is not whole and finite.
void require_whole(const Mesh& mesh, const std::vector<Material>& materials, const std::vector<Texture>& textures);

}  // namespace plumb::fuzz
