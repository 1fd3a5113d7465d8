// What each texel of a hemicube weighs: the share of a diffuse receiver's irradiance that comes through it (HEM 4.5.3).
#pragma once

#include <vector>

namespace plumb::radiosity {

enum class Weights : int {
    exact,      // the integral over the texel: sums to 1
    centre,     // its value at the texel's centre times the area (raster/hemicube.h): sums to 1 + 1.3e-4 at 64 pixels
    published,  // HEM (5.5), (5.7): cos theta times one cosine of the face where three are due, scaled to sum to 1
};

// Of a hemicube `size` texels across, even, 2 to 4096: the top's rows (size x size), then those of the sides u, -u, t,
// -t (size / 2 rows of size each), in the order of raster/hemicube.h. Throws InputError for other sizes.
std::vector<double> texel_weights(int size, Weights weights);

// The sum of the multiplier maps (5.5), (5.7) as they are printed, which `published` divides by: 4,977 at 64 pixels.
// differs: the thesis does not say by what its sums are divided; unscaled, and times a texel's area, they are 4.86.
double published_sum(int size);

}  // namespace plumb::radiosity
