// The kernels of gather_kernel.h over rows of pixels, one specialisation per instruction set (gather_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

template <Isa isa, class Component>
struct GatherRows {
    static void disc(const GatherInputsView<Component>& in, int first, int last);
    static void all(const GatherInputsView<Component>& in, int first, int last);  // float only
};

}  // namespace plumb::rsm
