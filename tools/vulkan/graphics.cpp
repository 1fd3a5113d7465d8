#include "tools/vulkan/graphics.h"

#include <fmt/format.h>

#include <algorithm>

namespace plumb::vulkan {
namespace {

Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> make_sampler_layout(const Device& device, std::uint32_t n) {
    std::vector<VkDescriptorSetLayoutBinding> bindings(n);
    for (std::uint32_t i = 0; i < n; ++i)
        bindings[i] = {i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    auto info = structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    info.bindingCount = n;
    info.pBindings = bindings.data();
    VkDescriptorSetLayout layout;
    check(vkCreateDescriptorSetLayout(device.get(), &info, nullptr, &layout), "Vulkan: vkCreateDescriptorSetLayout");
    return {device.get(), layout};
}

Owned<VkRenderPass, vkDestroyRenderPass> make_pass(const Device& device, const std::vector<VkFormat>& colours) {
    std::vector<VkAttachmentDescription> attachments;
    std::vector<VkAttachmentReference> references;
    auto add = [&](VkFormat format, VkImageLayout during) {
        VkAttachmentDescription a{};
        a.format = format;
        a.samples = VK_SAMPLE_COUNT_1_BIT;
        a.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        a.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        a.finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        references.push_back({std::uint32_t(attachments.size()), during});
        attachments.push_back(a);
    };
    for (VkFormat format : colours) add(format, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    add(VK_FORMAT_D32_SFLOAT, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);

    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = std::uint32_t(colours.size());
    subpass.pColorAttachments = references.data();
    subpass.pDepthStencilAttachment = &references.back();
    // Order the pass after what read the images last, and what reads them next after the pass.
    VkSubpassDependency dependencies[2] = {};
    constexpr VkAccessFlags any_access = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    dependencies[0] = {
        VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT, any_access,
        any_access,          0};
    dependencies[1] = {0,
                       VK_SUBPASS_EXTERNAL,
                       VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT,
                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       any_access,
                       any_access,
                       0};

    auto info = structure<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
    info.attachmentCount = std::uint32_t(attachments.size());
    info.pAttachments = attachments.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    VkRenderPass pass;
    check(vkCreateRenderPass(device.get(), &info, nullptr, &pass), "Vulkan: vkCreateRenderPass");
    return {device.get(), pass};
}

void check_targets(const Device& device, VkExtent2D size, std::size_t colours) {
    const VkPhysicalDeviceLimits& limits = device.limits();
    if (colours > limits.maxColorAttachments)
        throw Error(fmt::format("Vulkan: {} draws into {} colour targets at once; expected {}", device.name(),
                                limits.maxColorAttachments, colours));
    const std::uint32_t width = std::min(limits.maxFramebufferWidth, limits.maxViewportDimensions[0]);
    const std::uint32_t height = std::min(limits.maxFramebufferHeight, limits.maxViewportDimensions[1]);
    if (size.width > width || size.height > height)
        throw Error(fmt::format("Vulkan: {} draws into targets of at most {} x {}; expected {} x {}", device.name(),
                                width, height, size.width, size.height));
}

}  // namespace

Targets make_targets(const Device& device, VkExtent2D size, const std::vector<VkFormat>& colours) {
    check_targets(device, size, colours.size());
    Targets out;
    out.size = size;
    out.clear.resize(colours.size() + 1);
    out.clear.back().depthStencil = {1, 0};
    std::vector<VkImageView> views;
    for (VkFormat format : colours) {
        out.colours.push_back(
            make_image(device, format, size, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT));
        views.push_back(out.colours.back().view.get());
    }
    out.depth = make_image(device, VK_FORMAT_D32_SFLOAT, size,
                           VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    views.push_back(out.depth.view.get());
    out.pass = make_pass(device, colours);

    auto info = structure<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
    info.renderPass = out.pass.get();
    info.attachmentCount = std::uint32_t(views.size());
    info.pAttachments = views.data();
    info.width = size.width;
    info.height = size.height;
    info.layers = 1;
    VkFramebuffer framebuffer;
    check(vkCreateFramebuffer(device.get(), &info, nullptr, &framebuffer), "Vulkan: vkCreateFramebuffer");
    out.framebuffer = {device.get(), framebuffer};
    return out;
}

void Targets::begin(VkCommandBuffer commands) const {
    auto info = structure<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
    info.renderPass = pass.get();
    info.framebuffer = framebuffer.get();
    info.renderArea = {{0, 0}, size};
    info.clearValueCount = std::uint32_t(clear.size());
    info.pClearValues = clear.data();
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
    const VkViewport viewport{0, 0, float(size.width), float(size.height), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &info.renderArea);
}

GraphicsPipeline make_graphics_pipeline(const Device& device, const Targets& targets, const GraphicsOptions& options) {
    GraphicsPipeline out;
    if (!options.set) out.set_layout = make_sampler_layout(device, options.samplers);
    out.layout =
        make_pipeline_layout(device, options.set ? options.set : out.set_layout.get(),
                             {VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, options.push_bytes});
    const ShaderModule vertex = make_shader(device, options.vertex_shader, options.name);
    const ShaderModule fragment = make_shader(device, options.fragment_shader, options.name);
    VkPipelineShaderStageCreateInfo stages[] = {shader_stage(VK_SHADER_STAGE_VERTEX_BIT, vertex),
                                                shader_stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment)};
    std::vector<VkSpecializationMapEntry> entries;
    for (std::uint32_t i = 0; i < options.constants.size(); ++i) entries.push_back({i, 4 * i, 4});
    const VkSpecializationInfo constants{std::uint32_t(entries.size()), entries.data(), 4 * entries.size(),
                                         options.constants.data()};
    stages[1].pSpecializationInfo = &constants;

    const VkVertexInputBindingDescription binding{0, options.stride, VK_VERTEX_INPUT_RATE_VERTEX};
    std::vector<VkVertexInputAttributeDescription> attributes;
    for (const Attribute& a : options.attributes)
        attributes.push_back({std::uint32_t(attributes.size()), 0, a.format, a.offset});
    auto input =
        structure<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
    input.vertexBindingDescriptionCount = attributes.empty() ? 0 : 1;
    input.pVertexBindingDescriptions = &binding;
    input.vertexAttributeDescriptionCount = std::uint32_t(attributes.size());
    input.pVertexAttributeDescriptions = attributes.data();
    auto assembly =
        structure<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;

    auto viewport = structure<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
    viewport.viewportCount = viewport.scissorCount = 1;
    auto raster =
        structure<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1;
    auto samples =
        structure<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    auto depth =
        structure<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = options.depth_test;
    VkPipelineColorBlendAttachmentState write_all{};
    write_all.colorWriteMask =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    const std::vector<VkPipelineColorBlendAttachmentState> writes(targets.colours.size(), write_all);
    auto blend =
        structure<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
    blend.attachmentCount = std::uint32_t(writes.size());
    blend.pAttachments = writes.data();
    const VkDynamicState dynamics[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    auto dynamic = structure<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = dynamics;

    auto info = structure<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = out.layout.get();
    info.renderPass = targets.pass.get();
    VkPipeline pipeline;
    check(vkCreateGraphicsPipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "Vulkan: vkCreateGraphicsPipelines");
    out.pipeline = {device.get(), pipeline};
    return out;
}

Sampler make_sampler(const Device& device, VkFilter filter, VkSamplerAddressMode u, VkSamplerAddressMode v) {
    auto info = structure<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
    info.magFilter = info.minFilter = filter;
    info.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST;
    info.addressModeU = u;
    info.addressModeV = info.addressModeW = v;
    VkSampler sampler;
    check(vkCreateSampler(device.get(), &info, nullptr, &sampler), "Vulkan: vkCreateSampler");
    return {device.get(), sampler};
}

TextureSets make_texture_sets(const Device& device, const std::vector<SampledTexture>& textures) {
    TextureSets out;
    const std::uint32_t n = std::uint32_t(textures.size());
    out.layout = make_sampler_layout(device, 1);
    const VkDescriptorPoolSize pool_size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, n};
    auto pool_info = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    pool_info.maxSets = n;
    pool_info.poolSizeCount = 1;
    pool_info.pPoolSizes = &pool_size;
    VkDescriptorPool pool;
    check(vkCreateDescriptorPool(device.get(), &pool_info, nullptr, &pool), "Vulkan: vkCreateDescriptorPool");
    out.pool = {device.get(), pool};

    const std::vector<VkDescriptorSetLayout> layouts(n, out.layout.get());
    auto info = structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    info.descriptorPool = pool;
    info.descriptorSetCount = n;
    info.pSetLayouts = layouts.data();
    out.sets.resize(n);
    check(vkAllocateDescriptorSets(device.get(), &info, out.sets.data()), "Vulkan: vkAllocateDescriptorSets");
    for (std::uint32_t i = 0; i < n; ++i) {
        const VkDescriptorImageInfo image{textures[i].sampler, textures[i].view,
                                          VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
        auto write = structure<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
        write.dstSet = out.sets[i];
        write.descriptorCount = 1;
        write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        write.pImageInfo = &image;
        vkUpdateDescriptorSets(device.get(), 1, &write, 0, nullptr);
    }
    return out;
}

}  // namespace plumb::vulkan
