// Sample points for paths: pairs of numbers that cover the unit square evenly over the samples of a round, and differ
// from pixel to pixel and round to round as random ones do.
//
// A pair is Sobol's (0, 2)-sequence with its order and both its coordinates scrambled by Owen's nested permutations
// (Owen 1995), which a hash of the digits stands for (Laine and Karras 2011; the constants and the order of steps are
// Burley's, 2020, "Practical Hash-based Owen Scrambling"). Each pair of dimensions has its own scrambles, so that pairs
// are independent of each other; a round's mean is unbiased, and rounds are independent.
#pragma once

#include "core/hash.h"
#include "core/number.h"

namespace plumb::reference {

template <class I>
PLUMB_INLINE I reverse_bits(I x) {
    x = (x << 16) | shift_right(x, 16);
    x = ((x & I(0x00ff00ff)) << 8) | (shift_right(x, 8) & I(0x00ff00ff));
    x = ((x & I(0x0f0f0f0f)) << 4) | (shift_right(x, 4) & I(0x0f0f0f0f));
    x = ((x & I(0x33333333)) << 2) | (shift_right(x, 2) & I(0x33333333));
    return ((x & I(0x55555555)) << 1) | (shift_right(x, 1) & I(0x55555555));
}

// Owen's permutation of the binary digits, the first digit in the lowest bit: a bit is flipped by a hash of those below
// it.
template <class I>
PLUMB_INLINE I scramble_digits(I x, I seed) {
    x = x + seed;
    x = x ^ (x * I(0x6c50b47c));
    x = x ^ (x * I(std::int32_t(0xb82f1e52u)));
    x = x ^ (x * I(std::int32_t(0xc7afe638u)));
    return x ^ (x * I(std::int32_t(0x8d22f6e6u)));
}

// The digits of the second coordinate of Sobol's point of that index, the first digit in the lowest bit. Digit j is the
// sum, modulo 2, of the index's bits k with binomial(k, j) odd: those whose k has every bit of j (Lucas).
template <class I>
PLUMB_INLINE I sobol_digits(I index) {
    index = index ^ (shift_right(index, 1) & I(0x55555555));
    index = index ^ (shift_right(index, 2) & I(0x33333333));
    index = index ^ (shift_right(index, 4) & I(0x0f0f0f0f));
    index = index ^ (shift_right(index, 8) & I(0x00ff00ff));
    return index ^ (shift_right(index, 16) & I(0x0000ffff));
}

// What a path's numbers depend on: pixel and round by `key`, the sample's number in its round, and the dimension.
template <class F>
struct Sampler {
    using I = index_t<F>;
    Hash3<I> key;    // of pixel, round and seed
    I index_digits;  // the sample's number, bits reversed

    static PLUMB_INLINE Sampler start(I pixel_x, I pixel_y, I round, I seed, I sample) {
        return {pixel_hash(pixel_x, pixel_y, round, seed), reverse_bits(sample)};
    }

    // Three seeds for a pair of dimensions.
    PLUMB_INLINE Hash3<I> seeds(I dimension) const {
        return pcg3d(key.x + dimension * I(std::int32_t(0x9e3779b9u)), key.y, key.z);
    }

    // Two numbers in [0, 1).
    PLUMB_INLINE vec2<F> pair(I dimension) const {
        const Hash3<I> seed = seeds(dimension);
        const I index = reverse_bits(scramble_digits(index_digits, seed.x));
        return {unit_float<F>(reverse_bits(scramble_digits(index, seed.y))),
                unit_float<F>(reverse_bits(scramble_digits(sobol_digits(index), seed.z)))};
    }

    // Three numbers in [0, 1) with no order among the samples.
    PLUMB_INLINE vec3<F> random(I dimension) const {
        const Hash3<I> seed = seeds(dimension);
        const Hash3<I> h = pcg3d(seed.x, seed.y, seed.z + index_digits);
        return {unit_float<F>(h.x), unit_float<F>(h.y), unit_float<F>(h.z)};
    }
};

}  // namespace plumb::reference
