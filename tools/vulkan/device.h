// A Vulkan 1.1 device without a window: choice by name, one queue, submission that waits.
//
// Plain structs that own what they name: each destroys itself, and the Device must outlive all that was made from it.
// Every failure is an Error of one line.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"

namespace plumb::vulkan {

// What another device, another driver or a smaller frame would mend.
struct Error : InputError {
    using InputError::InputError;
};

// Throws Error "<what>: <name of the result>" unless the call succeeded.
void check(VkResult result, const std::string& what);

// A structure of Vulkan's that says which one it is, otherwise 0.
template <class T>
T structure(VkStructureType type) {
    T out{};
    out.sType = type;
    return out;
}

// A handle that belongs to a device.
template <class Handle, void (*destroy)(VkDevice, Handle, const VkAllocationCallbacks*)>
class Owned {
  public:
    Owned() = default;
    Owned(VkDevice device, Handle handle) : device_(device), handle_(handle) {}
    Owned(Owned&& other) noexcept { swap(other); }
    Owned& operator=(Owned&& other) noexcept {
        swap(other);
        return *this;
    }
    ~Owned() {
        if (handle_) destroy(device_, handle_, nullptr);
    }
    Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

  private:
    void swap(Owned& other) {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
    }
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_ = VK_NULL_HANDLE;
};

struct DeviceInfo {
    int index = 0;  // in the loader's order
    VkPhysicalDeviceProperties properties{};
    VkPhysicalDeviceFeatures features{};
    std::string driver_name, driver_info;  // "llvmpipe", "Mesa 22.3.6 (LLVM 15.0.6)"; empty where it does not say

    std::string name() const { return properties.deviceName; }
    std::string type() const;  // "processor", "discrete GPU", ...
};

// All devices that the loader finds, in its order; empty where there is no driver.
std::vector<DeviceInfo> list_devices();
std::vector<std::string> device_names();

struct DeviceOptions {
    std::string name;       // a part of the device's name: "llvmpipe"; or its index; empty: the first device
    bool validate = false;  // through VK_LAYER_KHRONOS_validation, where it is installed
};

class Device {
  public:
    // Throws Error that lists the devices there are where none has that name.
    explicit Device(const DeviceOptions& options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkDevice get() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    const DeviceInfo& info() const { return info_; }
    std::string name() const { return info_.name(); }
    const VkPhysicalDeviceProperties& properties() const { return info_.properties; }
    const VkPhysicalDeviceLimits& limits() const { return info_.properties.limits; }
    // What was switched on, of that what the device has: see wanted_features() in device.cpp.
    const VkPhysicalDeviceFeatures& features() const { return features_; }
    bool validated() const { return messenger_ != VK_NULL_HANDLE; }
    // What the validation layer has said so far.
    const std::vector<std::string>& complaints() const { return *complaints_; }
    bool has_timestamps() const { return timestamp_bits_ > 0; }

    // A type of memory among `types` (VkMemoryRequirements) that has all of `wanted`.
    std::uint32_t memory_type(std::uint32_t types, VkMemoryPropertyFlags wanted) const;

    // A new command buffer with what `write(VkCommandBuffer)` puts into it; it lives as long as the device.
    template <class Write>
    VkCommandBuffer record(Write&& write) const {
        const VkCommandBuffer commands = begin();
        write(commands);
        check(vkEndCommandBuffer(commands), "Vulkan: vkEndCommandBuffer");
        return commands;
    }
    // Submits and waits: milliseconds of wall clock from one to the other.
    double submit(VkCommandBuffer commands) const;
    void free(VkCommandBuffer commands) const { vkFreeCommandBuffers(device_, pool_, 1, &commands); }
    // record(), submit() and free().
    template <class Write>
    void run(Write&& write) const {
        const VkCommandBuffer commands = record(std::forward<Write>(write));
        submit(commands);
        free(commands);
    }

  private:
    VkCommandBuffer begin() const;
    void create_instance(bool validate);
    void create_device(const std::string& name);
    void destroy();

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    DeviceInfo info_;
    VkPhysicalDeviceFeatures features_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    std::uint32_t timestamp_bits_ = 0;
    std::unique_ptr<std::vector<std::string>> complaints_ = std::make_unique<std::vector<std::string>>();
};

// The device's own clock at two points of a command buffer.
class Stopwatch {
  public:
    explicit Stopwatch(const Device& device);
    void start(VkCommandBuffer commands) const;  // outside of a render pass
    void stop(VkCommandBuffer commands) const;
    double ms() const;  // of the last submission; 0 where the device has no timestamps

  private:
    const Device& device_;
    Owned<VkQueryPool, vkDestroyQueryPool> queries_;
};

}  // namespace plumb::vulkan
