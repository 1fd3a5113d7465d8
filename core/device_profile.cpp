#include "core/device_profile.h"

#include "core/error.h"
#include "core/nearest_known.h"

namespace plumb {

namespace {

// + - * / sqrt as IEEE 754 rounds them, denormals kept: so measured on lavapipe, 2^19 inputs an operation.
Precision correctly_rounded() {
    Precision p;
    p.add = p.multiply = p.divide = p.sqrt = 0.5;
    p.inverse_sqrt = 1.5;  // 1 / sqrt(x), two roundings
    p.flushes_denormals = false;
    return p;
}

// Mesa 22.3's software rasteriser. What a name cannot tell is whether its processor has fused multiply-adds.
DeviceProfile lavapipe(const char* name, bool fused) {
    DeviceProfile d;
    d.name = name;
    d.driver = "llvmpipe, Mesa 22.3.";
    d.interpolation = Interpolation::plane_equation;
    d.fused_raster = fused;
    d.snap_uncertainty = 0;  // its window positions are emulated to the bit
    d.half_store = HalfStore::truncate;
    d.half_store_either = false;
    d.bilinear_weight_bits = 0;
    d.precision = correctly_rounded();
    // Its exp2 and log2 are polynomials: 3.4 units and, of exp, 62 at |x| = 83; 1.9e-6.
    d.precision.exp2 = 3.5;
    d.precision.exp2_slope = 1.2;
    d.precision.log2_absolute = 2e-6;
    return d;
}

DeviceProfile swiftshader() {
    DeviceProfile d;
    d.name = "swiftshader";
    d.driver = "SwiftShader";
    d.subpixel_bits = 4;
    d.interpolation = Interpolation::snapped_planes;
    d.snap_uncertainty = 0;  // its window positions are emulated to the bit
    // Its halves are the nearest, but for numbers just above 2^-25, which become 0.
    d.bilinear_weight_bits = 0;
    d.precision = correctly_rounded();
    d.precision.flushes_denormals = true;
    return d;
}

// Measured on an H100 with driver 580.159.04, 2^16 inputs an operation (data/parity/nvidia.md), and rounded up. Its interpolation is
// none that is known.
DeviceProfile nvidia_hopper() {
    DeviceProfile d;
    d.name = "nvidia-hopper-580";
    d.driver = "NVIDIA, 580.";
    d.device = "NVIDIA H";
    d.half_store = HalfStore::truncate;
    d.half_store_either = false;
    d.precision.add = d.precision.multiply = 0.5;
    d.precision.divide = 2;
    d.precision.inverse_sqrt = 1.5;
    d.precision.sqrt = 1;
    d.precision.exp2 = 2, d.precision.exp2_slope = 1.2;
    d.precision.log2_absolute = 2.5e-7;
    return d;
}

}  // namespace

const std::vector<DeviceProfile>& device_profiles() {
    static const std::vector<DeviceProfile> profiles = {DeviceProfile{}, lavapipe("lavapipe-22.3-fma", true),
                                                        lavapipe("lavapipe-22.3-sse4.1", false), swiftshader(), nvidia_hopper()};
    return profiles;
}

const DeviceProfile& find_profile(const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const DeviceProfile& d : device_profiles()) {
        if (d.name == name) return d;
        names.push_back(d.name);
    }
    throw InputError(place + ": device profile \"" + name + "\" is unknown" + nearest_known(name, names, "\"\""));
}

}  // namespace plumb
