// Where a picture is too dark and where too bright, against a truth that has a standard error of its own: what an
// approximation of visibility darkens that it should not, and where light leaks.
#pragma once

#include <cstdint>
#include <optional>

#include "core/image.h"

namespace plumb::compare {

// One number a pixel: luminance, say.
using Plane = Image<double>;

// (a - truth) / (|truth| + floor), without a unit: 0 where they are equal, an infinity where something is held against
// nothing, NaN where a, truth or error is no finite number. Of the difference, `sigmas` standard errors are taken off,
// down to 0: what is left is no noise. error: empty where the truth has none. Throws InputError for sizes that differ,
// and for a floor or sigmas that are negative or no numbers.
Plane relative_errors(const Plane& a, const Plane& truth, double floor, const Plane& error = {}, double sigmas = 0);

// sRGB-encoded: blue where too dark, red where too bright, white at 0, full colour at -1 and +1 `swing`; green for a
// NaN.
glm::vec3 signed_color(double relative_error, double swing);

struct SignedErrorOptions {
    double tolerance = 0.1;  // share of the local truth by which a pixel may be off
    double sigmas = 3;       // standard errors of the truth by which it may be off beside that
};

// Of the pixels that are compared. Everything fails closed: a pixel with a NaN or an infinity counts as wrong, and what
// is a sum over all pixels is none then; all is none, and nothing right, where no pixel is compared. Shares are of the
// compared pixels, the rest is relative to the truth's mean or sum, and none where that is not above 0.
struct SignedErrors {
    std::int64_t pixels = 0, nonfinite = 0;
    double too_dark = 0, too_bright = 0;  // shares: truth - a, or a - truth, > tolerance |truth| + sigmas error
    double wrong = 1;                     // share: too dark, too bright, or no number
    std::optional<double> mean_truth;     // not relative
    std::optional<double> mean_error;     // mean of a - truth
    std::optional<double> rms;            // root of the mean of (a - truth)^2, less the mean of error^2; at least 0
    std::optional<double> noise;          // root of the mean of error^2
    bool below_noise = false;             // the rms is within the noise, and 0
    // Sums of truth - a, or a - truth, where that is positive, less sigmas error each (at least 0): energy that is
    // wrongly removed, or leaks.
    std::optional<double> removed, leaked;
};

// error: the truth's standard error; empty: it has none. compared: pixels that are not 0 there; empty: all. Throws
// InputError for sizes that differ and options that are negative or no numbers.
SignedErrors signed_errors(const Plane& a, const Plane& truth, const Plane& error = {},
                           const Image<std::uint8_t>& compared = {}, const SignedErrorOptions& options = {});

// Luminance by ISR (17) of xyz.
Plane luminances(const Image4& rgb);
// Its standard error from those of the channels, if these err together: an upper bound.
inline Plane luminance_errors(const Image4& errors) { return luminances(errors); }

}  // namespace plumb::compare
