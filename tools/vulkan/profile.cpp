#include "tools/vulkan/profile.h"

namespace plumb::vulkan {
namespace {

bool processor_fuses() {
#if defined(__x86_64__)
    return __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

}  // namespace

// Of lavapipe's two profiles the processor decides, or what it was told of the processor: 128 bits are SSE.
const DeviceProfile& profile_of(const DeviceInfo& device) {
    const std::string text = device.driver_name + ", " + device.driver_info + ", " + device.name();
    const bool fused = processor_fuses() && device.name().find("128 bits") == std::string::npos;
    for (const DeviceProfile& p : device_profiles()) {
        const bool fits = p.interpolation != Interpolation::plane_equation || p.fused_raster == fused;
        if (fits && !p.driver.empty() && text.find(p.driver) != std::string::npos && device.name().find(p.device) != std::string::npos) return p;
    }
    return find_profile("ideal", device.name());
}
const DeviceProfile& profile_of(const Device& device) { return profile_of(device.info()); }

}  // namespace plumb::vulkan
