// Scenes from files: TOML as io/README.md lists its keys, or a bare .obj.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

// `method_tables` are the tables whose keys are passed on as Scene::settings ("rsm", "shadow", ...). What the file
// leaves open is chosen and said in Scene::notes. Scene::name is `path`. Throws InputError with file, line and cause.
Scene load_scene(const std::string& path, const std::vector<std::string>& method_tables);

}  // namespace plumb::io
