// The kernels of this folder over rows of pixels, one specialisation per instruction set (direct_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/shadow_kernel.h"

namespace plumb::direct {

template <Isa isa>
struct Rows {
    static void shadow(const ShadowInputsView& in, int first, int last);
    static void direct(const DirectInputsView& in, int first, int last);
};

}  // namespace plumb::direct
