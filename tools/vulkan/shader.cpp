#include "tools/vulkan/shader.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace plumb::vulkan {
namespace {

// SPIR-V 1.3: a header of five words, then instructions whose first word is their length and opcode.
constexpr std::uint32_t magic_number = 0x07230203;
constexpr std::size_t header_words = 5;
enum Opcode : std::uint32_t { op_type_image = 25, op_decorate = 71 };
enum Decoration : std::uint32_t { binding_decoration = 33 };
enum ImageFormat : std::uint32_t { rgba32f = 1, rgba16f = 2 };
constexpr std::uint32_t storage_image = 2;  // "Sampled" of OpTypeImage

// Calls visit(opcode, first word, number of words) for each instruction.
template <class Visit>
void for_each_instruction(std::span<const std::uint32_t> spirv, Visit&& visit) {
    for (std::size_t i = header_words; i < spirv.size();) {
        const std::size_t words = spirv[i] >> 16;
        if (words == 0 || words > spirv.size() - i) throw Error("SPIR-V: an instruction is cut off");
        visit(spirv[i] & 0xffff, i, words);
        i += words;
    }
}

bool is_image(VkDescriptorType type) {
    return type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER || type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
}

struct Kind {
    VkDescriptorType type;
    const char* name;
    std::uint32_t most;  // that one shader stage takes
};

std::vector<Kind> kinds_of(const VkPhysicalDeviceLimits& limits) {
    return {
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, "uniform buffers", limits.maxPerStageDescriptorUniformBuffers},
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, "storage buffers", limits.maxPerStageDescriptorStorageBuffers},
        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, "storage images", limits.maxPerStageDescriptorStorageImages},
        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, "sampled images",
         std::min(limits.maxPerStageDescriptorSamplers, limits.maxPerStageDescriptorSampledImages)},
    };
}

void check_counts(const Device& device, const std::vector<Resource>& resources) {
    for (const VkShaderStageFlagBits stage :
         {VK_SHADER_STAGE_VERTEX_BIT, VK_SHADER_STAGE_FRAGMENT_BIT, VK_SHADER_STAGE_COMPUTE_BIT})
        for (const Kind& kind : kinds_of(device.limits())) {
            const auto n = std::count_if(resources.begin(), resources.end(), [&](const Resource& r) {
                return r.type == kind.type && (r.stages & VkShaderStageFlags(stage));
            });
            if (n > std::int64_t(kind.most))
                throw Error(fmt::format("Vulkan: {} takes {} {} in one shader; expected {}", device.name(), kind.most,
                                        kind.name, n));
        }
}

void write_resource(const Device& device, VkDescriptorSet set, const Resource& r) {
    auto write = structure<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = set;
    write.dstBinding = r.binding;
    write.descriptorCount = 1;
    write.descriptorType = r.type;
    VkDescriptorBufferInfo buffer{};
    VkDescriptorImageInfo image{};
    if (is_image(r.type)) {
        const bool sampled = r.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        image = {r.sampler, r.image->view.get(),
                 sampled ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_GENERAL};
        write.pImageInfo = &image;
    } else {
        buffer = {r.buffer->get(), 0, VK_WHOLE_SIZE};
        write.pBufferInfo = &buffer;
    }
    vkUpdateDescriptorSets(device.get(), 1, &write, 0, nullptr);
}

}  // namespace

Spirv load_spirv(const std::string& file) {
    std::ifstream in(file, std::ios::binary | std::ios::ate);
    if (!in) throw Error(fmt::format("{}: cannot be read", file));
    Spirv words(std::size_t(in.tellg()) / 4);
    in.seekg(0);
    if (!in.read(reinterpret_cast<char*>(words.data()), std::streamsize(4 * words.size())))
        throw Error(fmt::format("{}: cannot be read", file));
    return words;
}

ShaderModule make_shader(const Device& device, std::span<const std::uint32_t> spirv, const std::string& name) {
    if (spirv.size() < header_words || spirv[0] != magic_number) throw Error(fmt::format("{}: no SPIR-V", name));
    auto info = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    info.codeSize = 4 * spirv.size();
    info.pCode = spirv.data();
    VkShaderModule module;
    check(vkCreateShaderModule(device.get(), &info, nullptr, &module), name);
    return {device.get(), module};
}

std::vector<std::uint32_t> declared_bindings(std::span<const std::uint32_t> spirv) {
    std::vector<std::uint32_t> out;
    for_each_instruction(spirv, [&](std::uint32_t opcode, std::size_t first, std::size_t words) {
        if (opcode == op_decorate && words == 4 && spirv[first + 2] == binding_decoration)
            out.push_back(spirv[first + 3]);
    });
    std::sort(out.begin(), out.end());
    return out;
}

Spirv with_half_images(std::span<const std::uint32_t> spirv) {
    Spirv out(spirv.begin(), spirv.end());
    // Operands of OpTypeImage: result, sampled type, dim, depth, arrayed, ms, sampled, format.
    for_each_instruction(spirv, [&](std::uint32_t opcode, std::size_t first, std::size_t words) {
        if (opcode == op_type_image && words >= 9 && spirv[first + 7] == storage_image && spirv[first + 8] == rgba32f)
            out[first + 8] = rgba16f;
    });
    return out;
}

DescriptorSet make_descriptor_set(const Device& device, const std::vector<Resource>& resources) {
    check_counts(device, resources);
    DescriptorSet out;
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    std::vector<VkDescriptorPoolSize> sizes;
    for (const Resource& r : resources) {
        bindings.push_back({r.binding, r.type, 1, r.stages, nullptr});
        sizes.push_back({r.type, 1});
    }
    auto layout_info = structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    layout_info.bindingCount = std::uint32_t(bindings.size());
    layout_info.pBindings = bindings.data();
    VkDescriptorSetLayout layout;
    check(vkCreateDescriptorSetLayout(device.get(), &layout_info, nullptr, &layout),
          "Vulkan: vkCreateDescriptorSetLayout");
    out.layout = {device.get(), layout};

    auto pool_info = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    pool_info.maxSets = 1;
    pool_info.poolSizeCount = std::uint32_t(sizes.size());
    pool_info.pPoolSizes = sizes.data();
    VkDescriptorPool pool;
    check(vkCreateDescriptorPool(device.get(), &pool_info, nullptr, &pool), "Vulkan: vkCreateDescriptorPool");
    out.pool = {device.get(), pool};
    auto info = structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    info.descriptorPool = pool;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    check(vkAllocateDescriptorSets(device.get(), &info, &out.set), "Vulkan: vkAllocateDescriptorSets");
    for (const Resource& r : resources) write_resource(device, out.set, r);
    return out;
}

PipelineLayout make_pipeline_layout(const Device& device, VkDescriptorSetLayout set, const VkPushConstantRange& push) {
    auto info = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    info.setLayoutCount = 1;
    info.pSetLayouts = &set;
    info.pushConstantRangeCount = push.size > 0 ? 1 : 0;
    info.pPushConstantRanges = &push;
    VkPipelineLayout layout;
    check(vkCreatePipelineLayout(device.get(), &info, nullptr, &layout), "Vulkan: vkCreatePipelineLayout");
    return {device.get(), layout};
}

VkPipelineShaderStageCreateInfo shader_stage(VkShaderStageFlagBits stage, const ShaderModule& module) {
    auto info = structure<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
    info.stage = stage;
    info.module = module.get();
    info.pName = "main";
    return info;
}

}  // namespace plumb::vulkan
