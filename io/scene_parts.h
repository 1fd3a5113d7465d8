// Parts of a scene file that stand alone. Private to io/.
#pragma once

#include <vector>

#include "core/scene.h"
#include "io/toml_reader.h"

namespace plumb::io {

// [[mesh]]: matrix, or scale, rotate_deg and translate.
glm::dmat4 read_transform(TomlReader& mesh);

// [[light]]; its name must be none of the others'.
Light read_light(TomlReader& reader, const std::vector<Light>& others);

}  // namespace plumb::io
