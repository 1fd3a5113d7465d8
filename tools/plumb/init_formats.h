// What the size of a raw file says about its texels, for `plumb validate --init`.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// width and height of a square of so many texels; 0, 0 where there is none.
glm::ivec2 square(std::size_t texels);

// The side that files of these sizes, dumped of a light's map, most likely have: one that all can have, with the largest
// texels; 0 where there is none.
int map_side(const std::vector<std::pair<const Slot*, std::size_t>>& files);

// Fills in what a manifest says about a raw file of that size, dumped of the slot. `frame`: the size of the outputs, or 0, 0;
// `map`: the side of maps, or 0. Returns "", or why nothing fits: "has 7 bytes: ...".
std::string guess_raw(const Slot& slot, std::size_t bytes, glm::ivec2 frame, int map, io::DumpSpec& spec);

}  // namespace plumb::cli
