// The peer: the scene as a good engine draws it through Vulkan. One draw a material (its texture bound, its constants
// pushed), opaque ones first, alpha-tested ones with a pipeline of their own; indexed; everything resident.
#pragma once

#include <optional>
#include <vector>

#include "core/scene.h"
#include "core/view.h"
#include "raster/gbuffer.h"
#include "tools/vulkan/graphics.h"

namespace plumb::bench {

class Peer {
  public:
    // Uploads geometry and textures.
    Peer(const vulkan::Device& device, const Scene& scene, const Geometry& geometry);

    // Makes the targets and writes the commands of a frame.
    void set_view(const View& view, glm::ivec2 size);

    // Draws the frame: milliseconds from submission to its end.
    double draw();
    // What the device's own clock says of the last frame.
    double device_ms() const { return stopwatch_.ms(); }

    // The targets: position, normal, albedo, depth.
    raster::GBuffer read() const;

    int draws() const { return int(batches_.size()); }

  private:
    struct Batch {
        int material;
        std::uint32_t first, count;  // indices
    };
    enum PipelineKind : int { plain, textured, masked, textured_masked };
    PipelineKind kind_of(const Material& material) const;
    void upload_textures(const Scene& scene);
    void make_batches(const Geometry& geometry);
    void record_frame(VkCommandBuffer commands, const View& view) const;

    const vulkan::Device& device_;
    std::vector<Material> materials_;
    vulkan::Buffer vertices_, indices_;
    std::vector<Batch> batches_;
    std::vector<vulkan::Image> textures_;
    std::vector<vulkan::Sampler> samplers_;
    vulkan::TextureSets sets_;  // set 0: the white texel; set i + 1: texture i
    vulkan::Stopwatch stopwatch_;
    std::optional<vulkan::Targets> targets_;
    std::vector<vulkan::GraphicsPipeline> pipelines_;  // by PipelineKind
    VkCommandBuffer frame_ = VK_NULL_HANDLE;
};

}  // namespace plumb::bench
