// blur_kernel.h over rows of pixels, one specialisation per instruction set (blur_isa.cpp).
#pragma once

#include <cstddef>

#include "core/isa.h"
#include "core/kernel_rows.h"
#include "gi/isr/blur_kernel.h"

namespace plumb::isr {

// The images around a band of rows, taken apart into planes: a packet then reads its neighbours side by side. What lies
// beyond the border is in the padding: no surface, or (published) the border's pixel.
struct BlurPlanes {
    enum : int { red, green, blue, open, covered, normal_x, normal_y, normal_z, depth, count };
    static constexpr int padding = 32;  // floats before the first pixel and after the last; the largest radius is 32

    float* planes;   // [row][count][stride]: rows first .. last, and of a vertical blur a radius before and after
    int stride;      // floats
    int first_row;   // of the image: may lie above it

    static int stride_of(int width) { return ((width + 15) & ~15) + 2 * padding; }
    static int halo(const BlurUniforms& u) { return u.vertical != 0 ? u.radius : 0; }
    static std::size_t floats(const BlurUniforms& u, int rows) {
        return std::size_t(rows + 2 * halo(u)) * count * std::size_t(stride_of(u.width));
    }
    float* at(int plane, int y) const {
        return planes + (std::ptrdiff_t(y - first_row) * count + plane) * stride + padding;
    }
};

template <Isa isa>
struct BlurRows {
    // scratch: BlurPlanes::floats() of them, aligned to 64 bytes.
    static void blur(const BlurInputsView& in, int first, int last, float* scratch, const Tiles& tiles = {});
};

}  // namespace plumb::isr
