// The sources of isr.gather and isr.ssao, as a band of receivers reads them.
#pragma once

#include <cstddef>

#include "gi/isr/surface_kernel.h"

namespace plumb::isr {

// The sources that a band of receivers reaches, taken apart into planes: without rotations the pixels of a packet read
// samples that lie side by side, where fetch4() would collect and transpose them; and an area is computed
// once, not by each receiver that reads it. Padding stands for what lies beyond the border: no surface.
struct SourcePlanes {
    enum : int { depth, source_area, normal_x, normal_y, normal_z, red, green, blue, of_gather };
    enum : int { position_x, position_y, position_z, area, of_ssao };  // `area` holds the radius squared
    static constexpr int padding = 16;  // floats before the first pixel and after the last: the widest packet

    float* planes;   // [row][count][stride], then a row of padding
    int count;       // planes: of_gather or of_ssao
    int stride;      // floats
    int first_row;   // of the sources
    int rows;

    static int stride_of(int width) { return ((width + 15) & ~15) + 2 * padding; }
    // The rows that receivers [first, last) reach, within the sources.
    SourcePlanes(const SampleUniforms& u, int count_of_planes, int reach, int first, int last, float* scratch)
        : planes(scratch), count(count_of_planes), stride(stride_of(u.source_width)) {
        const int top = first + u.margin - reach, bottom = last + u.margin + reach;
        first_row = top < 0 ? 0 : top;
        rows = (bottom < u.source_height ? bottom : u.source_height) - first_row;
        if (rows < 0) rows = 0;
    }
    // Floats of scratch memory that any band of that many rows of receivers needs.
    static std::size_t floats(const SampleUniforms& u, int count, int reach, int band) {
        const std::int64_t most = std::int64_t(band) + 2 * std::int64_t(reach);
        const std::int64_t rows = (most < u.source_height ? most : u.source_height) + 1;
        return std::size_t(rows) * std::size_t(count) * std::size_t(stride_of(u.source_width));
    }
    // Plane 0 of source (x, y), x within the padding.
    float* at(int x, int y) const { return planes + std::ptrdiff_t(y - first_row) * count * stride + padding + x; }
    // The same where nothing is.
    float* nothing() const { return planes + std::ptrdiff_t(rows) * count * stride + padding; }
};

}  // namespace plumb::isr
