// EXR with words in its header: what the numbers are, and in what unit.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "io/image_file.h"

namespace plumb::io {

using Attributes = std::vector<std::pair<std::string, std::string>>;  // {"unit", "W/m2"}

void write_exr(const std::string& path, int width, int height, const std::vector<Layer>& layers, const Attributes& attributes);

}  // namespace plumb::io
