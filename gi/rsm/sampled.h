// The disc gather of a shader that reads the light's map through samplers or has a pattern for each pixel of a tile
// (sampled_kernel.h): the same stage, with one input more.
#pragma once

#include "core/binding.h"

namespace plumb::rsm {

// rsm.disc or rsm.disc_continuous with the input "sampling": the 17 floats of struct Sampling. No device runs it. Null for
// another stage.
const StageBinding* sampled_stage(const std::string& name);
std::vector<std::string> sampled_stages();  // their names
bool is_sampled(const StageBinding& binding);  // of what is named as its twin, that computes something else

}  // namespace plumb::rsm
