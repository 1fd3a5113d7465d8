// The kernels over rows of pixels, one specialisation per instruction set (resolve_isa.cpp). Pixels that see nothing
// become 0.
#pragma once

#include "core/isa.h"
#include "raster/gbuffer_kernel.h"
#include "raster/rsm_kernel.h"

namespace plumb::raster {

template <Isa isa>
struct ResolveRows {
    static void gbuffer(const GBufferArgs& in, int first, int last);
    static void rsm(const RsmArgs& in, int first, int last, const RsmStore& store = {});
};

}  // namespace plumb::raster
