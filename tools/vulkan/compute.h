// Compute pipelines: one dispatch over a frame, in groups of 8 x 8 invocations.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "tools/vulkan/shader.h"

namespace plumb::vulkan {

struct ComputePipeline {
    PipelineLayout layout;
    Owned<VkPipeline, vkDestroyPipeline> pipeline;

    // One invocation a pixel of `size`, and those that fill up the last groups.
    void dispatch(VkCommandBuffer commands, VkDescriptorSet set, VkExtent2D size) const;
    // The groups of these pixels alone, with that z in all invocations; of a pipeline that was made for it. No pixels: all.
    void dispatch_some(VkCommandBuffer commands, VkDescriptorSet set, VkExtent2D size, std::span<const glm::ivec2> pixels,
                       std::uint32_t z) const;
};
// `some`: dispatch_some() will be called.
ComputePipeline make_compute_pipeline(const Device& device, const ShaderModule& shader, VkDescriptorSetLayout set,
                                      bool some = false);

}  // namespace plumb::vulkan
