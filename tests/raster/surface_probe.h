// surface() and passes_alpha() over a list of points, compiled for every instruction set.
#pragma once

#include "core/isa.h"
#include "raster/surface_kernel.h"

namespace plumb::raster {

struct SurfaceProbe {
    SurfaceArgs surfaces;
    int count;                    // a multiple of 16
    const std::int32_t* triangle;
    const float* barycentrics;    // [count][2]
    float* out;                   // [count][16]: position, 0; normal, 0; albedo, 0; emission, 1 where alpha passes
};

template <Isa isa>
void probe_surfaces(const SurfaceProbe& in);

}  // namespace plumb::raster
