// What renderers A and B share: textures on a device, and passes over the whole frame.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/foreign/textures.h"
#include "tests/foreign/variants.h"
#include "tools/vulkan/graphics.h"

namespace plumb::foreign {

VkFormat vk_format(const std::string& name);

vulkan::Image upload(const vulkan::Device& device, const Texture& texture);
// `layout`: that in which the image is.
Texture download(const vulkan::Device& device, const vulkan::Image& image, const std::string& format,
                 VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);

// Everything that a pass reads: a uniform block at binding 0, textures from binding 1 on, then a buffer.
struct PassInputs {
    std::vector<unsigned char> block = {};
    std::vector<Texture> textures = {};
    std::vector<float> buffer = {};
    VkFilter filter = VK_FILTER_NEAREST;
    VkSamplerAddressMode address = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
};
template <class Block>
std::vector<unsigned char> block_bytes(const Block& block) {
    const auto* first = reinterpret_cast<const unsigned char*>(&block);
    return {first, first + sizeof block};
}

// Those inputs on a device.
struct BoundInputs {
    vulkan::Buffer block, buffer;
    std::vector<vulkan::Image> images;
    vulkan::Sampler sampler;
    std::vector<vulkan::Resource> resources;

    BoundInputs(const vulkan::Device& device, const PassInputs& inputs, VkShaderStageFlags stages);
    BoundInputs(const BoundInputs&) = delete;
};

// A triangle over all of `size`, into targets of these formats.
std::vector<Texture> draw_fullscreen(const vulkan::Device& device, glm::ivec2 size, const std::string& fragment_file,
                                     const Variant& variant, const PassInputs& inputs,
                                     const std::vector<std::string>& formats);

}  // namespace plumb::foreign
