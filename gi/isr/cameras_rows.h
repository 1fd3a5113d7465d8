// The kernels of additional cameras over rows of pixels, one specialisation per instruction set (cameras_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/isr/gather_camera_kernel.h"

namespace plumb::isr {

template <Isa isa>
struct CameraRows {
    static void unseen(const UnseenInputsView& in, int first, int last);
    // tiles: of these rows, a byte for every 16 columns, 0 where nothing is computed; null: everywhere.
    static void gather_camera(const GatherCameraInputsView& in, int first, int last, const std::uint8_t* tiles);
};

}  // namespace plumb::isr
