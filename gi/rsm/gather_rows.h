// The kernels of gather_kernel.h over rows of pixels, one specialisation per instruction set (gather_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

template <Isa isa, class Component>
struct GatherRows {
    // tiles: which columns to shade, as shade_rows() takes them (gi/shade_rows.h).
    static void disc(const GatherInputsView<Component>& in, int first, int last, const std::uint8_t* tiles = nullptr);
    static void all(const GatherInputsView<Component>& in, int first, int last,
                    const std::uint8_t* tiles = nullptr);  // float only
};

}  // namespace plumb::rsm
