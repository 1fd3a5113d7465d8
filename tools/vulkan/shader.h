// SPIR-V, what it says about itself, and what a pipeline binds to it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/vulkan/memory.h"

namespace plumb::vulkan {

using Spirv = std::vector<std::uint32_t>;

// Throws Error for a file that cannot be read or holds none.
Spirv load_spirv(const std::string& file);

using ShaderModule = Owned<VkShaderModule, vkDestroyShaderModule>;
// `name` is what errors call it. Throws Error for what is no SPIR-V.
ShaderModule make_shader(const Device& device, std::span<const std::uint32_t> spirv, const std::string& name);

// Bindings of set 0 that a shader declares, sorted.
std::vector<std::uint32_t> declared_bindings(std::span<const std::uint32_t> spirv);
// The same shader, whose storage images of rgba32f are rgba16f.
Spirv with_half_images(std::span<const std::uint32_t> spirv);

// One thing that shaders see, at its binding of set 0.
struct Resource {
    std::uint32_t binding = 0;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    VkShaderStageFlags stages = VK_SHADER_STAGE_COMPUTE_BIT;
    const Buffer* buffer = nullptr;  // of buffers: all of it
    const Image* image = nullptr;    // of images: sampled ones in SHADER_READ_ONLY_OPTIMAL, storage images in GENERAL
    VkSampler sampler = VK_NULL_HANDLE;
};

// One set of them. The resources must outlive it.
struct DescriptorSet {
    Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> layout;
    Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool;
    VkDescriptorSet set = VK_NULL_HANDLE;
};
// Throws Error where a shader stage of the device takes fewer.
DescriptorSet make_descriptor_set(const Device& device, const std::vector<Resource>& resources);

using PipelineLayout = Owned<VkPipelineLayout, vkDestroyPipelineLayout>;
PipelineLayout make_pipeline_layout(const Device& device, VkDescriptorSetLayout set,
                                    const VkPushConstantRange& push = {});

VkPipelineShaderStageCreateInfo shader_stage(VkShaderStageFlagBits stage, const ShaderModule& module);

}  // namespace plumb::vulkan
