#include "core/compare_metrics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/host_math.h"
#include "core/parallel.h"

namespace plumb::compare {
namespace {

// Places a float among the integers so that neighbours are neighbours, and both zeros are 0.
std::int64_t ordered(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    const std::int64_t magnitude = bits & 0x7fffffffu;
    return bits >> 31 ? -magnitude : magnitude;
}

// Calls body(y, row of a, row of b, values in a row) for every row; the rows of a band one after the other.
template <class Body>
void for_each_row(const Picture& a, const Picture& b, int threads, const Body& body) {
    const std::size_t values = std::size_t(a.width) * a.channels.size();
    parallel_bands(a.height, 16, threads, [&](int first, int last) {
        for (int y = first; y < last; ++y) body(y, &a.data[y * values], &b.data[y * values], values);
    });
}

}  // namespace

std::uint32_t ulp_distance(float a, float b) {
    if (!std::isfinite(a) || !std::isfinite(b)) return saturated_ulp;
    return std::uint32_t(std::abs(ordered(a) - ordered(b)));
}

void count_differences(const Picture& a, const Picture& b, int threads, Report& report) {
    struct Row {
        std::int64_t differing = 0, nonfinite = 0;
        std::uint32_t max_ulp = 0;
    };
    std::vector<Row> rows(a.height);
    const std::size_t channels = a.channels.size();
    for_each_row(a, b, threads, [&](int y, const float* p, const float* q, std::size_t values) {
        for (std::size_t i = 0; i < values; i += channels) {
            bool same = true, finite = true;
            for (std::size_t c = i; c < i + channels; ++c) {
                same = same && std::bit_cast<std::uint32_t>(p[c]) == std::bit_cast<std::uint32_t>(q[c]);
                finite = finite && std::isfinite(p[c]) && std::isfinite(q[c]);
                rows[y].max_ulp = std::max(rows[y].max_ulp, ulp_distance(p[c], q[c]));
            }
            rows[y].differing += !(same && finite);
            rows[y].nonfinite += !finite;
        }
    });

    std::int64_t differing = 0;
    report.pixels = std::int64_t(a.width) * a.height;
    report.nonfinite = 0;
    report.max_ulp = 0;
    for (const Row& row : rows) {
        differing += row.differing;
        report.nonfinite += row.nonfinite;
        report.max_ulp = std::max(report.max_ulp, row.max_ulp);
    }
    report.differing = double(differing) / double(report.pixels);
    report.equal = differing == 0;
}

void sum_differences(const Picture& a, const Picture& b, double peak, int threads, Report& report) {
    struct Row {
        double absolute = 0, squared = 0, relative = 0, a = 0, b = 0;
        double largest = 0;
        std::size_t largest_at = 0;
    };
    std::vector<Row> rows(a.height);
    for_each_row(a, b, threads, [&](int y, const float* p, const float* q, std::size_t values) {
        Row& row = rows[y];
        for (std::size_t i = 0; i < values; ++i) {
            const double difference = double(p[i]) - double(q[i]), absolute = std::abs(difference);
            row.absolute += absolute;
            row.squared += difference * difference;
            row.relative += difference * difference / (double(q[i]) * double(q[i]) + 0.01);
            row.a += p[i];
            row.b += q[i];
            if (absolute > row.largest) {
                row.largest = absolute;
                row.largest_at = i;
            }
        }
    });

    // Sum the rows in order.
    Row total;
    int worst_row = 0;
    for (int y = 0; y < a.height; ++y) {
        const Row& row = rows[y];
        total.absolute += row.absolute;
        total.squared += row.squared;
        total.relative += row.relative;
        total.a += row.a;
        total.b += row.b;
        if (row.largest > total.largest) {
            total.largest = row.largest;
            total.largest_at = row.largest_at;
            worst_row = y;
        }
    }
    const std::size_t channels = a.channels.size();
    const double n = double(a.data.size()), mse = total.squared / n;
    report.mean_error = total.absolute / n;
    report.rmse = std::sqrt(mse);
    report.rel_mse = total.relative / n;
    if (peak > 0) {
        const double decibels_per_octave = 3.0102999566398120;  // 10 log10(2)
        report.psnr = mse > 0 ? decibels_per_octave * host::log2(peak * peak / mse)
                              : std::numeric_limits<double>::infinity();
    }
    report.max_absolute = total.largest;
    if (total.largest > 0) {
        const std::size_t i = worst_row * std::size_t(a.width) * channels + total.largest_at;
        report.worst = Worst{int(total.largest_at / channels), worst_row, a.channels[total.largest_at % channels],
                             a.data[i], b.data[i]};
    }

    // Correlate in a second pass, about the means: the one-pass form cancels.
    struct Moments {
        double aa = 0, bb = 0, ab = 0;
    };
    std::vector<Moments> moments(a.height);
    const double mean_a = total.a / n, mean_b = total.b / n;
    for_each_row(a, b, threads, [&](int y, const float* p, const float* q, std::size_t values) {
        for (std::size_t i = 0; i < values; ++i) {
            const double da = p[i] - mean_a, db = q[i] - mean_b;
            moments[y].aa += da * da;
            moments[y].bb += db * db;
            moments[y].ab += da * db;
        }
    });
    Moments sum;
    for (const Moments& row : moments) {
        sum.aa += row.aa;
        sum.bb += row.bb;
        sum.ab += row.ab;
    }
    // The mean of a constant picture may be rounded, and its variance then a little more than 0.
    auto constant = [&](const Picture& picture) {
        return std::all_of(picture.data.begin(), picture.data.end(), [&](float v) { return v == picture.data[0]; });
    };
    if (!constant(a) && !constant(b)) {
        report.pearson = std::clamp(sum.ab / (std::sqrt(sum.aa) * std::sqrt(sum.bb)), -1.0, 1.0);
    }
}

}  // namespace plumb::compare
