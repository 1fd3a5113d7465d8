// Levels of detail of a texture, made on the host before any kernel runs.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/scene.h"

namespace plumb::raster {

// Levels 1 to the last, of 1 x 1 texels; none where the texture has that size. A side is half the one before, rounded
// down, and 1 at least. A texel is the mean of its part of the level before, by area, in linear values (alpha like the
// others, colours not weighted by it). Levels are rounded once, from unrounded ones: to the code whose linear value is
// nearest, of two that are equally near the lower. decode: decode_table().
std::vector<Image<std::uint32_t>> smaller_levels(const Texture& texture, const Buffer<float>& decode);

}  // namespace plumb::raster
