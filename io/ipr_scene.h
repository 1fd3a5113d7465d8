// The thesis' `.scene` files (IPR figure A.1) as scene files of ours; README.md has what each command becomes.
#pragma once

#include <string>

namespace plumb::io {

// TOML of the same. static_scene: the mesh file that stands for the thesis' precomputed !SSF, whose format it does not print.
// Names of files stay as they are. Throws InputError with the line for an unknown command (naming the nearest), numbers that
// are missing, too many or none, what comes twice, and !DOBJ_... without a !DOBJ.
std::string ipr_scene_toml(const std::string& path, const std::string& text, const std::string& static_scene);

}  // namespace plumb::io
