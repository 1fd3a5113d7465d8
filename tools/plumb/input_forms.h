// What an input goes through once it is decoded, as the manifest says: a position out of a depth buffer, a matrix, factors,
// unit length. A device does the same in float, so the result has a bound.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"
#include "core/device_profile.h"
#include "io/manifest.h"

namespace plumb::cli {

// Makes of the dump of that slot what the stage reads. Returns how far a device's own numbers may be from it, f32 of the
// dump's shape; empty where a device reads it as it is. `covered`: where something is seen, of images of the frame's size;
// or empty. Throws InputError at `place`.
Array form_input(const io::DumpSpec& spec, const Slot& slot, const Precision& precision,
                 const std::vector<bool>& covered, const std::string& place, io::DumpedImage& dump,
                 std::vector<std::string>& notes);

}  // namespace plumb::cli
