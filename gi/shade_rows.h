// The loop that every image kernel shares: rows of pixels, a packet of lanes at a time. Only kernel files include it.
#pragma once

#include "core/tap.h"
#include "core/wide.h"

namespace plumb {

// A kernel's value as a texel.
template <class F>
PLUMB_INLINE vec4<F> texel_of(const vec3<F>& value, F w) {
    return vec4<F>(value, w);
}
template <class F>
PLUMB_INLINE vec4<F> texel_of(const vec4<F>& value, F) {
    return value;
}

// Calls kernel(px, py, tap) for the pixels of rows [first, last) of an image `width` pixels wide and stores its vec3 in
// `out` (rgba32f, w = `w`), or its vec4. Lanes beyond the row repeat its last pixel and are not stored. Packets go down the columns of
// the band, so that a tile about as high as it is wide shares what it reads. tiles: of these rows, a byte for every 16
// columns, 0 where nothing is called and stored (raster/covered.h); null: everywhere.
template <class Kernel>
PLUMB_INLINE void shade_rows(int width, int first, int last, const std::uint8_t* tiles, float* out, float w,
                             Kernel kernel) {
    using F = PLUMB_ISA::Real;
    using N = number<F>;
    using I = index_t<F>;
    for (int x = 0; x < width; x += N::width) {
        if (tiles && !tiles[x >> 4]) continue;
        const I px = min(N::iota(x), I(width - 1));
        for (int y = first; y < last; ++y) {
            NoTap tap;
            N::store4(out, I(y * width) + px, texel_of(kernel(px, I(y), tap), F(w)), N::iota(x) < I(width));
        }
    }
}

// The same for a kernel whose value is one number, stored in an r32f image.
template <class Kernel>
PLUMB_INLINE void shade_rows_scalar(int width, int first, int last, const std::uint8_t* tiles, float* out,
                                    Kernel kernel) {
    using F = PLUMB_ISA::Real;
    using N = number<F>;
    using I = index_t<F>;
    for (int x = 0; x < width; x += N::width) {
        if (tiles && !tiles[x >> 4]) continue;
        const I px = min(N::iota(x), I(width - 1));
        for (int y = first; y < last; ++y) {
            NoTap tap;
            N::store(out, I(y * width) + px, kernel(px, I(y), tap), N::iota(x) < I(width));
        }
    }
}

}  // namespace plumb
