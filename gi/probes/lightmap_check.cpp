#include "gi/probes/lightmap_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/lightmap_check_parts.h"

namespace plumb::probes {

namespace {

constexpr double tolerance_of_errors = 0.1;  // beyond which, and the noise, signed_errors() counts a texel as wrong

void check_map(const Image4& map, const glm::ivec2& size, const char* what) {
    if (map.width != size.x || map.height != size.y)
        throw InputError(fmt::format("lightmap: {} is {} x {} texels: expected {} x {}", what, map.width, map.height, size.x, size.y));
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            for (int c = 0; c < 3; ++c)
                if (!std::isfinite(map(x, y)[c]))
                    throw InputError(fmt::format("lightmap: {}: texel {},{} is {} in {}: expected finite numbers", what, x, y,
                                                 map(x, y)[c], "RGB"[c]));
}

// The truth as it can be told from the map: errors of both.
ReceiverIrradiance with_error_of_map(ReceiverIrradiance truth, const Image4& map_error, const Receivers& receivers) {
    for (std::size_t i = 0; i < truth.error.size() && !map_error.empty(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double own = double(truth.error[i][c]), its = double(map_error(receivers.texel[i].x, receivers.texel[i].y)[c]);
            truth.error[i][c] = float(std::sqrt(own * own + its * its));
        }
    return truth;
}

double median_of(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Receivers that lie outside of everything, or that do not, one a column.
struct Columns {
    compare::Plane user, truth, error;
    std::vector<int> receiver;
};
Columns columns_of(const CheckInputs& in, bool inside) {
    Columns c;
    for (int i = 0; i < in.receivers().count(); ++i)
        if (in.is_inside(i) == inside) c.receiver.push_back(i);
    const int n = int(c.receiver.size());
    c.user = c.truth = c.error = compare::Plane(n, 1);
    for (int k = 0; k < n; ++k) {
        const Place p = place_of(in, c.receiver[std::size_t(k)]);
        c.user(k, 0) = p.user, c.truth(k, 0) = p.truth, c.error(k, 0) = p.error;
    }
    return c;
}

compare::SignedErrors errors_of(const Columns& c, double sigmas) {
    return compare::signed_errors(c.user, c.truth, c.error, {}, {tolerance_of_errors, sigmas});
}

void find_told(const CheckInputs& in, const Columns& c, int rounds, LightmapCheck& out) {
    double squares = 0, told_squares = 0, farthest = 0, excess = 0, variance = 0;
    std::size_t told = 0;
    for (std::size_t k = 0; k < c.receiver.size(); ++k) {
        const double d = c.user.texels[k] - c.truth.texels[k], beyond = std::fabs(d) - in.params.sigmas * c.error.texels[k];
        const double s2 = c.error.texels[k] * c.error.texels[k], e2 = std::max(d * d - s2, 0.0);
        squares += d * d, excess += d * d - s2;
        // Of d^2 about e^2 + s^2, and of s^2 about its own mean, for normal noise.
        variance += 4 * e2 * s2 + 2 * s2 * s2 * (1 + 1.0 / (rounds - 1));
        if (!(beyond > 0)) continue;
        ++told, told_squares += d * d;
        if (beyond > farthest) farthest = beyond, out.worst = place_of(in, c.receiver[k]);
    }
    out.told = c.receiver.empty() ? 0 : double(told) / double(c.receiver.size());
    out.told_energy = squares > 0 ? told_squares / squares : 0;
    out.told_by_chance = student_beyond(in.params.sigmas, rounds - 1);
    const double n = double(c.receiver.size()), mean = out.errors.mean_truth.value_or(0);
    if (!(n > 0 && mean > 0)) return;
    const double off = std::sqrt(variance);
    out.rms_least = std::sqrt(std::max(excess - 4 * off, 0.0) / n) / mean;
    out.rms_most = std::sqrt(std::max(excess + 2 * off, 0.0) / n) / mean;
}

// Least squares over receivers: the s with the least sum of (s u - t)^2.
void find_scale(const Columns& c, double sigmas, LightmapCheck& out) {
    double uu = 0, ut = 0;
    for (std::size_t k = 0; k < c.receiver.size(); ++k)
        uu += c.user.texels[k] * c.user.texels[k], ut += c.user.texels[k] * c.truth.texels[k];
    if (!(uu > 0) || !(ut > 0)) return;
    Columns scaled = c;
    out.best_scale = ut / uu;
    for (double& u : scaled.user.texels) u *= out.best_scale;
    out.rms_at_best_scale = errors_of(scaled, sigmas).rms.value_or(0);
}

void find_charts(const CheckInputs& in, const Columns& c, LightmapCheck& out) {
    struct Sums {
        int n = 0;
        double user = 0, truth = 0, variance = 0, squares = 0;
    };
    std::vector<Sums> sums(in.atlas().charts.size());
    for (std::size_t k = 0; k < c.receiver.size(); ++k) {
        Sums& s = sums[std::size_t(in.truth.chart_of(c.receiver[k]))];
        const double u = c.user.texels[k], t = c.truth.texels[k], e = c.error.texels[k];
        ++s.n, s.user += u, s.truth += t, s.variance += e * e, s.squares += (u - t) * (u - t);
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const Sums& s = sums[i];
        if (s.n == 0) continue;
        ChartCheck chart;
        chart.chart = std::int32_t(i), chart.receivers = s.n, chart.truth = s.truth / s.n;
        // A chart in the dark is compared with what lights the others.
        const double light = std::max(s.truth, in.floor * s.n);
        chart.bias = (s.user - s.truth) / light, chart.bias_error = std::sqrt(s.variance) / light;
        chart.rms = std::sqrt(std::max(s.squares - s.variance, 0.0) * s.n) / light;
        chart.off = std::fabs(chart.bias) > in.params.sigmas * chart.bias_error + in.params.chart_bias;
        out.charts.push_back(chart);
    }
}

}  // namespace

Place place_of(const CheckInputs& in, int receiver) {
    const std::size_t i = std::size_t(receiver);
    Place p;
    p.texel = in.receivers().texel[i];
    p.object = in.atlas().geometry.object[std::size_t(in.receivers().triangle[i])];
    p.chart = in.truth.chart_of(receiver);
    p.position = glm::dvec3(in.receivers().position[i]);
    p.user = in.user_at(p.texel);
    p.truth = luminance_of(in.truth.truth().mean[i]), p.error = luminance_of(in.truth.truth().error[i]);
    return p;
}

// Abramowitz and Stegun 26.7.3 and 26.7.4: with theta = atan(t / sqrt(n)) a finite sum for each n.
double student_beyond(double t, int degrees) {
    const double theta = host::atan(std::fabs(t) / std::sqrt(double(degrees))), c = host::cos(theta), s = host::sin(theta);
    double term = degrees % 2 ? c : 1, sum = 0;
    for (int k = degrees % 2 ? 1 : 0; k < degrees - 1; k += 2) sum += term, term *= c * c * (k + 1) / (k + 2);
    const double within = degrees % 2 ? 2 / host::pi * (theta + s * sum) : s * sum;
    return std::clamp(1 - within, 0.0, 1.0);
}

double student_sigmas(double sigmas, int degrees) {
    const double share = std::max(student_beyond(sigmas, 1 << 20), 0x1p-40);
    double low = sigmas, high = sigmas;
    while (student_beyond(high, degrees) > share) high *= 2;
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        (student_beyond(middle, degrees) > share ? low : high) = middle;
    }
    return high;
}

LightmapCheck check_lightmap(const Image4& map, const Image4& map_error, const Lightmap& l, const ReceiverIrradiance& truth,
                             const CheckParams& asked) {
    CheckParams params = asked;
    params.sigmas = student_sigmas(asked.sigmas, truth.rounds - 1);
    check_map(map, l.receivers.size, "the map");
    if (!map_error.empty()) check_map(map_error, l.receivers.size, "the map's error");
    const ReceiverIrradiance known = with_error_of_map(truth, map_error, l.receivers);
    const ChartTexels texels(l.atlas, l.receivers, known), alone(l.atlas, l.receivers, truth);
    CheckInputs in{map, texels, alone, params};
    std::vector<double> lit;
    double brightest = 0;
    for (int i = 0; i < l.receivers.count(); ++i) {
        const double t = luminance_of(known.mean[std::size_t(i)]);
        if (t > 0 && !in.is_inside(i)) lit.push_back(t);
        brightest = std::max(brightest, in.user_at(l.receivers.texel[std::size_t(i)]));
    }
    in.median = median_of(lit);
    // Where the truth has no light at all, the map's own.
    in.floor = in.median > 0 ? 0.05 * in.median : brightest > 0 ? brightest : 1;

    LightmapCheck out;
    out.median = in.median;
    out.error = known.error;
    out.sigmas = params.sigmas, out.rounds = truth.rounds;
    const Columns seen = columns_of(in, false), inside = columns_of(in, true);
    out.errors = errors_of(seen, params.sigmas);
    out.inside = int(inside.receiver.size());
    out.inside_errors = errors_of(inside, params.sigmas);
    find_told(in, seen, truth.rounds, out);
    find_scale(seen, params.sigmas, out);
    find_charts(in, seen, out);
    find_seams(in, out);
    find_leaks(in, out);
    find_bleeding(in, out);
    return out;
}

}  // namespace plumb::probes
