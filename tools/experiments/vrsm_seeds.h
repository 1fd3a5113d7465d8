// What seeds scatter, of plumb experiment vrsm: means with their standard errors, and which of them can be told apart.
#pragma once

#include <optional>
#include <vector>

namespace plumb::cli {

// error: of the mean, sqrt(sum (v - mean)^2 / (n (n - 1))); none of one seed.
struct VrsmEstimate {
    std::optional<double> mean, error;
};
// None where some value is none: what is no number of one seed has no mean.
VrsmEstimate vrsm_estimate(const std::vector<std::optional<double>>& of_seeds);

// Whether two means differ by more than two standard errors of their difference, as if they were independent. False where a
// mean or an error is not known, and where the means are equal.
bool told_apart(const VrsmEstimate& a, const VrsmEstimate& b);
// Whether the mean is at most `limit` by more than two standard errors; false where it is not known.
bool told_at_most(const VrsmEstimate& a, double limit);

}  // namespace plumb::cli
