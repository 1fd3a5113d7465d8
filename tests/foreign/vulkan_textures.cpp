#include "tests/foreign/vulkan_textures.h"

#include <stdexcept>
#include <utility>

namespace plumb::foreign {

VkFormat vk_format(const std::string& name) {
    static const std::vector<std::pair<std::string, VkFormat>> known = {
        {"R32_SFLOAT", VK_FORMAT_R32_SFLOAT},
        {"R32G32_SFLOAT", VK_FORMAT_R32G32_SFLOAT},
        {"R32G32B32A32_SFLOAT", VK_FORMAT_R32G32B32A32_SFLOAT},
        {"R16_SFLOAT", VK_FORMAT_R16_SFLOAT},
        {"R16G16B16A16_SFLOAT", VK_FORMAT_R16G16B16A16_SFLOAT},
        {"R16G16_SNORM", VK_FORMAT_R16G16_SNORM},
        {"R8G8B8A8_UNORM", VK_FORMAT_R8G8B8A8_UNORM},
        {"A2B10G10R10_UNORM_PACK32", VK_FORMAT_A2B10G10R10_UNORM_PACK32},
        {"B10G11R11_UFLOAT_PACK32", VK_FORMAT_B10G11R11_UFLOAT_PACK32},
    };
    for (const auto& [known_name, format] : known)
        if (known_name == name) return format;
    throw std::runtime_error("no format " + name);
}

namespace {

std::size_t texel_bytes(const std::string& format) {
    for (const FormatInfo& f : formats())
        if (f.vulkan_name == format) return std::size_t(f.bytes);
    return format == "R32G32_SFLOAT" ? 8 : throw std::runtime_error("no format " + format);
}

}  // namespace

vulkan::Image upload(const vulkan::Device& device, const Texture& t) {
    return vulkan::make_texture(device, vk_format(t.format), {std::uint32_t(t.width), std::uint32_t(t.height)},
                                t.bytes.data(), t.bytes.size());
}

Texture download(const vulkan::Device& device, const vulkan::Image& image, const std::string& format,
                 VkImageLayout layout) {
    Texture out{format, int(image.size.width), int(image.size.height), {}, false};
    out.bytes.resize(texel_bytes(format) * image.size.width * image.size.height);
    vulkan::read_image(device, image, out.bytes.data(), out.bytes.size(), layout);
    return out;
}

BoundInputs::BoundInputs(const vulkan::Device& device, const PassInputs& inputs, VkShaderStageFlags stages)
    : block(
          vulkan::device_buffer(device, inputs.block.data(), inputs.block.size(), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT)),
      buffer(vulkan::device_buffer(device, inputs.buffer.data(), inputs.buffer.size() * sizeof(float),
                                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)),
      sampler(vulkan::make_sampler(device, inputs.filter, inputs.address, inputs.address)) {
    for (const Texture& t : inputs.textures) images.push_back(upload(device, t));
    std::uint32_t binding = 0;
    resources.push_back({binding++, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, stages, &block});
    for (const vulkan::Image& image : images)
        resources.push_back(
            {binding++, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, stages, nullptr, &image, sampler.get()});
    if (!inputs.buffer.empty()) resources.push_back({binding++, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, stages, &buffer});
}

std::vector<Texture> draw_fullscreen(const vulkan::Device& device, glm::ivec2 size, const std::string& fragment_file,
                                     const Variant& variant, const PassInputs& inputs,
                                     const std::vector<std::string>& formats) {
    std::vector<VkFormat> targets_of;
    for (const std::string& f : formats) targets_of.push_back(vk_format(f));
    const vulkan::Targets targets =
        vulkan::make_targets(device, {std::uint32_t(size.x), std::uint32_t(size.y)}, targets_of);
    const BoundInputs bound(device, inputs, VK_SHADER_STAGE_FRAGMENT_BIT);
    const vulkan::DescriptorSet set = vulkan::make_descriptor_set(device, bound.resources);
    vulkan::GraphicsOptions options;
    options.vertex_shader = compile("fullscreen.vert", variant);
    options.fragment_shader = compile(fragment_file, variant);
    options.name = fragment_file;
    options.set = set.layout.get();
    const vulkan::GraphicsPipeline pipeline = vulkan::make_graphics_pipeline(device, targets, options);
    device.run([&](VkCommandBuffer commands) {
        targets.begin(commands);
        pipeline.bind(commands);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.layout.get(), 0, 1, &set.set, 0,
                                nullptr);
        vkCmdDraw(commands, 3, 1, 0, 0);
        targets.end(commands);
    });
    std::vector<Texture> out;
    for (std::size_t i = 0; i < formats.size(); ++i) out.push_back(download(device, targets.colours[i], formats[i]));
    return out;
}

}  // namespace plumb::foreign
