// Random numbers: integer hashes of (pixel, sample, seed), the same in C++, in packets of pixels and in GLSL
// (core/hash.glsl).
//
// Templates over the index type I: std::int32_t or the wide indices of core/wide.h. They use + * ^ << and
// shift_right(I, int), the shift that brings in zeros; sums and products wrap.
//
// Sources: O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number
// Generation" (the RXS-M-XS output permutation); Jarzynski and Olano 2020, "Hash Functions for GPU Rendering" (pcg,
// pcg3d).
#pragma once

#include <cstdint>

#include "core/number.h"

namespace plumb {

// One step of the generator and its output permutation. O'Neill shifts by a count that the state gives; since packets
// shift all lanes alike, the count is picked by its four bits.
template <class I>
PLUMB_INLINE I pcg(I input) {
    const I state = input * I(747796405) + I(std::int32_t(2891336453u));
    // state >> ((state >> 28) + 4), by the bits of the count from the highest
    I shifted = shift_right(state, 4);
    for (int bit = 31; bit >= 28; --bit) {
        const I set = I(0) - (shift_right(state, bit) & I(1));  // all ones where the bit is set
        shifted = shifted ^ ((shifted ^ shift_right(shifted, 1 << (bit - 28))) & set);
    }
    const I word = (shifted ^ state) * I(277803737);
    return shift_right(word, 22) ^ word;
}

template <class I>
struct Hash3 {
    I x, y, z;
};

// Three hashed words of three.
template <class I>
PLUMB_INLINE Hash3<I> pcg3d(I x, I y, I z) {
    const I multiplier(1664525), increment(1013904223);
    x = x * multiplier + increment, y = y * multiplier + increment, z = z * multiplier + increment;
    x = x + y * z, y = y + z * x, z = z + x * y;
    x = x ^ shift_right(x, 16), y = y ^ shift_right(y, 16), z = z ^ shift_right(z, 16);
    x = x + y * z, y = y + z * x, z = z + x * y;
    return {x, y, z};
}

// Three words for a sample of a pixel. The seed is hashed into the sample, so that neither's small values meet.
template <class I>
PLUMB_INLINE Hash3<I> pixel_hash(I pixel_x, I pixel_y, I sample, I seed) {
    return pcg3d(pixel_x, pixel_y, pcg(sample + pcg(seed)));
}

// The upper 24 bits as a float in [0, 1), exactly.
template <class F>
PLUMB_INLINE F unit_float(index_t<F> hash) {
    return number<F>::from_index(shift_right(hash, 8)) * F(0x1p-24f);
}

}  // namespace plumb
