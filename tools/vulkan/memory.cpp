#include "tools/vulkan/memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace plumb::vulkan {
namespace {

Owned<VkDeviceMemory, vkFreeMemory> allocate(const Device& device, const VkMemoryRequirements& needs,
                                             VkMemoryPropertyFlags wanted) {
    auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    info.allocationSize = needs.size;
    info.memoryTypeIndex = device.memory_type(needs.memoryTypeBits, wanted);
    VkDeviceMemory memory;
    check(vkAllocateMemory(device.get(), &info, nullptr, &memory), "Vulkan: vkAllocateMemory");
    return {device.get(), memory};
}

// A shader sees no more of a buffer than its kind of descriptor spans.
void check_range(const Device& device, std::size_t bytes, VkBufferUsageFlags usage) {
    const VkPhysicalDeviceLimits& limits = device.limits();
    auto check_kind = [&](VkBufferUsageFlags kind, const char* name, std::size_t most) {
        if ((usage & kind) && bytes > most)
            throw Error(fmt::format("Vulkan: {} takes {} buffers of at most {} bytes; expected {}", device.name(), name,
                                    most, bytes));
    };
    check_kind(VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "uniform", limits.maxUniformBufferRange);
    check_kind(VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "storage", limits.maxStorageBufferRange);
}

void check_image(const Device& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
                 std::uint32_t layers) {
    VkImageFormatProperties most;
    const VkResult result = vkGetPhysicalDeviceImageFormatProperties(device.physical(), format, VK_IMAGE_TYPE_2D,
                                                                     VK_IMAGE_TILING_OPTIMAL, usage, 0, &most);
    if (result == VK_ERROR_FORMAT_NOT_SUPPORTED)
        throw Error(
            fmt::format("Vulkan: {} has no images of VkFormat {} for usage {:#x}", device.name(), int(format), usage));
    check(result, "Vulkan: vkGetPhysicalDeviceImageFormatProperties");
    if (size.width > most.maxExtent.width || size.height > most.maxExtent.height)
        throw Error(fmt::format("Vulkan: {} takes images of at most {} x {}; expected {} x {}", device.name(),
                                most.maxExtent.width, most.maxExtent.height, size.width, size.height));
    if (layers > most.maxArrayLayers)
        throw Error(fmt::format("Vulkan: {} takes images of at most {} layers; expected {}", device.name(),
                                most.maxArrayLayers, layers));
}

Buffer make_buffer(const Device& device, std::size_t bytes, VkBufferUsageFlags usage, VkMemoryPropertyFlags wanted) {
    check_range(device, bytes, usage);
    Buffer out;
    out.bytes = std::max<std::size_t>(bytes, 16);
    auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    info.size = out.bytes;
    info.usage = usage;
    VkBuffer buffer;
    check(vkCreateBuffer(device.get(), &info, nullptr, &buffer), "Vulkan: vkCreateBuffer");
    out.buffer = {device.get(), buffer};
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device.get(), buffer, &needs);
    out.memory = allocate(device, needs, wanted);
    check(vkBindBufferMemory(device.get(), buffer, out.memory.get(), 0), "Vulkan: vkBindBufferMemory");
    return out;
}

void change_layout(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to) {
    auto barrier = structure<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.image.get();
    barrier.subresourceRange = {image.aspect, 0, 1, 0, image.layers};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                         nullptr, 0, nullptr, 1, &barrier);
}

VkBufferImageCopy whole(const Image& image) {
    VkBufferImageCopy region{};
    region.imageSubresource = {image.aspect, 0, 0, image.layers};
    region.imageExtent = {image.size.width, image.size.height, 1};
    return region;
}

}  // namespace

Buffer host_buffer(const Device& device, std::size_t bytes, VkBufferUsageFlags usage) {
    Buffer out =
        make_buffer(device, bytes, usage, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkMapMemory(device.get(), out.memory.get(), 0, VK_WHOLE_SIZE, 0, &out.mapped), "Vulkan: vkMapMemory");
    return out;
}

Buffer device_buffer(const Device& device, const void* data, std::size_t bytes, VkBufferUsageFlags usage) {
    Buffer out =
        make_buffer(device, bytes, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    const Buffer staging = host_buffer(device, out.bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    std::memset(staging.mapped, 0, out.bytes);
    if (bytes > 0) std::memcpy(staging.mapped, data, bytes);
    device.run([&](VkCommandBuffer commands) {
        const VkBufferCopy region{0, 0, out.bytes};
        vkCmdCopyBuffer(commands, staging.get(), out.get(), 1, &region);
        full_barrier(commands);
    });
    return out;
}

Image make_image(const Device& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
                 std::uint32_t layers) {
    check_image(device, format, size, usage, layers);
    Image out;
    out.format = format;
    out.size = size;
    out.layers = std::max(layers, 1u);
    out.aspect = format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    auto info = structure<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {size.width, size.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = out.layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = usage;
    VkImage image;
    check(vkCreateImage(device.get(), &info, nullptr, &image), "Vulkan: vkCreateImage");
    out.image = {device.get(), image};
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device.get(), image, &needs);
    out.allocated = needs.size;
    out.memory = allocate(device, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(vkBindImageMemory(device.get(), image, out.memory.get(), 0), "Vulkan: vkBindImageMemory");

    auto view_info = structure<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view_info.image = image;
    view_info.viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view_info.format = format;
    view_info.subresourceRange = {out.aspect, 0, 1, 0, out.layers};
    VkImageView view;
    check(vkCreateImageView(device.get(), &view_info, nullptr, &view), "Vulkan: vkCreateImageView");
    out.view = {device.get(), view};
    return out;
}

Image make_texture(const Device& device, VkFormat format, VkExtent2D size, const void* texels, std::size_t bytes,
                   std::uint32_t layers) {
    Image out = make_image(device, format, size, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, layers);
    const Buffer staging = host_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    std::memcpy(staging.mapped, texels, bytes);
    device.run([&](VkCommandBuffer commands) {
        const VkBufferImageCopy region = whole(out);
        change_layout(commands, out, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        vkCmdCopyBufferToImage(commands, staging.get(), out.image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                               &region);
        change_layout(commands, out, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    });
    return out;
}

Image make_storage_image(const Device& device, VkFormat format, VkExtent2D size, VkClearColorValue fill) {
    Image out =
        make_image(device, format, size,
                   VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    device.run([&](VkCommandBuffer commands) {
        const VkImageSubresourceRange all{out.aspect, 0, 1, 0, out.layers};
        change_layout(commands, out, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
        vkCmdClearColorImage(commands, out.image.get(), VK_IMAGE_LAYOUT_GENERAL, &fill, 1, &all);
        full_barrier(commands);
    });
    return out;
}

void read_image(const Device& device, const Image& image, void* out, std::size_t bytes, VkImageLayout layout) {
    const Buffer staging = host_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    device.run([&](VkCommandBuffer commands) {
        const VkBufferImageCopy region = whole(image);
        vkCmdCopyImageToBuffer(commands, image.image.get(), layout, staging.get(), 1, &region);
        full_barrier(commands);
    });
    std::memcpy(out, staging.mapped, bytes);
}

void full_barrier(VkCommandBuffer commands) {
    auto barrier = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
}

}  // namespace plumb::vulkan
