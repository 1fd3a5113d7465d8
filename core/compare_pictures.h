// Pictures of a difference, and the judgements that "Imalyzer" (ISR 5.1.4) derives from them.
#pragma once

#include <optional>

#include "core/compare.h"

namespace plumb::compare {

enum class Difference {
    absolute,  // ISR (18): |a - b|
    negative,  // 1 - |a - b|, clamped to 0..1: what Imalyzer prints, white where the pictures are equal
    signed_,   // a - b
};

// The difference of each value, multiplied by the amplification (finite and above 0, else an InputError) before it is
// taken from 1. Pictures that cannot be compared are an InputError as well. A NaN stays one; Inf - Inf is NaN.
Picture difference(const Picture& a, const Picture& b, Difference kind = Difference::absolute,
                   double amplification = 1);

// ISR (17) of linear RGB.
double luminance(const glm::dvec3& rgb);

// ISR (21), from the mean errors of two pictures against one model: 1 if the first is closer to it, -1 if the second
// is, 0 if neither. A NaN is an InputError.
int quality(double mean_error_1, double mean_error_2);

// (e_before - e_after) / e_before, ISR 5.3.2: what share of the error the stage took away. None where there was none.
std::optional<double> gain(double mean_error_before, double mean_error_after);

// The share of pixels whose luminance (17) comes strictly closer to the model's from before to after. None if a picture
// has no RGB; an InputError if the pictures cannot be compared. A NaN improves nothing.
std::optional<double> share_improved(const Picture& model, const Picture& before, const Picture& after);

}  // namespace plumb::compare
