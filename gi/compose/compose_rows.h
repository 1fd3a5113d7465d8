// The kernels of this folder over rows of pixels, one specialisation per instruction set (compose_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/compose/compose_kernel.h"
#include "gi/compose/tonemap_kernel.h"

namespace plumb::compose {

template <Isa isa>
struct Rows {
    static void compose(const ComposeInputsView& in, int first, int last);
    static void tonemap(const TonemapInputsView& in, int first, int last);
};

}  // namespace plumb::compose
