#include "tools/experiments/vrsm_seeds.h"

#include <algorithm>
#include <cmath>

namespace plumb::cli {

VrsmEstimate vrsm_estimate(const std::vector<std::optional<double>>& of_seeds) {
    VrsmEstimate e;
    const double n = double(of_seeds.size());
    if (of_seeds.empty() || !std::all_of(of_seeds.begin(), of_seeds.end(), [](const auto& v) { return v && std::isfinite(*v); }))
        return e;
    // From the first value: equal ones have no spread, though their mean may round.
    double sum = 0, squares = 0;
    for (const auto& v : of_seeds) sum += *v - *of_seeds.front();
    const double shift = sum / n;
    for (const auto& v : of_seeds) squares += std::pow(*v - *of_seeds.front() - shift, 2);
    e.mean = *of_seeds.front() + shift;
    if (n > 1) e.error = std::sqrt(squares / (n * (n - 1)));
    return e;
}

bool told_apart(const VrsmEstimate& a, const VrsmEstimate& b) {
    if (!a.mean || !b.mean || !a.error || !b.error) return false;
    return std::abs(*a.mean - *b.mean) > 2 * std::sqrt(*a.error * *a.error + *b.error * *b.error);
}

bool told_at_most(const VrsmEstimate& a, double limit) {
    return a.mean && a.error && *a.mean + 2 * *a.error <= limit;
}

}  // namespace plumb::cli
