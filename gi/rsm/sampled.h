// The disc gather of a shader that reads the light's map through samplers or has a pattern for each pixel of a tile
// (sampled_kernel.h): the same stage, with one input more.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::rsm {

// Samplers have fractions of at least so many bits, and no more is told of how they round (Vulkan 1.3, 16.8; limits:
// subTexelPrecisionBits, of which desktop devices have 8). Some have floats' (DeviceProfile::bilinear_weight_bits).
inline constexpr float coarse_fraction = 1.0f / 256, fine_fraction = 0x1p-22f;

// rsm.disc or rsm.disc_continuous with the input "sampling": the floats of struct Sampling. No device runs it. Null for
// another stage.
const StageBinding* sampled_stage(const std::string& name);
std::vector<std::string> sampled_stages();  // their names
// What a shader may do otherwise with its samplers, by what is said of it: changes of "sampling", false where it is so already.
struct SamplingGuess {
    std::string text;
    std::function<bool(StageData&)> change;
};
std::vector<SamplingGuess> sampling_guesses();
bool is_sampled(const StageBinding& binding);  // of what is named as its twin, that computes something else

}  // namespace plumb::rsm
