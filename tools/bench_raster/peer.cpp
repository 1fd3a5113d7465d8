#include "tools/bench_raster/peer.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/number.h"

namespace plumb::bench {
namespace {

// What peer.vert and peer.frag declare.
struct Push {
    glm::mat4 world_to_clip;
    glm::vec4 reflectance;
    float alpha_cutoff;
};
static_assert(sizeof(Push) == 84);

VkSamplerAddressMode address_mode(Wrap wrap) {
    switch (wrap) {
        case Wrap::mirrored_repeat:
            return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
        case Wrap::clamp_to_edge:
            return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        default:
            return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    }
}

void read_rgba16f(const vulkan::Device& device, const vulkan::Image& image, Image4& out) {
    out = Image4(int(image.size.width), int(image.size.height));
    std::vector<Half> halves(4 * out.size());
    vulkan::read_image(device, image, halves.data(), halves.size() * sizeof(Half));
    for (std::size_t i = 0; i < out.size(); ++i)
        for (int c = 0; c < 4; ++c) out.texels[i][c] = half_to_float(halves[4 * i + std::size_t(c)]);
}

}  // namespace

Peer::Peer(const vulkan::Device& device, const Scene& scene, const Geometry& geometry)
    : device_(device), materials_(scene.materials), stopwatch_(device) {
    vertices_ = vulkan::device_buffer(device, geometry.vertices.data(), geometry.vertices.size() * sizeof(Vertex),
                                      VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    make_batches(geometry);
    upload_textures(scene);
}

Peer::PipelineKind Peer::kind_of(const Material& material) const {
    const bool has_texture = material.texture >= 0;
    if (material.alpha_cutoff > 0) return has_texture ? textured_masked : masked;
    return has_texture ? textured : plain;
}

// Sorts the triangles by pipeline, then by material, each in their own order.
void Peer::make_batches(const Geometry& geometry) {
    std::vector<std::vector<std::uint32_t>> of_material(materials_.size());
    for (std::size_t t = 0; t < geometry.triangles.size(); ++t) {
        std::vector<std::uint32_t>& list = of_material[std::size_t(geometry.material[t])];
        for (int corner = 0; corner < 3; ++corner) list.push_back(geometry.triangles[t][corner]);
    }
    std::vector<int> order(materials_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return kind_of(materials_[std::size_t(a)]) < kind_of(materials_[std::size_t(b)]);
    });
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * geometry.triangles.size());
    for (int m : order) {
        const std::vector<std::uint32_t>& list = of_material[std::size_t(m)];
        if (list.empty()) continue;
        batches_.push_back({m, std::uint32_t(indices.size()), std::uint32_t(list.size())});
        indices.insert(indices.end(), list.begin(), list.end());
    }
    indices_ = vulkan::device_buffer(device_, indices.data(), indices.size() * 4, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
}

void Peer::upload_textures(const Scene& scene) {
    std::vector<vulkan::SampledTexture> sampled;
    auto add = [&](const Texture& t) {
        const VkFormat format = t.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
        const VkExtent2D size{std::uint32_t(t.texels.width), std::uint32_t(t.texels.height)};
        textures_.push_back(vulkan::make_texture(device_, format, size, t.texels.data(), 4 * t.texels.size()));
        samplers_.push_back(vulkan::make_sampler(device_,
                                                 t.filter == Filter::nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR,
                                                 address_mode(t.wrap_u), address_mode(t.wrap_v)));
        sampled.push_back({textures_.back().view.get(), samplers_.back().get()});
    };
    Texture white;
    white.texels = Image<std::uint32_t>(1, 1, 0xffffffffu);
    add(white);
    for (const Texture& t : scene.textures) add(t);
    sets_ = vulkan::make_texture_sets(device_, sampled);
}

void Peer::set_view(const View& view, glm::ivec2 size) {
    if (frame_) device_.free(frame_);
    frame_ = VK_NULL_HANDLE;
    pipelines_.clear();
    targets_ = vulkan::make_targets(
        device_, {std::uint32_t(size.x), std::uint32_t(size.y)},
        {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT});
    vulkan::GraphicsOptions options;
    options.vertex_shader = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tools.bench_raster.peer.vert.spv");
    options.fragment_shader = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tools.bench_raster.peer.frag.spv");
    options.name = "tools/bench_raster/peer";
    options.stride = sizeof(Vertex);
    options.attributes = {{VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, position)},
                          {VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, normal)}};
    options.push_bytes = sizeof(Push);
    options.samplers = 1;
    for (PipelineKind kind : {plain, textured, masked, textured_masked}) {
        options.constants = {kind == textured || kind == textured_masked, kind == masked || kind == textured_masked};
        pipelines_.push_back(vulkan::make_graphics_pipeline(device_, *targets_, options));
    }
    frame_ = device_.record([&](VkCommandBuffer commands) { record_frame(commands, view); });
}

void Peer::record_frame(VkCommandBuffer commands, const View& view) const {
    stopwatch_.start(commands);
    targets_->begin(commands);
    const VkBuffer vertices = vertices_.get();
    const VkDeviceSize offset = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &offset);
    vkCmdBindIndexBuffer(commands, indices_.get(), 0, VK_INDEX_TYPE_UINT32);
    Push push{glm::mat4(view.world_to_clip()), {}, 0};
    int bound = -1;
    for (const Batch& batch : batches_) {
        const Material& m = materials_[std::size_t(batch.material)];
        const int kind = kind_of(m);
        const vulkan::GraphicsPipeline& pipeline = pipelines_[std::size_t(kind)];
        if (kind != bound) pipeline.bind(commands);
        bound = kind;
        push.reflectance = glm::vec4(m.reflectance, m.alpha);
        push.alpha_cutoff = m.alpha_cutoff;
        pipeline.push(commands, 0, sizeof push, &push);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.layout.get(), 0, 1,
                                &sets_.sets[std::size_t(m.texture + 1)], 0, nullptr);
        vkCmdDrawIndexed(commands, batch.count, 1, batch.first, 0, 0);
    }
    targets_->end(commands);
    stopwatch_.stop(commands);
}

double Peer::draw() { return device_.submit(frame_); }

raster::GBuffer Peer::read() const {
    raster::GBuffer out;
    read_rgba16f(device_, targets_->colours[0], out.position);
    read_rgba16f(device_, targets_->colours[1], out.normal);
    read_rgba16f(device_, targets_->colours[2], out.albedo);
    out.depth = Image1(out.position.width, out.position.height);
    vulkan::read_image(device_, targets_->depth, out.depth.data(), out.depth.size() * sizeof(float));
    return out;
}

}  // namespace plumb::bench
