#include "core/flip.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/host_math.h"
#include "core/parallel.h"
#include "core/separable.h"

namespace plumb::compare {
namespace {

using glm::dvec3;
constexpr double pi = 3.14159265358979323846;

// ---- colour ---------------------------------------------------------------------------------------------------------

// The N-th root of a normal x > 0: Halley's iteration, each of whose three steps cubes the error (times (N^2 - 1)/12);
// the exponent divided by N starts it within 10 %. It is in place of host::pow, as FLIP takes 13 roots a pixel.
template <int N>
double root(double x) {
    const std::uint64_t one = std::bit_cast<std::uint64_t>(1.0), bits = std::bit_cast<std::uint64_t>(x);
    double r = std::bit_cast<double>(one - one / N + bits / N);
    for (int i = 0; i < 3; ++i) {
        double power = r;
        for (int k = 1; k < N; ++k) power *= r;
        r *= ((N - 1) * power + (N + 1) * x) / ((N + 1) * power + (N - 1) * x);
    }
    return r;
}

// x^y for normal 0 < x <= 1 and 0 <= y <= 1, within 1e-13: x = 2^e m with m in sqrt(1/2)..sqrt(2), its logarithm as a
// series of s = (m - 1)/(m + 1), |s| < 0.172; then the series of exp about the nearest power of two. An eighth of the
// time of host::pow, which rounds correctly.
double power(double x, double y) {
    const double ln2 = 0.693147180559945309417;
    const std::int64_t bits = std::bit_cast<std::int64_t>(x), sqrt_half = 0x3fe6a09e667f3bcd;
    const std::int64_t exponent = (bits - sqrt_half) >> 52;
    const double m = std::bit_cast<double>(bits - (exponent << 52)), s = (m - 1) / (m + 1), s2 = s * s;
    double series = 0;
    for (int k = 19; k >= 1; k -= 2) series = series * s2 + 1.0 / k;
    const double logarithm = y * (double(exponent) * ln2 + 2 * s * series);

    const double n = std::floor(logarithm / ln2 + 0.5), r = logarithm - n * ln2;
    double sum = 1;
    for (int k = 13; k >= 1; --k) sum = 1 + r / k * sum;
    return sum * std::bit_cast<double>((std::int64_t(n) + 1023) << 52);
}

// Linear RGB (Rec. 709 primaries, D65) to XYZ relative to the white point, and back. Row by row, exact fractions of the
// chromaticities; white is (1, 1, 1) in both, so greys have no chroma but for the rounding.
struct Primaries {
    dvec3 x = dvec3(10135552, 8788810, 4435075), y = dvec3(5226144, 17577620, 1774030),
          z = dvec3(1425312, 8788810, 70074185);
    glm::dmat3 to_rgb;

    Primaries() {
        x /= x.x + x.y + x.z;
        y /= y.x + y.y + y.z;
        z /= z.x + z.y + z.z;
        to_rgb = glm::inverse(glm::transpose(glm::dmat3(x, y, z)));
    }
    dvec3 to_xyz(dvec3 rgb) const { return {glm::dot(x, rgb), glm::dot(y, rgb), glm::dot(z, rgb)}; }
};

dvec3 clamp_to_display(dvec3 rgb) { return glm::clamp(rgb, 0.0, 1.0); }

// CIE L*a*b* with the Hunt adjustment of FLIP 2020: colours of low luminance differ less.
dvec3 hunt_adjusted_lab(dvec3 xyz) {
    const double delta = 6.0 / 29;
    auto f = [&](double t) { return t > delta * delta * delta ? root<3>(t) : t / (3 * delta * delta) + 4.0 / 29; };
    const dvec3 v(f(xyz.x), f(xyz.y), f(xyz.z));
    const double lightness = 116 * v.y - 16;
    return {lightness, 0.01 * lightness * 500 * (v.x - v.y), 0.01 * lightness * 200 * (v.y - v.z)};
}

// The distance HyAB (a city block in lightness, Euclid in chroma) to the power q_c = 0.7, as (tenth root)^7.
double distance(dvec3 a, dvec3 b) {
    const dvec3 d = a - b;
    const double hyab = std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
    if (hyab < 1e-100) return 0;
    const double r = root<5>(std::sqrt(hyab)), r2 = r * r;
    return r2 * r2 * r2 * r;
}

// Maps 0..p_c c_max to 0..p_t and the rest to p_t..1, c_max the distance of the display's green and blue.
double redistribute(double distance, double c_max) {
    const double p_c = 0.4, p_t = 0.95, knee = p_c * c_max;
    if (distance < knee) return p_t / knee * distance;
    return std::min(1.0, p_t + (distance - knee) / (c_max - knee) * (1 - p_t));
}

// ---- filters --------------------------------------------------------------------------------------------------------

// The contrast sensitivity of the eye as sums of Gaussians a sqrt(pi/b) exp(-pi^2 d^2/b), d in degrees, with the
// constants of FLIP 2020: lane 0 the achromatic one, 1 red-green, 2 and 3 the two terms of blue-yellow, each normalised
// by itself. The 2D filter is a sum of products of 1D filters; `share` holds what each blue-yellow term adds to it.
struct ContrastSensitivity {
    Taps taps;
    double share[2];

