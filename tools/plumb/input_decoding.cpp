#include "tools/plumb/input_decoding.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/detmath_bounded.h"
#include "core/host_math.h"

namespace plumb::cli {

namespace {

constexpr double unit = 0x1p-23;  // of the last place of 1

Bounded about(double value, double bound) { return Bounded::within(float(value), value, bound); }
// The same value; a device's may be as far as what was computed along, and as that misses it.
Bounded about(double value, const Bounded& computed) {
    return about(value, computed.bound + std::fabs(computed.shadow - value));
}

// 2 c - 1 of a code that was converted to a float (1 unit) and rounds itself; 1 unit more where the conversion is a
// product with 1 / 255.
constexpr double biased_error = 5 * unit;
// Of x and y the same, or 2 units of a signed code. z = 1 - |x| - |y| and the folds take both and round twice: 12 units.
// The vector is at least 1 / sqrt 3 long, so that making it unit turns an error of 12 units in each component into at most
// sqrt 3 sqrt 3 12, and rounds 5 units itself.
constexpr double octahedral_error = 41 * unit;
// 1 - d (1 - n / f), which cancels: whether so, over f, or over f + n from 2 d - 1, it rounds four times a number of at
// most 1, and takes one that is rounded.
constexpr double depth_error = 5 * unit;

// A code over its largest, by a quotient or a product. 0 and 1 are exact.
Bounded converted(double v) { return about(v, v == 0 || std::fabs(v) == 1 ? 0 : unit * std::fabs(v)); }

// IEC 61966-2-1. Where both pieces meet a device may take either.
double srgb_bound(double linear) {
    const double code = linear <= 0.0031308 ? 12.92 * linear : 1.055 * host::pow(linear, 1 / 2.4) - 0.055;
    const Bounded c = about(code, unit * std::fabs(code));
    double bound = 0;
    if (code < 0.04046) bound = about(linear, c / Bounded(12.92f)).bound;
    if (code > 0.04044)
        bound = std::max(bound, about(linear, detmath::pow((c + Bounded(0.055)) / Bounded(1.055), Bounded(2.4))).bound);
    return bound + unit * std::fabs(linear);
}

bool is_vector(const std::string& encoding) {
    return encoding == "biased" || encoding.starts_with("octahedral") || encoding.starts_with("hemi");
}

}  // namespace

InputDecoding::InputDecoding(const io::DumpSpec& spec, const io::DumpedImage& dump)
    : spec_(spec),
      vectors_(is_vector(spec.encoding)),
      srgb_(spec.encoding == "srgb" || spec.vk_format.ends_with("_SRGB")),
      shared_exponent_(spec.encoding == "rgbe") {
    const bool fixed = dump.stored == Format::rgba8 || dump.stored == Format::normal8 ||
                       dump.stored == Format::r10g10b10a2 || dump.stored == Format::d24s8;
    fixed_point_ = spec.encoding == "plain" && fixed && !srgb_;
    if (spec.near_far.empty()) return;
    const std::size_t at = spec.channels.find_first_of("xyzwrgba");
    depth_ = at == std::string::npos ? 0 : int(at);
    integer_depth_ = spec.vk_format.find("NORM") != std::string::npos;
}

void InputDecoding::decode_vector(Bounded* v) const {
    for (int c = 0; c < 3; ++c)
        v[c] = about(v[c].shadow, spec_.encoding == "biased" ? biased_error : octahedral_error);
    if (!spec_.encoding.starts_with("hemi")) return;
    for (int c = 0; c < 2; ++c) v[c] = about(v[c].shadow, biased_error);
    v[2] = about(v[2].shadow, sqrt(max(Bounded(0.0f), Bounded(1.0f) - v[0] * v[0] - v[1] * v[1])));
}

Bounded InputDecoding::decoded_depth(double metres) const {
    const double n = spec_.near_far[0], f = spec_.near_far[1], of_code = integer_depth_ ? unit : 0;
    if (!std::isfinite(metres)) return Bounded(metres);
    if (spec_.encoding == "linear_depth") {
        const double d = (metres - n) / (f - n);
        return about(metres, about(n, unit * n) + about(d, of_code * std::fabs(d)) * about(f - n, unit * (f - n)));
    }
    // Of reversed depth it is a sum of n / f and d (1 - n / f), and does not cancel.
    const double divisor = n / metres, off = spec_.encoding == "reversed_depth" ? divisor * (depth_error + of_code)
                                                                                : depth_error + of_code;
    return about(metres, about(n, unit * n) / about(divisor, off));
}

void InputDecoding::decode(Bounded* v, SrgbBounds& known) const {
    if (vectors_) decode_vector(v);
    if (depth_ >= 0) v[depth_] = decoded_depth(v[depth_].shadow);
    for (int c = 0; c < 4 && fixed_point_; ++c) v[c] = converted(v[c].shadow);
    // The exponent's scale is exact; what it multiplies was converted and multiplied.
    for (int c = 0; c < 3 && shared_exponent_; ++c) v[c] = about(v[c].shadow, 3 * unit * std::fabs(v[c].shadow));
    for (int c = 0; c < 3 && srgb_; ++c) {
        const double linear = v[c].shadow;
        if (linear == 0 || !std::isfinite(linear)) continue;
        std::uint32_t bits;
        std::memcpy(&bits, &v[c].value, sizeof bits);
        const auto [at, first] = known.try_emplace(bits, 0.0);
        if (first) at->second = srgb_bound(linear);
        v[c] = about(linear, at->second);
    }
    if (srgb_ && spec_.vk_format.find("NORM") != std::string::npos) v[3] = converted(v[3].shadow);
}

}  // namespace plumb::cli
