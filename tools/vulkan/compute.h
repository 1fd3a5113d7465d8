// Compute pipelines: one dispatch over a frame, in groups of 8 x 8 invocations.
#pragma once

#include "tools/vulkan/shader.h"

namespace plumb::vulkan {

struct ComputePipeline {
    PipelineLayout layout;
    Owned<VkPipeline, vkDestroyPipeline> pipeline;

    // One invocation a pixel of `size`, and those that fill up the last groups.
    void dispatch(VkCommandBuffer commands, VkDescriptorSet set, VkExtent2D size) const;
};
ComputePipeline make_compute_pipeline(const Device& device, const ShaderModule& shader, VkDescriptorSetLayout set);

}  // namespace plumb::vulkan
