// plumb devices: the Vulkan devices that twins can run on.
#include "tools/plumb/devices.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"
#ifdef PLUMB_WITH_VULKAN
#include "tools/vulkan/profile.h"
#endif

namespace plumb::cli {

void add_device_option(CLI::App& command, std::string& device) {
    command.add_option("--device", device, "the Vulkan device: a part of its name, or its index in `plumb devices`")
        ->check(some_word())
        ->type_name("NAME");
}

#ifdef PLUMB_WITH_VULKAN

void require_vulkan(const std::string&) {}

namespace {

std::string version_text(std::uint32_t version) {
    return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                       VK_API_VERSION_PATCH(version));
}

std::string driver_text(const vulkan::DeviceInfo& device) {
    if (device.driver_name.empty()) return "-";
    return device.driver_name + (device.driver_info.empty() ? "" : ", " + device.driver_info);
}

std::string size_text(std::uint64_t bytes) {
    return bytes >= 1u << 30 ? fmt::format("{:.4g} GiB", double(bytes) / (1u << 30))
                             : fmt::format("{:.4g} MiB", double(bytes) / (1u << 20));
}

Json device_json(const vulkan::DeviceInfo& device) {
    const VkPhysicalDeviceLimits& limits = device.properties.limits;
    return {{"index", device.index},
            {"name", device.name()},
            {"type", device.type()},
            {"api_version", version_text(device.properties.apiVersion)},
            {"driver_name", device.driver_name},
            {"driver_info", device.driver_info},
            {"profile", vulkan::profile_of(device).name},
            {"max_image", limits.maxImageDimension2D},
            {"max_image_layers", limits.maxImageArrayLayers},
            {"max_buffer_bytes", limits.maxStorageBufferRange},
            {"max_buffers", limits.maxPerStageDescriptorStorageBuffers},
            {"max_colour_targets", limits.maxColorAttachments},
            {"raster_taps", device.features.fragmentStoresAndAtomics == VK_TRUE}};
}

std::string devices_text(const std::vector<vulkan::DeviceInfo>& devices) {
    std::vector<std::vector<std::string>> rows;
    for (const vulkan::DeviceInfo& d : devices) {
        const VkPhysicalDeviceLimits& limits = d.properties.limits;
        rows.push_back({std::to_string(d.index), d.name(), d.type(), version_text(d.properties.apiVersion),
                        driver_text(d), vulkan::profile_of(d).name, std::to_string(limits.maxImageDimension2D),
                        size_text(limits.maxStorageBufferRange),
                        std::to_string(limits.maxPerStageDescriptorStorageBuffers),
                        std::to_string(limits.maxColorAttachments)});
    }
    return format_table({{"#", Align::right},
                         {"device"},
                         {"type"},
                         {"Vulkan"},
                         {"driver"},
                         {"profile"},
                         {"image", Align::right},
                         {"buffer", Align::right},
                         {"buffers", Align::right},
                         {"targets", Align::right}},
                        rows) +
           "\nimage: most texels a side; buffer: largest; buffers, targets: most that one shader reads, draws into\n";
}

int devices(const Common& common) {
    common.run_options();
    const std::vector<vulkan::DeviceInfo> all = vulkan::list_devices();
    if (common.json) {
        Json list = Json::array();
        for (const vulkan::DeviceInfo& device : all) list.push_back(device_json(device));
        std::fputs(json_text(list).c_str(), stdout);
    } else if (all.empty()) {
        std::fputs("no Vulkan device (for a software one, install mesa-vulkan-drivers)\n", stdout);
    } else {
        std::fputs(devices_text(all).c_str(), stdout);
    }
    return success;
}

}  // namespace

#else

void require_vulkan(const std::string& what) {
    throw InputError(fmt::format("{}: this program was built without Vulkan (libvulkan-dev)", what));
}

namespace {

int devices(const Common&) {
    require_vulkan("devices");
    return success;
}

}  // namespace

#endif

void add_devices(CLI::App& program, Action& action) {
    auto common = std::make_shared<Common>();
    CLI::App* command = program.add_subcommand("devices", "list the Vulkan devices that GLSL twins can run on");
    add_common(*command, *common);
    command->callback([common, &action] { action = [common] { return devices(*common); }; });
}

}  // namespace plumb::cli
