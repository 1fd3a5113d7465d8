// The sources of isr.gather and isr.ssao, as packets of receivers read them.
#pragma once

#include <cstddef>

#include "gi/isr/surface_kernel.h"

namespace plumb::isr {

// The sources taken apart into planes, once for all receivers. A packet is receivers of one rotation, so that their samples lie
// as far apart as they do: side by side, or where a tile deals out rotations every tile-th pixel of a row. Such pixels are kept
// side by side, each column of the tile by itself: a sample of a packet is a load, where fetch4() would collect and transpose,
// and an area is computed once, not by each receiver that reads it. Padding stands for what lies beyond the border: no
// surface. (Segovia et al. 2006, Non-interleaved deferred shading of interleaved sample patterns, split receivers so.)
struct SourcePlanes {
    enum : int { depth, source_area, normal_x, normal_y, normal_z, red, green, blue, of_gather };
    enum : int { position_x, position_y, position_z, area, of_ssao };  // `area` holds the radius squared
    static constexpr int padding = 16;  // floats before the first pixel and after the last: the widest packet

    float* planes;  // [height][step][count][stride], then [count][stride] where nothing is
    int count;      // planes: of_gather or of_ssao
    int step;       // pixels from one lane's sample to the next lane's, a power of two
    int shift;      // its logarithm
    int stride;     // floats
    int width, height;

    // Whether packets of one rotation are had; else samples are fetched.
    static bool apply(const SampleUniforms& u) { return u.rotations == 1 || u.tile != 0; }
    static int step_of(const SampleUniforms& u) { return u.tile != 0 ? u.tile : 1; }
    static int stride_of(const SampleUniforms& u) {
        const int step = step_of(u), pixels = (u.source_width + step - 1) / step;
        return ((pixels + 15) & ~15) + 2 * padding;
    }
    static std::size_t floats(const SampleUniforms& u, int count) {
        if (!apply(u)) return 0;
        return (std::size_t(u.source_height) * std::size_t(step_of(u)) + 1) * std::size_t(count) * std::size_t(stride_of(u));
    }

    SourcePlanes(const SampleUniforms& u, int count_of_planes, float* shared)
        : planes(shared), count(count_of_planes), step(step_of(u)), shift(0), stride(stride_of(u)), width(u.source_width),
          height(u.source_height) {
        while (1 << shift < step) ++shift;
    }
    // Plane 0 of source (x, y), x within the padding.
    float* at(int x, int y) const {
        const std::ptrdiff_t row = std::ptrdiff_t(y) * step + (x & (step - 1));
        return planes + row * count * stride + padding + (x >> shift);
    }
    // The same where nothing is.
    float* nothing() const { return planes + std::ptrdiff_t(height) * step * count * stride + padding; }
    // The first of `lanes` sources, each `step` after the other: nothing() where none of them exists.
    float* first_of(int x, int y, int lanes) const {
        const bool inside = y >= 0 && y < height && (x >> shift) > -lanes && x < width;
        return inside ? at(x, y) : nothing();
    }
};

}  // namespace plumb::isr
