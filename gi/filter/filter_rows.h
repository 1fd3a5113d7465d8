// The kernels of this folder over rows of pixels, one specialisation per instruction set (filter_isa.cpp).
#pragma once

#include <cstddef>

#include "core/isa.h"
#include "gi/filter/blur_kernel.h"
#include "gi/filter/reduce_kernel.h"
#include "gi/filter/upsample_kernel.h"

namespace plumb::filter {

// Which squares of 16 x 16 pixels are computed (raster/covered.h); the others keep what they hold. any null: all.
struct Tiles {
    const std::uint8_t* any = nullptr;  // [rows][across]
    int across = 0;

    const std::uint8_t* row(int y) const { return any ? any + std::ptrdiff_t(y >> 4) * across : nullptr; }
};

// The images around a band of rows, taken apart into planes: a packet then reads its neighbours side by side, where
// fetch4() would collect and transpose them, which takes longer than their weights. Padding stands for what lies beyond
// the border: no surface.
struct BlurPlanes {
    enum : int { red, green, blue, depth, normal_x, normal_y, normal_z, position_x, position_y, position_z, count };
    static constexpr int padding = 16;  // floats before the first pixel and after the last; the largest radius is 16

    float* planes;     // [row][count][stride]: rows first - radius_y .. last + radius_y
    int stride;        // floats
    int first_row;     // of the image: may lie above it

    static int stride_of(int width) { return ((width + 15) & ~15) + 2 * padding; }
    static std::size_t floats(int width, int rows, int radius_y) {
        return std::size_t(rows + 2 * radius_y) * count * std::size_t(stride_of(width));
    }
    float* at(int plane, int y) const {
        return planes + (std::ptrdiff_t(y - first_row) * count + plane) * stride + padding;
    }
};

template <Isa isa>
struct Rows {
    static void reduce(const ReduceInputsView& in, int first, int last);
    static void upsample(const UpsampleInputsView& in, int first, int last, const Tiles& tiles = {});
    // scratch: BlurPlanes::floats() of them, aligned to 64 bytes.
    static void blur(const BlurInputsView& in, int first, int last, float* scratch, const Tiles& tiles = {});
};

}  // namespace plumb::filter
