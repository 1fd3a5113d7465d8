// Which device profile a driver fits, by what it says about itself.
#pragma once

#include "core/device_profile.h"
#include "tools/vulkan/device.h"

namespace plumb::vulkan {

// The profile that was measured on this driver, or "ideal". lavapipe rounds by the processor that it runs on: it fuses
// multiply-adds where the processor can, but not in vectors of 128 bits, which GALLIUM_OVERRIDE_CPU_CAPS=sse4.1 makes
// it take.
const DeviceProfile& profile_of(const DeviceInfo& device);
const DeviceProfile& profile_of(const Device& device);

}  // namespace plumb::vulkan
