// Separable filters over four quantities of a pixel at once: what SSIM and FLIP are made of. The border repeats the
// outermost pixel. Every output is one sum over the taps in ascending order, so its bits depend on nothing else.
#pragma once

#include "core/image.h"

namespace plumb::compare {

// Four doubles that the compiler adds and multiplies lane by lane.
using Lanes = double __attribute__((vector_size(32)));

// weights[k] belongs to the offset k - radius; 2 radius + 1 of them, one weight a lane.
struct Taps {
    int radius = 0;
    Buffer<Lanes> weights;
};

// Convolves every row of the picture, in place.
void filter_rows(Image<Lanes>& picture, const Taps& taps, int threads);

// Convolves the columns, for the one row y; out holds picture.width values. Band by band, so that no second picture is
// needed: the caller turns each filtered row into what it is after.
void filter_columns(const Image<Lanes>& picture, const Taps& taps, int y, Lanes* out);

}  // namespace plumb::compare
