// --set light.2.on=false: switches a light of the scene, by its number, from 1 on in the scene file's order (LRA chapter 8), or its name.
#pragma once

#include "tools/shared/options.h"

namespace plumb::cli {

// Switches the lights that `sets` name; what [[keyframe]] says of them being on is dropped. Throws InputError for another key than
// `on`, another value than true or false, and a light that is not there.
void switch_lights(const std::vector<std::string>& sets, Scene& scene);

// Throws InputError as switch_lights(), and where the scene's light is not as `set` has it: its command does not switch lights.
void check_switched(const Assignment& set, const Scene& scene);

}  // namespace plumb::cli
