// Dumped numbers in the type and shape that a slot of a stage has.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// [height][width][channels], without the last extent where the slot has one channel; [layer][height][width] of an array
// of images that lie one below the other; a buffer keeps its shape. `size` is that of the stage's outputs. What was
// assumed is added to `notes`. Throws InputError at `place`.
Array input_array(const Slot& slot, io::DumpedImage dump, glm::ivec2 size, const std::string& place,
                  std::vector<std::string>& notes);
// An output likewise, and its rounding.
void fit_output(const Slot& slot, io::DumpedImage& dump, glm::ivec2 size, const std::string& place);

// Pixels of what was dumped: width, height.
glm::ivec2 image_size(const Array& array, const std::string& place);

// All elements as double.
std::vector<double> numbers(const Array& array, const std::string& place);

// In place of the array of that name, if there is one.
void replace(Bundle& bundle, Array array);

}  // namespace plumb::cli
