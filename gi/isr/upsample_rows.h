// upsample_kernel.h over rows of pixels, one specialisation per instruction set (upsample_isa.cpp).
#pragma once

#include <cstddef>

#include "core/isa.h"
#include "core/kernel_rows.h"
#include "gi/isr/upsample_kernel.h"

namespace plumb::isr {

// The coarse rows that a band of full rows lies between, taken apart into planes of full width: at column x the coarse
// pixel before x, and so at column x + 2 the one after it. Each is fetched once for the four rows that read it.
struct UpsamplePlanes {
    enum : int { red, green, blue, open, covered, depth, count };

    float* planes;      // [row][count][stride]: coarse rows first_row ..
    int stride;         // floats
    int first_row;

    static int stride_of(int width) { return ((width + 2 + 15) & ~15) + 16; }
    static std::size_t floats(int width, int rows) {
        return std::size_t(rows / 2 + 2) * count * std::size_t(stride_of(width));
    }
    float* at(int plane, int y) const { return planes + (std::ptrdiff_t(y - first_row) * count + plane) * stride; }
};

template <Isa isa>
struct UpsampleRows {
    // scratch: UpsamplePlanes::floats() of them, aligned to 64 bytes.
    static void upsample(const UpsampleInputsView& in, int first, int last, float* scratch, const Tiles& tiles = {});
};

}  // namespace plumb::isr
