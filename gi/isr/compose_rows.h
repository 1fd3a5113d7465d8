// compose_kernel.h over rows of pixels, one specialisation per instruction set (compose_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/isr/compose_kernel.h"

namespace plumb::isr {

template <Isa isa>
struct ComposeRows {
    static void compose(const ComposeInputsView& in, int first, int last);
};

}  // namespace plumb::isr
