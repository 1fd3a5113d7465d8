// The metrics that treat every value alike. Sums are of doubles: along each row, then over the rows in order.
#pragma once

#include <cstdint>

#include "core/compare.h"

namespace plumb::compare {

// The number of steps from one float to the other along the ordered floats: 0 from -0 to +0, 1 between neighbours,
// saturated if one of them is not finite.
std::uint32_t ulp_distance(float a, float b);

// Fills pixels, nonfinite, differing, max_ulp and equal, which have a meaning whatever the values are.
void count_differences(const Picture& a, const Picture& b, int threads, Report& report);

// Fills mean_error, rmse, rel_mse, psnr, pearson, max_absolute and worst. All values are finite; peak <= 0 means that
// there is none.
void sum_differences(const Picture& a, const Picture& b, double peak, int threads, Report& report);

}  // namespace plumb::compare
