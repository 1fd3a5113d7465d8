// What a format makes of a value that is known to lie in an interval: how far a store may move it.
#pragma once

#include "core/device_profile.h"
#include "core/formats.h"

namespace plumb::parity {

struct StoredRange {
    double low, high;
};

// True where a float comes back as it was stored.
bool is_exact(Format format);

// Every value that component c may come back with where the shader wrote one of [low, high]: a store takes either
// neighbour in the format (Vulkan 1.3: 3.9.2, fixed point; 2.10.1 and 2.10.2, floats of 16, 11 and 10 bits), and a value
// that the format holds stays. How a device rounds to halves a profile may say, and then it does only that. What a
// shader packs itself (vectors, rgbe) may move by a step. `largest` is the largest magnitude among the texel's
// components: rgbe shares an exponent.
StoredRange stored_range(Format format, int c, double low, double high, double largest, const DeviceProfile& profile);

}  // namespace plumb::parity
