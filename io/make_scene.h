// Procedural scenes as files: the same bytes on every machine.
#pragma once

#include <string>
#include <vector>

namespace plumb::io {

std::vector<std::string> scene_names();

// Writes the scene's files into the folder, which is made if it is not there, and returns the path of its TOML file.
// Throws InputError for an unknown name (naming the nearest) and for a folder that cannot be written.
std::string make_scene(const std::string& name, const std::string& folder);

}  // namespace plumb::io
