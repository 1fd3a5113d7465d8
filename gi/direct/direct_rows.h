// The kernels of this folder over rows of pixels, one specialisation per instruction set (direct_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/log_blur_kernel.h"
#include "gi/direct/shadow_kernel.h"

namespace plumb::direct {

template <Isa isa>
struct Rows {
    // tiles: which columns to shade, as shade_rows() takes them (gi/shade_rows.h).
    static void shadow(const ShadowInputsView& in, int first, int last, const std::uint8_t* tiles = nullptr);
    static void direct(const DirectInputsView& in, int first, int last, const std::uint8_t* tiles = nullptr);
    static void log_blur(const LogBlurInputsView& in, int first, int last);
};

}  // namespace plumb::direct
