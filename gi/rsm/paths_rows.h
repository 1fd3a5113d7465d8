// The kernel of paths_kernel.h over rows of pixels, one specialisation per instruction set (paths_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/rsm/paths_kernel.h"

namespace plumb::rsm {

template <Isa isa, class Component>
struct PathsRows {
    // tiles: which columns to shade, as shade_rows() takes them (gi/shade_rows.h).
    static void paths(const PathsInputsView<Component>& in, int first, int last, const std::uint8_t* tiles = nullptr);
};

}  // namespace plumb::rsm
