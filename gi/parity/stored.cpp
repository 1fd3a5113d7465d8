#include "gi/parity/stored.h"

#include <algorithm>
#include <cmath>

namespace plumb::parity {

namespace {

// One unit in the last place of a float with that many fraction bits, whose least normal number is 2^least.
double unit(double x, int bits, int least) {
    const double magnitude = std::max(std::abs(x), std::ldexp(1.0, least));
    return std::ldexp(1.0, std::ilogb(magnitude) - bits);
}

StoredRange floating(double low, double high, int bits, int least, double largest) {
    low = std::max(low - unit(low, bits, least), -largest), high = std::min(high + unit(high, bits, least), largest);
    // Beyond the largest number lies infinity, and a device may stay finite.
    return {low <= -largest ? -HUGE_VAL : low, high >= largest ? HUGE_VAL : high};
}

// Steps of 1 / codes in [least, 1].
StoredRange fixed(double low, double high, double codes, double least) {
    const double step = 1 / codes;
    return {std::clamp(low, least, 1.0) - step, std::clamp(high, least, 1.0) + step};
}

StoredRange wider(double low, double high, double by) { return {low - by, high + by}; }

}  // namespace

bool is_exact(Format format) { return format == Format::rgba32f || format == Format::r32f; }

StoredRange stored_range(Format format, int c, double low, double high, double largest, const DeviceProfile&) {
    switch (format) {
        case Format::rgba32f:
        case Format::r32f: return {low, high};
        case Format::r16f:
        case Format::rgba16f: return floating(low, high, 10, -14, 65504);
        case Format::rgba8: return fixed(low, high, 255, 0);
        case Format::r11g11b10f: {
            const StoredRange r = c == 2 ? floating(low, high, 5, -14, 64512) : floating(low, high, 6, -14, 65024);
            return {std::max(r.low, 0.0), std::max(r.high, 0.0)};
        }
        case Format::r10g10b10a2: return fixed(low, high, c == 3 ? 3 : 1023, 0);
        case Format::d32f: return {std::clamp(low, 0.0, 1.0), std::clamp(high, 0.0, 1.0)};
        case Format::d24s8: return fixed(low, high, 16777215, 0);
        // Vectors: a step of the square or of the components moves no component by more than these (the octahedral map
        // stretches by at most sqrt(3) a component; two steps, and as much again for folding and normalisation).
        case Format::octahedral16: return wider(low, high, 4.0 / 32767);
        case Format::octahedral8: return wider(low, high, 4.0 / 127);
        case Format::normal8: return wider(low, high, 2.0 / 255);
        // The shared exponent is of the largest component: mantissas are steps of at most 2 / 255 of it.
        case Format::rgbe: return {std::max(low - 2 * largest / 255, 0.0), high + 2 * largest / 255};
    }
    return {low, high};
}

}  // namespace plumb::parity
