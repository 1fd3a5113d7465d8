// The Cornell box, from its published geometry and measurements. Private to io/.
#pragma once

#include <string>

namespace plumb::io {

std::string cornell_obj();   // metres; floor at y = 0, open towards +z
std::string cornell_mtl();   // named "cornell.mtl"
std::string cornell_toml();  // a scene of these two

}  // namespace plumb::io
