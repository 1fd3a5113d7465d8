#include "tools/vulkan/device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstring>

namespace plumb::vulkan {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

bool has_validation_layer() {
    std::uint32_t n = 0;
    vkEnumerateInstanceLayerProperties(&n, nullptr);
    std::vector<VkLayerProperties> layers(n);
    vkEnumerateInstanceLayerProperties(&n, layers.data());
    return std::any_of(layers.begin(), layers.end(),
                       [](const VkLayerProperties& l) { return std::strcmp(l.layerName, validation_layer) == 0; });
}

VkInstance make_instance(const void* next, const std::vector<const char*>& layers,
                         const std::vector<const char*>& extensions) {
    auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
    application.pApplicationName = "plumb";
    application.apiVersion = VK_API_VERSION_1_1;
    auto info = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
    info.pNext = next;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = std::uint32_t(layers.size());
    info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = std::uint32_t(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    VkInstance instance = VK_NULL_HANDLE;
    check(vkCreateInstance(&info, nullptr, &instance), "Vulkan: vkCreateInstance");
    return instance;
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
    std::uint32_t n = 0;
    if (vkEnumeratePhysicalDevices(instance, &n, nullptr) != VK_SUCCESS) return {};
    std::vector<VkPhysicalDevice> devices(n);
    check(vkEnumeratePhysicalDevices(instance, &n, devices.data()), "Vulkan: vkEnumeratePhysicalDevices");
    devices.resize(n);
    return devices;
}

bool has_extension(VkPhysicalDevice device, const char* name) {
    std::uint32_t n = 0;
    vkEnumerateDeviceExtensionProperties(device, nullptr, &n, nullptr);
    std::vector<VkExtensionProperties> extensions(n);
    vkEnumerateDeviceExtensionProperties(device, nullptr, &n, extensions.data());
    return std::any_of(extensions.begin(), extensions.end(),
                       [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, name) == 0; });
}

DeviceInfo info_of(VkPhysicalDevice device, int index) {
    DeviceInfo info;
    info.index = index;
    vkGetPhysicalDeviceProperties(device, &info.properties);
    vkGetPhysicalDeviceFeatures(device, &info.features);
    if (info.properties.apiVersion < VK_API_VERSION_1_1 ||
        !has_extension(device, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME))
        return info;
    auto driver = structure<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
    auto properties = structure<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
    properties.pNext = &driver;
    vkGetPhysicalDeviceProperties2(device, &properties);
    info.driver_name = driver.driverName;
    info.driver_info = driver.driverInfo;
    return info;
}

std::vector<DeviceInfo> infos_of(const std::vector<VkPhysicalDevice>& devices) {
    std::vector<DeviceInfo> out;
    for (VkPhysicalDevice device : devices) out.push_back(info_of(device, int(out.size())));
    return out;
}

std::vector<std::string> names_of(const std::vector<DeviceInfo>& devices) {
    std::vector<std::string> names;
    for (const DeviceInfo& device : devices) names.push_back(device.name());
    return names;
}

// The first device whose name has `name` in it, or which has that index.
const DeviceInfo& choose(const std::vector<DeviceInfo>& devices, const std::string& name) {
    if (devices.empty()) throw Error("Vulkan: no device (for a software driver, install mesa-vulkan-drivers)");
    for (const DeviceInfo& device : devices)
        if (name == std::to_string(device.index)) return device;
    for (const DeviceInfo& device : devices)
        if (device.name().find(name) != std::string::npos) return device;
    throw Error(fmt::format("Vulkan: no device named \"{}\"; there are: {}", name, fmt::join(names_of(devices), ", ")));
}

// What a twin may need or what makes a wrong one harmless, where the device has it: tapped fragment stages write to a
// buffer, and reads beyond the end of one must not end the program.
VkPhysicalDeviceFeatures wanted_features(const VkPhysicalDeviceFeatures& there) {
    VkPhysicalDeviceFeatures out{};
    out.robustBufferAccess = there.robustBufferAccess;
    out.fragmentStoresAndAtomics = there.fragmentStoresAndAtomics;
    out.vertexPipelineStoresAndAtomics = there.vertexPipelineStoresAndAtomics;
    return out;
}

VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                        const VkDebugUtilsMessengerCallbackDataEXT* data, void* complaints) {
    static_cast<std::vector<std::string>*>(complaints)->push_back(data->pMessage);
    return VK_FALSE;
}

}  // namespace

void check(VkResult result, const std::string& what) {
    if (result == VK_SUCCESS) return;
    for (const auto& [value, name] : std::initializer_list<std::pair<VkResult, const char*>>{
             {VK_ERROR_OUT_OF_HOST_MEMORY, "out of host memory"},
             {VK_ERROR_OUT_OF_DEVICE_MEMORY, "out of device memory"},
             {VK_ERROR_INITIALIZATION_FAILED, "initialisation failed"},
             {VK_ERROR_DEVICE_LOST, "the device is lost"},
             {VK_ERROR_TOO_MANY_OBJECTS, "too many objects"},
             {VK_ERROR_FEATURE_NOT_PRESENT, "the device lacks a feature"},
             {VK_ERROR_INCOMPATIBLE_DRIVER, "no driver (for a software one, install mesa-vulkan-drivers)"},
             {VK_ERROR_FORMAT_NOT_SUPPORTED, "this format is not supported"},
         })
        if (result == value) throw Error(fmt::format("{}: {}", what, name));
    throw Error(fmt::format("{}: VkResult {}", what, int(result)));
}

std::string DeviceInfo::type() const {
    switch (properties.deviceType) {
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return "integrated GPU";
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return "discrete GPU";
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return "virtual GPU";
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return "processor";
        default:
            return "other";
    }
}

