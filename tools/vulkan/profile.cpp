#include "tools/vulkan/profile.h"

namespace plumb::vulkan {
namespace {

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

bool processor_fuses() {
#if defined(__x86_64__)
    return __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

const char* profile_name(const DeviceInfo& device) {
    if (has(device.name(), "SwiftShader")) return "swiftshader";
    if (!has(device.name(), "llvmpipe") || !has(device.driver_info, "Mesa 22.3.")) return "ideal";
    const bool fused = processor_fuses() && !has(device.name(), "128 bits");
    return fused ? "lavapipe-22.3-fma" : "lavapipe-22.3-sse4.1";
}

}  // namespace

const DeviceProfile& profile_of(const DeviceInfo& device) { return find_profile(profile_name(device), device.name()); }
const DeviceProfile& profile_of(const Device& device) { return profile_of(device.info()); }

}  // namespace plumb::vulkan
