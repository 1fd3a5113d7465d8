// A manifest to start from, guessed from the names of the dumps in a folder.
#pragma once

#include <string>

namespace plumb::cli {

// Writes folder/manifest.toml, never over one that is there; says what was guessed and what was not. Returns an exit
// code. Throws InputError.
int init_manifest(const std::string& folder, bool json);

}  // namespace plumb::cli
