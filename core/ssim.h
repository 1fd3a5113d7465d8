// Wang, Bovik, Sheikh, Simoncelli 2004, "Image Quality Assessment: From Error Visibility to Structural Similarity".
#pragma once

#include <optional>

#include "core/image.h"

namespace plumb::compare {

// The mean of their SSIM index over all windows that lie whole inside the picture: 11 x 11, Gaussian of sigma 1.5,
// K1 = 0.01, K2 = 0.03, at full resolution. dynamic_range is L, the span of the values. Symmetric in a and b; 1 for
// equal pictures. None where no window fits (below 11 x 11) or where L is not positive: the constants that keep the
// index from 0/0 vanish with it.
std::optional<double> ssim(const Image<double>& a, const Image<double>& b, double dynamic_range, int threads);

}  // namespace plumb::compare
