// What the uniforms of the passes that draw mean.
#pragma once

#include "core/uniform_words.h"

namespace plumb::raster {

std::vector<StageWords> uniform_words();

}  // namespace plumb::raster
