#include "core/signed_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/compare_pictures.h"
#include "core/error.h"

namespace plumb::compare {

namespace {

template <class A, class B>
void require_same_size(const Image<A>& a, const Image<B>& b, const char* what) {
    if (a.width != b.width || a.height != b.height)
        throw InputError(fmt::format("signed error: {} is {} x {}, the picture {} x {}", what, b.width, b.height,
                                     a.width, a.height));
}

void require_amount(double value, const char* name) {
    if (!(value >= 0) || !std::isfinite(value))
        throw InputError(fmt::format("signed error: {} is {}, expected a number of at least 0", name, value));
}

// Over the compared pixels; all of them finite but for those that are counted.
struct Sums {
    std::int64_t pixels = 0, nonfinite = 0, too_dark = 0, too_bright = 0;
    double truth = 0, difference = 0, squares = 0, variances = 0, removed = 0, leaked = 0;

    void add(double a, double t, double e, const SignedErrorOptions& options) {
        ++pixels;
        if (!std::isfinite(a) || !std::isfinite(t) || !std::isfinite(e)) {
            ++nonfinite;
            return;
        }
        const double d = a - t, noise = options.sigmas * e, allowed = options.tolerance * std::abs(t) + noise;
        too_dark += -d > allowed;
        too_bright += d > allowed;
        truth += t, difference += d, squares += d * d, variances += e * e;
        removed += std::max(-d - noise, 0.0);
        leaked += std::max(d - noise, 0.0);
    }
};

SignedErrors result(const Sums& s) {
    SignedErrors r;
    r.pixels = s.pixels, r.nonfinite = s.nonfinite;
    if (s.pixels == 0) return r;
    const double n = double(s.pixels);
    r.too_dark = double(s.too_dark) / n, r.too_bright = double(s.too_bright) / n;
    r.wrong = double(s.too_dark + s.too_bright + s.nonfinite) / n;
    if (s.nonfinite > 0) return r;
    r.mean_truth = s.truth / n;
    r.below_noise = s.squares <= s.variances;
    if (!(s.truth > 0)) return r;
    const double mean = s.truth / n;
    r.mean_error = s.difference / s.truth;
    r.rms = std::sqrt(std::max(s.squares - s.variances, 0.0) / n) / mean;
    r.noise = std::sqrt(s.variances / n) / mean;
    r.removed = s.removed / s.truth, r.leaked = s.leaked / s.truth;
    return r;
}

}  // namespace

Plane relative_errors(const Plane& a, const Plane& truth, double floor, const Plane& error, double sigmas) {
    require_same_size(a, truth, "the truth");
    if (!error.empty()) require_same_size(a, error, "the standard error");
    require_amount(floor, "floor");
    require_amount(sigmas, "sigmas");
    Plane out(a.width, a.height);
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double x = a.texels[i], t = truth.texels[i], e = error.empty() ? 0 : error.texels[i];
        if (!std::isfinite(x) || !std::isfinite(t) || !std::isfinite(e)) {
            out.texels[i] = std::numeric_limits<double>::quiet_NaN();
            continue;
        }
        const double beyond = std::max(std::abs(x - t) - sigmas * e, 0.0);
        out.texels[i] = beyond == 0 ? 0 : (x < t ? -beyond : beyond) / (std::abs(t) + floor);
    }
    return out;
}

glm::vec3 signed_color(double relative_error, double swing) {
    const glm::dvec3 dark(0.10, 0.28, 0.75), bright(0.78, 0.09, 0.11), equal(1);
    if (std::isnan(relative_error) || !(swing > 0)) return {0, 1, 0};
    const double t = std::min(std::abs(relative_error) / swing, 1.0);
    return glm::vec3(equal + t * ((relative_error < 0 ? dark : bright) - equal));
}

SignedErrors signed_errors(const Plane& a, const Plane& truth, const Plane& error, const Image<std::uint8_t>& compared,
                           const SignedErrorOptions& options) {
    require_same_size(a, truth, "the truth");
    if (!error.empty()) require_same_size(a, error, "the standard error");
    if (!compared.empty()) require_same_size(a, compared, "the mask");
    require_amount(options.tolerance, "tolerance");
    require_amount(options.sigmas, "sigmas");
    Sums sums;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (compared.empty() || compared.texels[i] != 0)
            sums.add(a.texels[i], truth.texels[i], error.empty() ? 0 : error.texels[i], options);
    return result(sums);
}

Plane luminances(const Image4& rgb) {
    Plane plane(rgb.width, rgb.height);
    for (std::size_t i = 0; i < rgb.size(); ++i) plane.texels[i] = luminance(glm::dvec3(rgb.texels[i]));
    return plane;
}

}  // namespace plumb::compare