    explicit ContrastSensitivity(double pixels_per_degree) {
        const double b[4] = {0.0047, 0.0053, 0.04, 0.025}, a[4] = {1, 1, 34.1, 13.5};
        const int radius = int(std::ceil(3 * std::sqrt(b[2] / (2 * pi * pi)) * pixels_per_degree));
        taps = {radius, Buffer<Lanes>(2 * radius + 1)};
        Lanes sum{};
        for (int k = 0; k <= 2 * radius; ++k) {
            const double degrees = (k - radius) / pixels_per_degree;
            for (int lane = 0; lane < 4; ++lane) {
                taps.weights[k][lane] = host::exp(-pi * pi * degrees * degrees / b[lane]);
            }
            sum += taps.weights[k];
        }
        for (Lanes& weight : taps.weights) weight /= sum;
        const double volumes[2] = {a[2] * std::sqrt(pi / b[2]) * sum[2] * sum[2],
                                   a[3] * std::sqrt(pi / b[3]) * sum[3] * sum[3]};
        for (int i = 0; i < 2; ++i) share[i] = volumes[i] / (volumes[0] + volumes[1]);
    }
};

// Edges and points as first and second derivatives of a Gaussian that is w = 0.082 degrees from peak to trough; the
// positive weights sum to 1, the negative ones to -1. Lanes after both passes: edge along x,
// edge along y, point along x, point along y.
struct FeatureFilters {
    Taps rows, columns;

    explicit FeatureFilters(double pixels_per_degree) {
        const double sigma = 0.5 * 0.082 * pixels_per_degree;
        const int radius = int(std::ceil(3 * sigma)), count = 2 * radius + 1;
        std::vector<double> smooth(count), edge(count), point(count);
        for (int k = 0; k < count; ++k) {
            const double x = k - radius, g = host::exp(-x * x / (2 * sigma * sigma));
            smooth[k] = g;
            edge[k] = -x * g;
            point[k] = (x * x / (sigma * sigma) - 1) * g;
        }
        for (auto* weights : {&smooth, &edge, &point}) normalise(*weights);
        rows = {radius, Buffer<Lanes>(count)};
        columns = {radius, Buffer<Lanes>(count)};
        for (int k = 0; k < count; ++k) {
            rows.weights[k] = Lanes{edge[k], smooth[k], point[k], smooth[k]};
            columns.weights[k] = Lanes{smooth[k], edge[k], smooth[k], point[k]};
        }
    }

    static void normalise(std::vector<double>& weights) {
        double positive = 0, negative = 0;
        for (const double w : weights) (w < 0 ? negative : positive) += w;
        for (double& w : weights) w /= w < 0 ? -negative : positive;
    }
};

// ---- the two pipelines ----------------------------------------------------------------------------------------------

struct Flip {
    Primaries primaries;
    ContrastSensitivity sensitivity;
    FeatureFilters features;
    double c_max;
    int threads;

