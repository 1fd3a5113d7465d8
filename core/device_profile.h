// Device profiles: how a GPU or its driver rounds, as data.
//
// A kernel never asks for the device. What differs between devices is how triangles become pixels, how stores round, and
// how much a single operation may err; a profile states it, from a specification or from probes (`plumb probe-device`).
#pragma once

#include <string>
#include <vector>

#include "core/formats.h"

namespace plumb {

// What one operation may err, in units in the last place of its result, unless said otherwise (Vulkan 1.3, appendix
// "Precision and Operation of SPIR-V Instructions"). 0.5 is correctly rounded.
struct Precision {
    double add = 1, multiply = 1;       // either neighbour: the rounding mode is not declared
    double divide = 2.5;
    double inverse_sqrt = 2;
    double sqrt = 4.5;                  // inherited from 1 / inversesqrt(x): ulps of 1/x and of the inverse root, added
    double exp2 = 3, exp2_slope = 2;    // 3 + 2 |x|; exp(x) alike; pow(x, y) is inherited from exp2(y * log2(x))
    double log2 = 3;                    // or, near 1, absolute:
    double log2_absolute = 0x1p-21;
    bool flushes_denormals = true;      // a device may take denormal operands and results for 0
};

enum class Interpolation : int {
    ideal,           // from exact edge functions
    plane_equation,  // a0 + dadx x + dady y in float, anchored at the framebuffer's origin (raster/README.md)
    snapped_planes,  // the same through the snapped corners, anchored at one of them
};

struct DeviceProfile {
    std::string name = "ideal";
    std::string driver;                 // what a driver says of itself, name and version; "" for any
    std::string device = {};            // a part of the device's name; "" for any
    // Rasterisation.
    int subpixel_bits = 8;
    Interpolation interpolation = Interpolation::ideal;
    bool fused_raster = false;          // window positions and planes take fused multiply-adds
    double snap_uncertainty = 1;        // by how much a device may place a vertex elsewhere, in units of its snapping grid
    // Stores and filters.
    HalfStore half_store = HalfStore::nearest;
    bool half_store_either = true;      // the specification allows both
    int bilinear_weight_bits = 8;       // least fraction bits of a filter's weights; 0: fp32 weights
    // Arithmetic.
    Precision precision;
};

// ideal (the default: the Vulkan specification, and exact rasterisation), lavapipe-22.3-fma, lavapipe-22.3-sse4.1,
// swiftshader, nvidia-hopper-580.
const std::vector<DeviceProfile>& device_profiles();
// Throws InputError at `place` that names the nearest known one.
const DeviceProfile& find_profile(const std::string& name, const std::string& place);

}  // namespace plumb
