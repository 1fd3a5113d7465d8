#include "gi/reference/environment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/reference/environment_kernel.h"

namespace plumb::reference {
namespace {

// Steps of the uniform numbers that the table is inverted with: it has the same, so that an interval's probability is
// exactly the count of numbers that fall into it.
constexpr double steps = 0x1p24;

// Writes cdf[n + 1] of n weights. What has a weight gets one step at least, or no sample would ever see it.
void cumulative(const std::vector<double>& weights, float* cdf) {
    double total = 0, shining = 0;
    for (const double w : weights) total += w, shining += w > 0;
    double sum = 0, before = 0;
    cdf[0] = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        sum += weights[i], before += weights[i] > 0;
        const double share = total > 0 ? sum / total : 0;
        cdf[i + 1] = float((before + std::floor((steps - shining) * share + 0.5)) / steps);
    }
    cdf[weights.size()] = 1;
}

// Multiplies the map, or white where there is none, by the environment's radiance.
void multiply(const Environment& environment, EnvironmentTable& t) {
    t.radiance.resize(4 * std::size_t(t.width) * t.height);
    for (int y = 0; y < t.height; ++y) {
        for (int x = 0; x < t.width; ++x) {
            float* out = &t.radiance[4 * (std::size_t(y) * t.width + x)];
            for (int c = 0; c < 3; ++c) {
                out[c] = environment.radiance[c] * (environment.map.empty() ? 1.0f : environment.map(x, y)[c]);
                if (!(out[c] >= 0 && out[c] <= std::numeric_limits<float>::max()))
                    throw InputError("environment: texel (" + std::to_string(x) + ", " + std::to_string(y) +
                                     "): radiance " + std::to_string(out[c]) + " is not a finite number >= 0");
            }
        }
    }
}

double sum_of_channels(const EnvironmentTable& t, int x, int y) {
    const float* texel = &t.radiance[4 * (std::size_t(y) * t.width + (x + t.width) % t.width)];
    return double(texel[0]) + texel[1] + texel[2];
}

// A row's patches by what they send, over the solid angle of one column: the integral of the interpolated radiance.
// Along a row the neighbours' tents have 1/8, 3/4 and 1/8 of a patch. Down a column, at y from the row's middle a, the
// next row has y/h and this one 1 - |y|/h; with e = h/2
//   int_0^e y sin(a +- y) dy = sin a (e sin e + cos e - 1) +- cos a (sin e - e cos e).
void interpolated_row(const EnvironmentTable& t, int y, double solid_angle, std::vector<double>& sent) {
    const double e = host::pi / (2 * t.height), a = (2 * y + 1) * e, column = 2 * host::pi / t.width;
    const double sine = host::sin(e), even = host::sin(a) * (e * sine + host::cos(e) - 1),
                 odd = host::cos(a) * (sine - e * host::cos(e));
    const double below = column * (even + odd) / (2 * e), above = column * (even - odd) / (2 * e);
    const int rows[3] = {std::max(y - 1, 0), y, std::min(y + 1, t.height - 1)};
    const double weights[3] = {above, solid_angle - above - below, below};
    for (int x = 0; x < t.width; ++x) {
        sent[x] = 0;
        for (int k = 0; k < 3; ++k)
            sent[x] += weights[k] * (0.125 * (sum_of_channels(t, x - 1, rows[k]) + sum_of_channels(t, x + 1, rows[k])) +
                                     0.75 * sum_of_channels(t, x, rows[k]));
    }
}

}  // namespace

EnvironmentTable environment_table(const Environment& environment) {
    EnvironmentTable t;
    t.width = environment.map.empty() ? 1 : environment.map.width;
    t.height = environment.map.empty() ? 1 : environment.map.height;
    if (std::size_t(t.width) * t.height > (1u << 29))
        throw InputError("environment: a map of " + std::to_string(t.width) + " x " + std::to_string(t.height) +
                         " texels; at most 2^29 can be indexed");
    multiply(environment, t);
    t.bilinear = !environment.map.empty() && environment.filter == Filter::bilinear;

    // Sums what each patch sends. A row's patches have the solid angle 2 pi / width (cos v0 - cos v1) each, and the
    // difference of the cosines is 2 sin((v0 + v1)/2) sin((v1 - v0)/2), without cancellation at the poles.
    const double half = host::pi / (2 * t.height);
    std::vector<double> rows(t.height), columns(t.width), solid_angles(t.height);
    t.column_cdf.resize(std::size_t(t.height) * (t.width + 1));
    for (int y = 0; y < t.height; ++y) {
        solid_angles[y] = 2 * host::pi / t.width * 2 * host::sin((2 * y + 1) * half) * host::sin(half);
        for (int x = 0; x < t.width; ++x) {
            columns[x] = sum_of_channels(t, x, y);
            rows[y] += columns[x] * solid_angles[y];
        }
        if (t.bilinear) {
            interpolated_row(t, y, solid_angles[y], columns);
            rows[y] = 0;
            for (const double sent : columns) rows[y] += sent;
        }
        cumulative(columns, &t.column_cdf[std::size_t(y) * (t.width + 1)]);
        t.mean_radiance += rows[y] / (3 * 4 * host::pi);
    }
    if (t.mean_radiance == 0) return {};
    t.row_cdf.resize(t.height + 1);
    cumulative(rows, t.row_cdf.data());

    // Divides each patch's probability, as the rounded tables have it, by its solid angle.
    t.pdf.resize(std::size_t(t.width) * t.height);
    for (int y = 0; y < t.height; ++y) {
        const double row = double(t.row_cdf[y + 1]) - t.row_cdf[y];
        const float* cdf = &t.column_cdf[std::size_t(y) * (t.width + 1)];
        for (int x = 0; x < t.width; ++x)
            t.pdf[std::size_t(y) * t.width + x] = float(row * (double(cdf[x + 1]) - cdf[x]) / solid_angles[y]);
    }
    return t;
}

EnvironmentArgs environment_args(const EnvironmentTable& t) {
    return {t.width, t.height, t.radiance.data(), t.row_cdf.data(), t.column_cdf.data(), t.pdf.data(), t.bilinear};
}

}  // namespace plumb::reference
