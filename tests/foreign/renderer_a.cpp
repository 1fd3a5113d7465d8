// Renderer A: gather_view.comp. View space is a rigid motion of the world's, under which the stages stay the same: what
// is dumped is in view space, and so is the light's matrix in the manifest.
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/foreign/renderers.h"
#include "tests/foreign/vulkan_textures.h"
#include "tools/vulkan/compute.h"

namespace plumb::foreign {

namespace {

constexpr float bias = 0.02f, least_distance2 = 1e-4f;  // m, m2; the second as the shader has it

struct Block {
    glm::mat4 view_to_light;
    glm::vec4 light_position, light_axis;
    glm::ivec2 resolution;
    int taps;
    float shadow_bias;
};

struct Scene {
    Block block;
    Texture position, normal, map_position, map_normal, map_flux;
    Pattern taps;
};

Image4 turned(const Image4& image, const glm::dmat4& by, double w) {
    Image4 out = image;
    for (glm::vec4& v : out.texels) v = {glm::vec3(by * glm::dvec4(glm::dvec3(v), w)), v.w};
    return out;
}

Scene scene_of(const Exported& e, const Variant& variant) {
    const glm::dmat4 view = glm::lookAt(glm::dvec3(0.6, 1.3, 3.6), glm::dvec3(0, 0.9, 0), glm::dvec3(0, 1, 0));
    const int size = int(e.number("shadow", "map.size"));
    const Clip clip = clip_of(e.uniform("shadow", "map.to_texel_x"), e.uniform("shadow", "map.to_texel_y"),
                              e.uniform("shadow", "map.to_texel_w"), {size, size}, {0.05, 10});
    Scene s;
    s.block.view_to_light = glm::mat4(clip * glm::inverse(view));
    s.block.light_position = glm::vec4(view * glm::dvec4(e.vector("shadow", "eye"), 1));
    s.block.light_axis = glm::vec4(view * glm::dvec4(e.vector("shadow", "forward"), 0));
    s.block.resolution = {e.width(), e.height()};
    s.block.shadow_bias = bias;
    s.taps = spiral(24, 0.35f * float(size), false);
    s.block.taps = int(s.taps.size());

    const std::string gather = "rsm.disc_continuous";
    s.position = pack(turned(e.image(gather, "position"), view, 1), Format::rgba16f);
    s.normal = pack(turned(e.image(gather, "normal"), view, 0), Format::rgba16f);
    s.map_position = pack(turned(e.image("shadow", "map_position"), view, 1), Format::rgba16f);
    s.map_normal = pack(turned(e.image(gather, "rsm_normal"), view, 0), Format::rgba16f);
    s.map_flux = pack(e.image(gather, "rsm_flux"), Format::rgba16f);
    if (variant.host == "full floats")
        for (Texture* t : {&s.position, &s.normal, &s.map_position, &s.map_normal, &s.map_flux})
            *t = pack(unpack(*t), Format::rgba32f);
    return s;
}

struct Outputs {
    Texture bounce, lit;
};

Outputs run(const vulkan::Device& device, const Scene& s, const Variant& variant) {
    Block block = s.block;
    if (variant.host == "row-major") block.view_to_light = glm::transpose(block.view_to_light);
    PassInputs inputs;
    inputs.block = block_bytes(block);
    inputs.textures = {s.position, s.normal, s.map_position, s.map_normal, s.map_flux};
    if (variant.host == "last frame") inputs.textures[0] = moved(s.position, 2);
    if (variant.host == "linear") inputs.filter = VK_FILTER_LINEAR;
    for (const glm::vec3& tap : s.taps) inputs.buffer.insert(inputs.buffer.end(), {tap.x, tap.y, tap.z, 0});
    BoundInputs bound(device, inputs, VK_SHADER_STAGE_COMPUTE_BIT);

    // What the shader's text stores to says which format that is.
    const bool full = shader_text("gather_view.comp", variant).find("binding = 7, rgba32f") != std::string::npos;
    const std::string bounce_format = full ? "R32G32B32A32_SFLOAT" : "R16G16B16A16_SFLOAT", lit_format = "R32_SFLOAT";
    const VkExtent2D size{std::uint32_t(s.position.width), std::uint32_t(s.position.height)};
    const vulkan::Image bounce = vulkan::make_storage_image(device, vk_format(bounce_format), size, {});
    const vulkan::Image lit = vulkan::make_storage_image(device, vk_format(lit_format), size, {});
    for (const vulkan::Image* image : {&bounce, &lit})
        bound.resources.push_back({std::uint32_t(bound.resources.size()), VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                   VK_SHADER_STAGE_COMPUTE_BIT, nullptr, image});
    const vulkan::DescriptorSet set = vulkan::make_descriptor_set(device, bound.resources);
    const vulkan::ShaderModule shader = vulkan::make_shader(device, compile("gather_view.comp", variant), variant.name);
    const vulkan::ComputePipeline pipeline = vulkan::make_compute_pipeline(device, shader, set.layout.get());
    device.run([&](VkCommandBuffer commands) { pipeline.dispatch(commands, set.set, size); });
    return {download(device, bounce, bounce_format, VK_IMAGE_LAYOUT_GENERAL),
            download(device, lit, lit_format, VK_IMAGE_LAYOUT_GENERAL)};
}

}  // namespace

std::string render_in_view_space(const vulkan::Device& device, const Exported& e, const Variant& variant,
                                 const std::string& folder) {
    const Scene s = scene_of(e, variant);
    const Outputs made = run(device, s, variant);
    const io::DumpSpec position = write_texture(folder, "position", s.position, "xyz");
    const io::DumpSpec normal = write_texture(folder, "normal", s.normal, "xyz");
    const io::DumpSpec map_position = write_texture(folder, "map_position", s.map_position);

    io::ManifestStage gather = bare(e, "rsm.disc_continuous", "A: bounce");
    set_light(gather, s.block.view_to_light);
    gather.uniforms["least_distance2"] = {double(least_distance2)};
    for (const char* of_pattern : {"samples", "rotations", "reach"}) gather.uniforms.erase(of_pattern);
    gather.inputs = {{"position", position},
                     {"normal", normal},
                     {"rsm_position", map_position},
                     {"rsm_normal", write_texture(folder, "map_normal", s.map_normal)},
                     {"rsm_flux", write_texture(folder, "map_flux", s.map_flux)},
                     {"pattern", write_pattern(folder, "taps", s.taps)}};
    gather.outputs = {{"irradiance", write_texture(folder, "bounce", made.bounce, "xyz")}};

    io::ManifestStage shadow = bare(e, "shadow", "A: shadow");
    set_light(shadow, s.block.view_to_light);
    set(shadow, "eye", glm::vec3(s.block.light_position));
    set(shadow, "forward", glm::vec3(s.block.light_axis));
    shadow.uniforms["bias"] = {double(bias)};
    shadow.uniforms["slope_bias"] = {0};
    shadow.inputs = {{"position", position}, {"normal", normal}, {"map_position", map_position}};
    shadow.outputs = {{"visibility", write_texture(folder, "lit", made.lit, "x")}};

    io::Manifest manifest;
    manifest.file = folder + "/manifest.toml";
    manifest.device = device.name();
    manifest.stages = {gather, shadow};
    std::ofstream(manifest.file) << io::manifest_text(manifest);
    return manifest.file.string();
}

}  // namespace plumb::foreign
