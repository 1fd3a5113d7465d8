// Storing the texels of a reflective shadow map, once per instruction set (rsm_isa.cpp).
#pragma once

#include "core/isa.h"
#include "core/number.h"

namespace plumb::raster {

// The three images, rgba32f, of texels that lie side by side.
struct RsmImages {
    float* position;
    float* normal;
    float* flux;
};

template <Isa isa>
struct RsmRows {
    // Copies texels [first, last) into records of floats.
    static void pack(const RsmImages& images, float* records, std::ptrdiff_t first, std::ptrdiff_t last);
    // Rounds texels [first, last) to halves, in the images and into records of halves.
    static void pack(const RsmImages& images, Half* records, std::ptrdiff_t first, std::ptrdiff_t last);
};

}  // namespace plumb::raster
