#include "core/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/compare_metrics.h"
#include "core/error.h"
#include "core/ssim.h"

namespace plumb::compare {
namespace {

void check(const Options& options) {
    auto require = [](bool holds, const char* name, double value, const char* range) {
        if (!holds) throw InputError(fmt::format("compare: {} is {}, expected {}", name, value, range));
    };
    if (options.max_error) require(*options.max_error >= 0, "max_error", *options.max_error, "at least 0");
    if (options.max_differing) {
        const double share = *options.max_differing;
        require(share >= 0 && share <= 1, "max_differing", share, "a share from 0 to 1");
    }
    if (options.peak) {
        const double peak = *options.peak;
        require(peak > 0 && std::isfinite(peak), "peak", peak, "a finite value above 0");
    }
    const double density = options.pixels_per_degree;
    require(density >= 1 && density <= 1000, "pixels_per_degree", density, "1 to 1000");
    require(options.threads >= 0, "threads", options.threads, "at least 0");
}

// The peak of PSNR and the dynamic range of SSIM; not positive if b has no light.
double peak_of(const Picture& b, const Options& options) {
    if (options.peak) return *options.peak;
    if (options.encoding != Encoding::hdr) return 1;
    return *std::max_element(b.data.begin(), b.data.end());
}

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ",")); }

std::string describe_size(const Picture& p) { return fmt::format("{} x {}", p.width, p.height); }

// Names the first value that is not finite, a before b.
std::string describe_nonfinite(const Picture& a, const Picture& b, std::int64_t count) {
    const std::size_t channels = a.channels.size();
    for (std::size_t i = 0; i < a.data.size(); ++i) {
        const bool in_a = !std::isfinite(a.data[i]);
        if (!in_a && std::isfinite(b.data[i])) continue;
        const std::size_t pixel = i / channels;
        return fmt::format("{} {} NaN or Inf; first: {}({}, {}).{} = {}", count,
                           count == 1 ? "pixel holds" : "pixels hold", in_a ? "A" : "B", pixel % a.width,
                           pixel / a.width, a.channels[i % channels], in_a ? a.data[i] : b.data[i]);
    }
    return {};
}

// Names the first bound that does not hold. Written so that a missing metric is over every bound.
std::string broken_bound(const Report& report, const Options& options) {
    if (options.max_error && !(report.mean_error && *report.mean_error <= *options.max_error)) {
        return fmt::format("mean error {} is above the bound {}", report.mean_error.value_or(0), *options.max_error);
    }
    if (options.max_ulp && !(report.max_ulp <= *options.max_ulp)) {
        return fmt::format("largest distance of {} ULP is above the bound {}", report.max_ulp, *options.max_ulp);
    }
    if (options.max_differing && !(report.differing <= *options.max_differing)) {
        return fmt::format("share of differing pixels {} is above the bound {}", report.differing,
                           *options.max_differing);
    }
    return {};
}

Image<double> luminance(const Image<glm::dvec3>& rgb) {
    Image<double> out(rgb.width, rgb.height);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        out.texels[i] = glm::dot(glm::dvec3(0.2126, 0.7152, 0.0722), rgb.texels[i]);
    }
    return out;
}

// SSIM looks at the values as they are, encoded or not; FLIP at the light that the display emits.
void perceive_differences(const Picture& a, const Picture& b, double peak, const Options& options, Report& report) {
    const Encoding as_is = Encoding::hdr;
    const auto raw_a = linear_rgb(a, as_is), raw_b = linear_rgb(b, as_is);
    if (!raw_a || !raw_b) return;
    report.ssim = ssim(luminance(*raw_a), luminance(*raw_b), peak, options.threads);
    if (report.equal) {
        report.flip = 0;
    } else if (options.encoding == Encoding::hdr) {
        report.flip = flip_hdr(*raw_b, *raw_a, options.pixels_per_degree, options.threads).mean;
    } else {
        const auto light_a = linear_rgb(a, options.encoding), light_b = linear_rgb(b, options.encoding);
        report.flip = flip_ldr(*light_b, *light_a, options.pixels_per_degree, options.threads).mean;
    }
}

}  // namespace

std::string mismatch(const Picture& a, const Picture& b) {
    for (const auto& [picture, name] : {std::pair(&a, "A"), std::pair(&b, "B")}) {
        if (picture->width <= 0 || picture->height <= 0 || picture->channels.empty()) {
            return fmt::format("{} is empty: {} pixels, {} channels", name, describe_size(*picture),
                               picture->channels.size());
        }
        const std::size_t expected = std::size_t(picture->width) * picture->height * picture->channels.size();
        if (picture->data.size() != expected) {
            return fmt::format("{} holds {} values, expected {}", name, picture->data.size(), expected);
        }
    }
    if (a.width != b.width || a.height != b.height) {
        return fmt::format("sizes differ: A is {}, B is {}", describe_size(a), describe_size(b));
    }
    if (a.channels != b.channels) {
        return fmt::format("channels differ: A has {}, B has {}", joined(a.channels), joined(b.channels));
    }
    return {};
}

std::optional<Image<glm::dvec3>> linear_rgb(const Picture& picture, Encoding encoding) {
    const int channels = int(picture.channels.size());
    int index[3] = {-1, -1, -1};
    for (int c = 0; c < channels; ++c) {
        const std::string& name = picture.channels[c];
        const std::size_t dot = name.rfind('.'), start = dot == std::string::npos ? 0 : dot + 1;
        const std::size_t which = std::string("RGB").find(name.substr(start));
        if (name.size() != start + 1 || which == std::string::npos) continue;
        if (index[which] >= 0) return std::nullopt;  // two layers: which one is meant?
        index[which] = c;
    }
    if (channels == 1) index[0] = index[1] = index[2] = 0;
    if (index[0] < 0 || index[1] < 0 || index[2] < 0) return std::nullopt;

    Image<glm::dvec3> rgb(picture.width, picture.height);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = picture.data[i * channels + index[k]];
            rgb.texels[i][k] = encoding == Encoding::ldr_srgb ? srgb_to_linear(value) : value;
        }
    }
    return rgb;
}

Report compare(const Picture& a, const Picture& b, const Options& options) {
    check(options);
    Report report;
    report.sizes_match = a.width == b.width && a.height == b.height;
    report.channels_match = a.channels == b.channels;
    if (a.width > 0 && a.height > 0) report.pixels = std::int64_t(a.width) * a.height;
    report.reason = mismatch(a, b);
    if (!report.reason.empty()) return report;

    count_differences(a, b, options.threads, report);
    if (report.nonfinite > 0) {
        report.reason = describe_nonfinite(a, b, report.nonfinite);
        return report;
    }
    const double peak = peak_of(b, options);
    sum_differences(a, b, peak, options.threads, report);
    if (options.perceptual) perceive_differences(a, b, peak, options, report);
    report.reason = broken_bound(report, options);
    report.agree = report.reason.empty();
    return report;
}

}  // namespace plumb::compare