    Flip(double pixels_per_degree, int threads)
        : sensitivity(pixels_per_degree), features(pixels_per_degree), threads(threads) {
        c_max = distance(hunt_adjusted_lab(primaries.to_xyz({0, 1, 0})),
                         hunt_adjusted_lab(primaries.to_xyz({0, 0, 1})));
    }

    // Turns every pixel of linear RGB into what the filters read: Y Cx Cz Cz, or the relative luminance in all lanes.
    template <class Display>
    Image<Lanes> prepare(const Image<dvec3>& rgb, const Display& display, bool colour) const {
        Image<Lanes> out(rgb.width, rgb.height);
        parallel_bands(rgb.height, 16, threads, [&](int first, int last) {
            for (std::size_t i = std::size_t(first) * rgb.width; i < std::size_t(last) * rgb.width; ++i) {
                const dvec3 v = primaries.to_xyz(display(rgb.texels[i]));
                const double cz = 200 * (v.y - v.z);
                out.texels[i] = colour ? Lanes{116 * v.y - 16, 500 * (v.x - v.y), cz, cz} : Lanes{} + v.y;
            }
        });
        return out;
    }

    // What the eye resolves of a filtered pixel, as far as the display shows it, in a space of equal steps.
    dvec3 seen_colour(Lanes filtered) const {
        const double y = (filtered[0] + 16) / 116;
        const double cz = sensitivity.share[0] * filtered[2] + sensitivity.share[1] * filtered[3];
        const dvec3 rgb = clamp_to_display(primaries.to_rgb * dvec3(y + filtered[1] / 500, y, y - cz / 200));
        return hunt_adjusted_lab(primaries.to_xyz(rgb));
    }

    // Filters the columns of both pictures and hands each pair of pixels to the combiner.
    template <class Combine>
    void for_each_pair(const Image<Lanes>& a, const Image<Lanes>& b, const Taps& columns,
                       const Combine& combine) const {
        parallel_bands(a.height, 16, threads, [&](int first, int last) {
            Buffer<Lanes> row_a(a.width), row_b(a.width);
            for (int y = first; y < last; ++y) {
                filter_columns(a, columns, y, row_a.data());
                filter_columns(b, columns, y, row_b.data());
                for (int x = 0; x < a.width; ++x) combine(x, y, row_a[x], row_b[x]);
            }
        });
    }

