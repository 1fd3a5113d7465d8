// FLIP: how different two pictures look to a person who alternates between them.
//   Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020,
//   "FLIP: A Difference Evaluator for Alternating Images"
//   Andersson, Nilsson, Shirley, Akenine-Moller 2021,
//   "Visualizing Errors in Rendered High Dynamic Range Images"
// Computed in double. Exact where that matters: equal pictures give 0, and LDR-FLIP of swapped pictures the same bits.
#pragma once

#include <glm/glm.hpp>

#include "core/image.h"

namespace plumb::compare {

// A screen 0.7 m wide of 3840 pixels, seen from 0.7 m: 3840 * pi / 180.
inline constexpr double default_pixels_per_degree = 67.02064327658225;

// The error of every pixel, 0 (looks equal) to 1; the mean in row order.
struct FlipResult {
    Image1 map;
    double mean = 0;
    double start_exposure = 0, stop_exposure = 0;  // log2 of the first and last factor; HDR-FLIP only
    int exposures = 1;
};

// LDR-FLIP of linear RGB with Rec. 709 primaries; values outside 0..1 are clamped.
FlipResult flip_ldr(const Image<glm::dvec3>& reference, const Image<glm::dvec3>& test, double pixels_per_degree,
                    int threads);

// HDR-FLIP: the largest LDR-FLIP of each pixel over exposures about a stop apart, after the tone curve "ACES fit".
// The exposures follow from the reference, so HDR-FLIP is not symmetric; negative radiance is clamped to 0.
// differs: where the median luminance of the reference is 0, and the published stop exposure infinite, the median of
// the positive luminances takes its place; for a black reference the one exposure is 0.
FlipResult flip_hdr(const Image<glm::dvec3>& reference, const Image<glm::dvec3>& test, double pixels_per_degree,
                    int threads);

// The transfer function of IEC 61966-2-1, from encoded 0..1 to linear 0..1.
double srgb_to_linear(double encoded);

}  // namespace plumb::compare
