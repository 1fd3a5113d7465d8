// Buffers and images on a device, filled from and read back to the host.
#pragma once

#include <cstddef>

#include "tools/vulkan/device.h"

namespace plumb::vulkan {

struct Buffer {
    Owned<VkBuffer, vkDestroyBuffer> buffer;
    Owned<VkDeviceMemory, vkFreeMemory> memory;
    std::size_t bytes = 0;
    void* mapped = nullptr;  // of host buffers

    VkBuffer get() const { return buffer.get(); }
};

// Mapped and coherent.
Buffer host_buffer(const Device& device, std::size_t bytes, VkBufferUsageFlags usage);
// In the device's own memory, holding `data`; an empty one has 16 zeros, since Vulkan knows none of size 0.
Buffer device_buffer(const Device& device, const void* data, std::size_t bytes, VkBufferUsageFlags usage);

struct Image {
    Owned<VkImage, vkDestroyImage> image;
    Owned<VkDeviceMemory, vkFreeMemory> memory;
    Owned<VkImageView, vkDestroyImageView> view;
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkExtent2D size{};
    std::uint32_t layers = 1;
    VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
    VkDeviceSize allocated = 0;  // bytes
};

// One level, optimal tiling, no layout yet; `layers` above 0 make a 2D array of that many. VK_FORMAT_D32_SFLOAT is the
// depth format that is known here. Throws Error where the device has no such images.
Image make_image(const Device& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
                 std::uint32_t layers = 0);
// A texture that shaders sample: `texels` of `bytes` in all, layer by layer, rows without padding. Left in
// SHADER_READ_ONLY_OPTIMAL.
Image make_texture(const Device& device, VkFormat format, VkExtent2D size, const void* texels, std::size_t bytes,
                   std::uint32_t layers = 0);
// What a compute shader stores to, all `fill`; left in GENERAL.
Image make_storage_image(const Device& device, VkFormat format, VkExtent2D size, VkClearColorValue fill);
// The image's texels into `out` of `bytes`; the image is in `layout`, and stays so.
void read_image(const Device& device, const Image& image, void* out, std::size_t bytes,
                VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);

// Waits for all writes before and makes them visible to all that follows, the host too.
void full_barrier(VkCommandBuffer commands);

}  // namespace plumb::vulkan
