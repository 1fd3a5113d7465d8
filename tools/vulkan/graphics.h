// Drawing into a set of targets: a render pass that clears them, pipelines from SPIR-V, textures of a draw.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/vulkan/shader.h"

namespace plumb::vulkan {

// Colour targets and a D32 depth buffer, kept from frame to frame. The pass clears them, colours to 0 and depth to 1
// unless told otherwise, and leaves every image ready for read_image().
struct Targets {
    VkExtent2D size{};
    std::vector<Image> colours;
    Image depth;
    std::vector<VkClearValue> clear;  // of each colour, then depth
    Owned<VkRenderPass, vkDestroyRenderPass> pass;
    Owned<VkFramebuffer, vkDestroyFramebuffer> framebuffer;

    void begin(VkCommandBuffer commands) const;  // the pass; viewport and scissor of the whole frame
    void end(VkCommandBuffer commands) const { vkCmdEndRenderPass(commands); }
};
// Throws Error where the device draws into none so many or so large.
Targets make_targets(const Device& device, VkExtent2D size, const std::vector<VkFormat>& colours);

struct Attribute {
    VkFormat format;
    std::uint32_t offset;  // bytes; attribute i has location i
};

struct GraphicsOptions {
    Spirv vertex_shader, fragment_shader;
    std::string name;          // what errors call the pair
    std::uint32_t stride = 0;  // bytes of a vertex, in binding 0
    std::vector<Attribute> attributes;
    std::vector<std::uint32_t> constants;  // specialisation constants of the fragment shader: ids 0, 1, ...
    std::uint32_t push_bytes = 0;          // push constants, seen by both shaders
    std::uint32_t samplers = 0;  // combined image samplers of the fragment shader: bindings 0, 1, ... of set 0
    VkDescriptorSetLayout set = VK_NULL_HANDLE;  // instead of these: what set 0 is; must outlive the pipeline
    VkCompareOp depth_test = VK_COMPARE_OP_LESS;
};

// Triangle lists, two-sided, no blending.
struct GraphicsPipeline {
    Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> set_layout;
    PipelineLayout layout;
    Owned<VkPipeline, vkDestroyPipeline> pipeline;

    void bind(VkCommandBuffer commands) const {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.get());
    }
    void push(VkCommandBuffer commands, std::uint32_t offset, std::uint32_t bytes, const void* data) const {
        vkCmdPushConstants(commands, layout.get(), VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, offset,
                           bytes, data);
    }
};
GraphicsPipeline make_graphics_pipeline(const Device& device, const Targets& targets, const GraphicsOptions& options);

using Sampler = Owned<VkSampler, vkDestroySampler>;
// Level 0 alone, no anisotropy.
Sampler make_sampler(const Device& device, VkFilter filter, VkSamplerAddressMode u, VkSamplerAddressMode v);

// Descriptor sets with one texture each, for any pipeline with samplers = 1.
struct TextureSets {
    Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> layout;
    Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool;
    std::vector<VkDescriptorSet> sets;
};
struct SampledTexture {
    VkImageView view;
    VkSampler sampler;
};
TextureSets make_texture_sets(const Device& device, const std::vector<SampledTexture>& textures);

}  // namespace plumb::vulkan
