#include "gi/parity/stored.h"

#include <algorithm>
#include <cmath>

namespace plumb::parity {

namespace {

// One unit in the last place of a float with that many fraction bits, whose least normal number is 2^-14.
double unit(double x, int bits) {
    const double magnitude = std::max(std::abs(x), 0x1p-14);
    return std::ldexp(1.0, std::ilogb(magnitude) - bits);
}

// The neighbours at or below low, and at or above high. Beyond the largest number lies infinity, and a device may stay
// finite.
StoredRange floating(double low, double high, int bits, double largest) {
    auto below = [&](double x) {
        if (x < -largest) return -HUGE_VAL;
        return x > largest ? largest : std::floor(x / unit(x, bits)) * unit(x, bits);
    };
    return {below(low), -below(-high)};
}

StoredRange half(double low, double high, const DeviceProfile& profile) {
    if (profile.half_store_either) return floating(low, high, 10, 65504);
    auto stored = [&](double x) { return double(half_to_float(float_to_half(float(x), profile.half_store))); };
    return {stored(low), stored(high)};
}

// Unsigned: what is less than 0 becomes 0.
StoredRange small_float(double low, double high, int bits, double largest) {
    return floating(std::max(low, 0.0), std::max(high, 0.0), bits, largest);
}

// Codes 0 .. `codes` of [0, 1]. Whoever decoded them rounded to float, and may have taken a product for the quotient.
StoredRange fixed(double low, double high, double codes, double decoding = 0x1p-22) {
    return {std::floor(std::clamp(low, 0.0, 1.0) * codes) / codes * (1 - decoding),
            std::ceil(std::clamp(high, 0.0, 1.0) * codes) / codes * (1 + decoding)};
}

StoredRange wider(double low, double high, double by) { return {low - by, high + by}; }

}  // namespace

bool is_exact(Format format) { return format == Format::rgba32f || format == Format::r32f; }

StoredRange stored_range(Format format, int c, double low, double high, double largest, const DeviceProfile& profile) {
    if (is_exact(format)) return {low, high};
    if (c >= info(format).channels) {
        glm::vec4 missing(0, 0, 0, 1);
        quantise(format, missing);
        return {missing[c], missing[c]};
    }
    switch (format) {
        case Format::rgba32f:
        case Format::r32f: break;
        case Format::r16f:
        case Format::rgba16f: return half(low, high, profile);
        case Format::rgba8: return fixed(low, high, 255);
        case Format::r11g11b10f: return c == 2 ? small_float(low, high, 5, 64512) : small_float(low, high, 6, 65024);
        case Format::r10g10b10a2: return fixed(low, high, c == 3 ? 3 : 1023);
        case Format::d32f: return {std::clamp(low, 0.0, 1.0), std::clamp(high, 0.0, 1.0)};
        case Format::d24s8:
            if (c == 1) return {std::floor(std::clamp(low, 0.0, 255.0)), std::ceil(std::clamp(high, 0.0, 255.0))};
            return fixed(low, high, 16777215, 0x1p-24);
        // A step of the square or of the components moves no component by more than these (the octahedral map stretches
        // by at most sqrt(3) a component; two steps, and as much again for folding and normalisation).
        case Format::octahedral16: return wider(low, high, 4.0 / 32767);
        case Format::octahedral8: return wider(low, high, 4.0 / 127);
        case Format::normal8: return wider(low, high, 2.0 / 255);
        // The shared exponent is of the largest component: mantissas are steps of at most 2 / 255 of it.
        case Format::rgbe: return {std::max(low - 2 * largest / 255, 0.0), high + 2 * largest / 255};
    }
    return {low, high};
}

}  // namespace plumb::parity
