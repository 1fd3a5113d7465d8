#include "core/ssim.h"

#include <algorithm>
#include <vector>

#include "core/host_math.h"
#include "core/parallel.h"
#include "core/separable.h"

namespace plumb::compare {
namespace {

constexpr int radius = 5;

Taps gaussian_window() {
    const double sigma = 1.5;
    Taps taps{radius, Buffer<Lanes>(2 * radius + 1)};
    double weights[2 * radius + 1], sum = 0;
    for (int k = 0; k <= 2 * radius; ++k) {
        weights[k] = host::exp(-double((k - radius) * (k - radius)) / (2 * sigma * sigma));
        sum += weights[k];
    }
    for (int k = 0; k <= 2 * radius; ++k) taps.weights[k] = Lanes{} + weights[k] / sum;
    return taps;
}

}  // namespace

std::optional<double> ssim(const Image<double>& a, const Image<double>& b, double dynamic_range, int threads) {
    const int width = a.width, height = a.height;
    if (width <= 2 * radius || height <= 2 * radius || !(dynamic_range > 0)) return std::nullopt;
    const double c1 = 0.01 * dynamic_range * (0.01 * dynamic_range), c2 = 0.03 * dynamic_range * (0.03 * dynamic_range);

    // Filter a, b, a^2 + b^2 and a b: the index needs the two variances only as their sum. For a = b the numerator and
    // the denominator become the same bits.
    Image<Lanes> moments(width, height);
    for (std::size_t i = 0; i < moments.size(); ++i) {
        const double p = a.texels[i], q = b.texels[i];
        moments.texels[i] = Lanes{p, q, p * p + q * q, p * q};
    }
    const Taps window = gaussian_window();
    filter_rows(moments, window, threads);

    // Sum each row of windows, then the rows in order.
    std::vector<double> row_sums(height, 0.0);
    parallel_bands(height, 16, threads, [&](int first, int last) {
        Buffer<Lanes> filtered(width);
        for (int y = std::max(first, radius); y < std::min(last, height - radius); ++y) {
            filter_columns(moments, window, y, filtered.data());
            for (int x = radius; x < width - radius; ++x) {
                const Lanes m = filtered[x];
                const double mean_squares = m[0] * m[0] + m[1] * m[1], mean_product = m[0] * m[1];
                const double variances = m[2] - mean_squares, covariance = m[3] - mean_product;
                row_sums[y] += (2 * mean_product + c1) * (2 * covariance + c2) /
                               ((mean_squares + c1) * (variances + c2));
            }
        }
    });
    double sum = 0;
    for (const double row : row_sums) sum += row;
    return sum / (double(width - 2 * radius) * double(height - 2 * radius));
}

}  // namespace plumb::compare
