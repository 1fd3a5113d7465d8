#include "core/compare_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace plumb::compare {
namespace {

void require_comparable(const Picture& a, const Picture& b) {
    const std::string reason = mismatch(a, b);
    if (!reason.empty()) throw InputError("compare: " + reason);
}

}  // namespace

Picture difference(const Picture& a, const Picture& b, Difference kind, double amplification) {
    require_comparable(a, b);
    if (!(amplification > 0) || !std::isfinite(amplification)) {
        throw InputError(fmt::format("compare: amplification is {}, expected a finite value above 0", amplification));
    }
    Picture out = a;
    for (std::size_t i = 0; i < out.data.size(); ++i) {
        double value = amplification * (double(a.data[i]) - double(b.data[i]));
        if (kind != Difference::signed_) value = std::abs(value);
        if (kind == Difference::negative) value = value > 1 ? 0 : 1 - value;  // a NaN stays NaN
        out.data[i] = float(value);
    }
    return out;
}

double luminance(const glm::dvec3& rgb) { return 0.27 * rgb.x + 0.67 * rgb.y + 0.06 * rgb.z; }

int quality(double mean_error_1, double mean_error_2) {
    if (std::isnan(mean_error_1) || std::isnan(mean_error_2)) throw InputError("compare: a mean error is NaN");
    return int(mean_error_1 < mean_error_2) - int(mean_error_1 > mean_error_2);
}

std::optional<double> gain(double mean_error_before, double mean_error_after) {
    if (!(mean_error_before > 0)) return std::nullopt;
    return (mean_error_before - mean_error_after) / mean_error_before;
}

std::optional<double> share_improved(const Picture& model, const Picture& before, const Picture& after) {
    require_comparable(before, model);
    require_comparable(after, model);
    const auto rgb_model = linear_rgb(model, Encoding::hdr), rgb_before = linear_rgb(before, Encoding::hdr),
               rgb_after = linear_rgb(after, Encoding::hdr);
    if (!rgb_model || !rgb_before || !rgb_after) return std::nullopt;
    std::size_t improved = 0;
    for (std::size_t i = 0; i < rgb_model->size(); ++i) {
        const double truth = luminance(rgb_model->texels[i]);
        improved += std::abs(luminance(rgb_after->texels[i]) - truth) <
                    std::abs(luminance(rgb_before->texels[i]) - truth);
    }
    return double(improved) / double(rgb_model->size());
}

}  // namespace plumb::compare
