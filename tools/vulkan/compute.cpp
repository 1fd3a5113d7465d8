#include "tools/vulkan/compute.h"

#include <set>
#include <utility>

namespace plumb::vulkan {

constexpr std::uint32_t group = 8;  // local_size_x and local_size_y of every twin

void ComputePipeline::dispatch(VkCommandBuffer commands, VkDescriptorSet set, VkExtent2D size) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout.get(), 0, 1, &set, 0, nullptr);
    vkCmdDispatch(commands, (size.width + group - 1) / group, (size.height + group - 1) / group, 1);
    full_barrier(commands);
}

void ComputePipeline::dispatch_some(VkCommandBuffer commands, VkDescriptorSet set, VkExtent2D size,
                                    std::span<const glm::ivec2> pixels, std::uint32_t z) const {
    std::set<std::pair<int, int>> groups;
    for (const glm::ivec2 p : pixels) groups.insert({p.y / int(group), p.x / int(group)});
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout.get(), 0, 1, &set, 0, nullptr);
    for (const auto& [y, x] : groups) vkCmdDispatchBase(commands, std::uint32_t(x), std::uint32_t(y), z, 1, 1, 1);
    if (pixels.empty())
        vkCmdDispatchBase(commands, 0, 0, z, (size.width + group - 1) / group, (size.height + group - 1) / group, 1);
    full_barrier(commands);
}

ComputePipeline make_compute_pipeline(const Device& device, const ShaderModule& shader, VkDescriptorSetLayout set,
                                      bool some) {
    ComputePipeline out;
    out.layout = make_pipeline_layout(device, set);
    auto info = structure<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    info.stage = shader_stage(VK_SHADER_STAGE_COMPUTE_BIT, shader);
    info.layout = out.layout.get();
    if (some) info.flags = VK_PIPELINE_CREATE_DISPATCH_BASE_BIT;
    VkPipeline pipeline;
    check(vkCreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "Vulkan: vkCreateComputePipelines");
    out.pipeline = {device.get(), pipeline};
    return out;
}

}  // namespace plumb::vulkan