    // LDR-FLIP of what `display` makes of the two pictures: the map Delta E = (Delta E_c)^(1 - Delta E_f).
    template <class Display>
    Image<double> errors(const Image<dvec3>& reference, const Image<dvec3>& test, const Display& display) const {
        Image<double> map(reference.width, reference.height);
        {
            Image<Lanes> a = prepare(reference, display, true), b = prepare(test, display, true);
            filter_rows(a, sensitivity.taps, threads);
            filter_rows(b, sensitivity.taps, threads);
            for_each_pair(a, b, sensitivity.taps, [&](int x, int y, Lanes p, Lanes q) {
                map(x, y) = redistribute(distance(seen_colour(p), seen_colour(q)), c_max);
            });
        }
        Image<Lanes> a = prepare(reference, display, false), b = prepare(test, display, false);
        filter_rows(a, features.rows, threads);
        filter_rows(b, features.rows, threads);
        for_each_pair(a, b, features.columns, [&](int x, int y, Lanes p, Lanes q) {
            double& error = map(x, y);
            if (error == 0) return;
            const double edge = std::abs(std::sqrt(p[0] * p[0] + p[1] * p[1]) - std::sqrt(q[0] * q[0] + q[1] * q[1]));
            const double point = std::abs(std::sqrt(p[2] * p[2] + p[3] * p[3]) - std::sqrt(q[2] * q[2] + q[3] * q[3]));
            const double feature = std::sqrt(std::max(edge, point) / std::sqrt(2.0));  // q_f = 0.5
            error = power(error, std::max(0.0, 1 - feature));
        });
        return map;
    }
};

FlipResult result_of(const Image<double>& map) {
    FlipResult result;
    result.map = Image1(map.width, map.height);
    double sum = 0;
    for (int y = 0; y < map.height; ++y) {
        double row = 0;
        for (int x = 0; x < map.width; ++x) {
            row += map(x, y);
            result.map(x, y) = float(map(x, y));
        }
        sum += row;
    }
    result.mean = map.empty() ? 0 : sum / double(map.size());
    return result;
}

// ---- exposures ------------------------------------------------------------------------------------------------------

// The tone curve (k0 x^2 + k1 x)/(k3 x^2 + k4 x + k5): K. Narkowicz's fit to ACES, its exposure of 0.6 taken into the
// coefficients.
constexpr double k0 = 0.6 * 0.6 * 2.51, k1 = 0.6 * 0.03, k3 = 0.6 * 0.6 * 2.43, k4 = 0.6 * 0.59, k5 = 0.14;

dvec3 tone_mapped(dvec3 x) {
    return clamp_to_display((k0 * x * x + k1 * x) / (k3 * x * x + k4 * x + k5));
}

// Chooses the exposures so that the brightest pixel (first) and the median one (last) reach 0.85 of the display.
void choose_exposures(const Image<dvec3>& reference, FlipResult& result) {
    std::vector<double> luminances;
    for (const dvec3& rgb : reference.texels) {
        luminances.push_back(glm::dot(dvec3(0.2126, 0.7152, 0.0722), glm::max(rgb, 0.0)));
    }
    auto median = [&] {
        std::nth_element(luminances.begin(), luminances.begin() + luminances.size() / 2, luminances.end());
        return luminances[luminances.size() / 2];
    };
    double middle = median();
    if (middle == 0) {
        std::erase(luminances, 0.0);
        if (luminances.empty()) return;
        middle = median();
    }
    const double brightest = *std::max_element(luminances.begin(), luminances.end());

    // Solve the tone curve for the x that it maps to t: a x^2 + b x + c = 0.
    const double t = 0.85, a = k0 - t * k3, b = k1 - t * k4, c = -t * k5;
    const double x = (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
    result.start_exposure = host::log2(x / brightest);
    result.stop_exposure = host::log2(x / middle);
    result.exposures = std::max(2, int(std::ceil(result.stop_exposure - result.start_exposure)));
}

}  // namespace

FlipResult flip_ldr(const Image<dvec3>& reference, const Image<dvec3>& test, double pixels_per_degree, int threads) {
    return result_of(Flip(pixels_per_degree, threads).errors(reference, test, clamp_to_display));
}

FlipResult flip_hdr(const Image<dvec3>& reference, const Image<dvec3>& test, double pixels_per_degree, int threads) {
    FlipResult range;
    choose_exposures(reference, range);
    const double step = range.exposures > 1 ? (range.stop_exposure - range.start_exposure) / (range.exposures - 1) : 0;

    // Keep the largest error of each pixel.
    const Flip flip(pixels_per_degree, threads);
    Image<double> largest(reference.width, reference.height, 0.0);
    for (int i = 0; i < range.exposures; ++i) {
        const double factor = host::exp2(range.start_exposure + i * step);
        const Image<double> errors = flip.errors(reference, test, [&](dvec3 rgb) {
            return tone_mapped(factor * glm::max(rgb, 0.0));
        });
        for (std::size_t k = 0; k < errors.size(); ++k) {
            largest.texels[k] = std::max(largest.texels[k], errors.texels[k]);
        }
    }

    FlipResult result = result_of(largest);
    result.start_exposure = range.start_exposure;
    result.stop_exposure = range.stop_exposure;
    result.exposures = range.exposures;
    return result;
}

double srgb_to_linear(double encoded) {
    if (encoded <= 0.04045) return encoded / 12.92;
    const double v = (encoded + 0.055) / 1.055, r = root<5>(v);
    return v * v * r * r;  // v^2.4
}

}  // namespace plumb::compare