std::vector<DeviceInfo> list_devices() {
    VkInstance instance = VK_NULL_HANDLE;
    try {
        instance = make_instance(nullptr, {}, {});
    } catch (const Error&) {
        return {};  // no driver is installed
    }
    const std::vector<DeviceInfo> devices = infos_of(physical_devices(instance));
    vkDestroyInstance(instance, nullptr);
    return devices;
}

std::vector<std::string> device_names() { return names_of(list_devices()); }

void Device::create_instance(bool validate) {
    if (!validate || !has_validation_layer()) {
        instance_ = make_instance(nullptr, {}, {});
        return;
    }
    auto info = structure<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    info.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = complain;
    info.pUserData = complaints_.get();
    instance_ = make_instance(&info, {validation_layer}, {VK_EXT_DEBUG_UTILS_EXTENSION_NAME});
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    check(create(instance_, &info, nullptr, &messenger_), "Vulkan: vkCreateDebugUtilsMessengerEXT");
}

void Device::create_device(const std::string& name) {
    const std::vector<VkPhysicalDevice> devices = physical_devices(instance_);
    info_ = choose(infos_of(devices), name);
    physical_ = devices[std::size_t(info_.index)];
    if (info_.properties.apiVersion < VK_API_VERSION_1_1)
        throw Error(fmt::format("Vulkan: {} knows Vulkan 1.0 alone; expected 1.1", info_.name()));
    features_ = wanted_features(info_.features);
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);

    // Take the first family of queues that draws and computes.
    std::uint32_t n = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &n, nullptr);
    std::vector<VkQueueFamilyProperties> families(n);
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &n, families.data());
    const auto family = std::find_if(families.begin(), families.end(), [](const VkQueueFamilyProperties& f) {
        return (f.queueFlags & VK_QUEUE_GRAPHICS_BIT) && (f.queueFlags & VK_QUEUE_COMPUTE_BIT);
    });
    if (family == families.end())
        throw Error(fmt::format("Vulkan: {} has no queue that draws and computes", info_.name()));
    timestamp_bits_ = family->timestampValidBits;

    const float priority = 1;
    auto queue = structure<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = std::uint32_t(family - families.begin());
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    auto info = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.pEnabledFeatures = &features_;
    check(vkCreateDevice(physical_, &info, nullptr, &device_), "Vulkan: vkCreateDevice");
    vkGetDeviceQueue(device_, queue.queueFamilyIndex, 0, &queue_);

    auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.queueFamilyIndex = queue.queueFamilyIndex;
    check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "Vulkan: vkCreateCommandPool");
    const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    check(vkCreateFence(device_, &fence, nullptr, &fence_), "Vulkan: vkCreateFence");
}

Device::Device(const DeviceOptions& options) {
    try {
        create_instance(options.validate);
        create_device(options.name);
    } catch (...) {
        destroy();
        throw;
    }
}

Device::~Device() { destroy(); }

void Device::destroy() {
    if (device_) {
        vkDeviceWaitIdle(device_);
        vkDestroyFence(device_, fence_, nullptr);
        vkDestroyCommandPool(device_, pool_, nullptr);
        vkDestroyDevice(device_, nullptr);
    }
    if (messenger_)
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"))(instance_, messenger_, nullptr);
    if (instance_) vkDestroyInstance(instance_, nullptr);
}

std::uint32_t Device::memory_type(std::uint32_t types, VkMemoryPropertyFlags wanted) const {
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
        if ((types >> i & 1) && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    throw Error(fmt::format("Vulkan: {} has no memory with properties {:#x}", name(), wanted));
}

VkCommandBuffer Device::begin() const {
    auto info = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    info.commandPool = pool_;
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    VkCommandBuffer commands;
    check(vkAllocateCommandBuffers(device_, &info, &commands), "Vulkan: vkAllocateCommandBuffers");
    const VkCommandBufferBeginInfo how{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr, 0, nullptr};
    check(vkBeginCommandBuffer(commands, &how), "Vulkan: vkBeginCommandBuffer");
    return commands;
}

double Device::submit(VkCommandBuffer commands) const {
    auto info = structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands;
    check(vkResetFences(device_, 1, &fence_), "Vulkan: vkResetFences");
    const auto start = std::chrono::steady_clock::now();
    check(vkQueueSubmit(queue_, 1, &info, fence_), "Vulkan: vkQueueSubmit");
    check(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "Vulkan: vkWaitForFences");
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

Stopwatch::Stopwatch(const Device& device) : device_(device) {
    if (!device.has_timestamps()) return;
    auto info = structure<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 2;
    VkQueryPool pool;
    check(vkCreateQueryPool(device.get(), &info, nullptr, &pool), "Vulkan: vkCreateQueryPool");
    queries_ = {device.get(), pool};
}

void Stopwatch::start(VkCommandBuffer commands) const {
    if (!queries_) return;
    vkCmdResetQueryPool(commands, queries_.get(), 0, 2);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, queries_.get(), 0);
}

void Stopwatch::stop(VkCommandBuffer commands) const {
    if (queries_) vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_.get(), 1);
}

double Stopwatch::ms() const {
    if (!queries_) return 0;
    std::uint64_t ticks[2] = {};
    check(vkGetQueryPoolResults(device_.get(), queries_.get(), 0, 2, sizeof ticks, ticks, sizeof ticks[0],
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "Vulkan: vkGetQueryPoolResults");
    return double(ticks[1] - ticks[0]) * device_.properties().limits.timestampPeriod * 1e-6;
}

}  // namespace plumb::vulkan
