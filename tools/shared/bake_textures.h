// The data textures of IPR 3.2.5, as files: what a GPU binds, one by one.
#pragma once

#include "gi/probes/bake.h"
#include "tools/shared/outputs.h"

namespace plumb::cli {

// <name>.bin, the bytes of the image row by row, <name>.npy, and README.txt, which says format, size and meaning of each.
void write_textures(const probes::Bake& bake, Outputs& outputs);

}  // namespace plumb::cli
