#include "gi/radiosity/texel_weights.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/radiosity/plane_weight.h"
#include "raster/hemicube.h"

namespace plumb::radiosity {
namespace {

using host::pi;

// The same of a side: z / (pi (y^2 + z^2 + 1)^2).
double side_corner(double y, double z) {
    const double c = std::sqrt(1 + z * z);
    return -host::atan(y / c) / (2 * pi * c);
}

// The integral over texel (i, j) of the quarter 0..1, 0..1, from corners[(half + 1) * row + column].
double between(const std::vector<double>& corners, int half, int i, int j) {
    const double* low = &corners[std::size_t(j) * std::size_t(half + 1) + std::size_t(i)];
    const double* high = low + half + 1;
    return (high[1] - high[0]) - (low[1] - low[0]);
}

std::vector<double> corners_of(int half, double (*f)(double, double)) {
    std::vector<double> corners;
    for (int j = 0; j <= half; ++j)
        for (int i = 0; i <= half; ++i) corners.push_back(f(double(i) / half, double(j) / half));
    return corners;
}

// Mirrored texels share one value. The two ways across the top's diagonal differ by rounding: one is taken.
std::vector<double> exact_top(int size) {
    const int half = size / 2;
    const std::vector<double> corners = corners_of(half, plane_weight);
    auto from_middle = [&](int k) { return k < half ? half - 1 - k : k - half; };
    std::vector<double> weights;
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const int x = from_middle(i), y = from_middle(j);
            weights.push_back(x > y ? between(corners, half, x, y) : between(corners, half, y, x));
        }
    return weights;
}

// The first row is the uppermost, z = 1.
std::vector<double> exact_side(int size) {
    const int half = size / 2;
    const std::vector<double> corners = corners_of(half, side_corner);
    std::vector<double> weights;
    for (int j = 0; j < half; ++j)
        for (int i = 0; i < size; ++i)
            weights.push_back(between(corners, half, i < half ? half - 1 - i : i - half, half - 1 - j));
    return weights;
}

// HEM (5.5): cos(atan(sqrt(x^2 + y^2)))^2 = 1 / r^2. HEM (5.7): the cosine at the surface is height / r: height / r^2.
std::vector<double> published_top(int size) {
    std::vector<double> weights;
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const double x = (2 * i + 1.0) / size - 1, y = (2 * j + 1.0) / size - 1;
            weights.push_back(1 / (x * x + y * y + 1));
        }
    return weights;
}
std::vector<double> published_side(int size) {
    std::vector<double> weights;
    for (int j = 0; j < size / 2; ++j)
        for (int i = 0; i < size; ++i) {
            const double x = (2 * i + 1.0) / size - 1, height = 1 - (2 * j + 1.0) / size;
            weights.push_back(height / (x * x + height * height + 1));
        }
    return weights;
}

void check(int size) {
    if (size < 2 || size > 4096 || size % 2 != 0)
        throw InputError(fmt::format("hemicube: size = {}: must be even, 2 to 4096 texels", size));
}

}  // namespace

// Its second derivative by x and y is 1 / (pi (x^2 + y^2 + 1)^2).
double plane_weight(double x, double y) {
    const double a = std::sqrt(1 + x * x), b = std::sqrt(1 + y * y);
    return (x / a * host::atan(y / a) + y / b * host::atan(x / b)) / (2 * pi);
}

double published_sum(int size) {
    check(size);
    double top = 0, side = 0;
    for (const double w : published_top(size)) top += w;
    for (const double w : published_side(size)) side += w;
    return top + 4 * side;
}

std::vector<double> texel_weights(int size, Weights weights) {
    check(size);
    std::vector<double> all, side;
    switch (weights) {
        case Weights::exact:
            all = exact_top(size), side = exact_side(size);
            break;
        case Weights::centre:
            all = raster::delta_form_factors_top(size), side = raster::delta_form_factors_side(size);
            break;
        case Weights::published:
            all = published_top(size), side = published_side(size);
            const double sum = published_sum(size);
            for (double& w : all) w /= sum;
            for (double& w : side) w /= sum;
            break;
    }
    for (int face = 1; face < raster::hemicube_faces; ++face) all.insert(all.end(), side.begin(), side.end());
    return all;
}

}  // namespace plumb::radiosity
