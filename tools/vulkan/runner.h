// Runs a stage's twin on a device with the very data that our kernel gets.
#pragma once

#include <optional>

#include "core/binding.h"
#include "tools/vulkan/device.h"

namespace plumb::vulkan {

struct RunTwin {
    std::optional<glm::ivec2> tap = {};  // also list this pixel's values, from the tapped twin
    bool choices = false;                  // also list every pixel's discrete choices, from the choosing twin
    // Instead of the embedded SPIR-V (raster stages: of the fragment stage): what the mutator compiled.
    std::span<const std::uint32_t> spirv = {};
    std::span<const std::uint32_t> vertex_spirv = {};  // the same, of a raster stage's vertex stage
    int repeat = 1;                   // runs; the median of their times is reported
    Format colour = Format::rgba32f;  // of storage images and colour targets of four floats: or rgba16f
    // Of input images of four floats that are not of the frame's size, a light's maps: or rgba16f, for values that halves
    // hold exactly.
    Format maps = Format::rgba32f;
    bool selects = false;  // select() will be called
    // Vertices beyond so many bytes are drawn in batches; 0: as many as a buffer of the device may have.
    std::size_t largest_buffer = 0;
};

struct TwinResult {
    Bundle outputs;              // by the names of StageBinding::outputs; rgba16f: widened to float
    std::vector<TapValue> taps;  // in the order in which they ran
    // What core/decisions.h can follow: [height][width][choices_a_pixel], no_choice where a pixel made fewer.
    std::vector<std::int32_t> choices;
    int choices_a_pixel = 0;
    double ms = 0;               // wall clock of one submission
};

// Throws Error for what the device refuses. What a stage does not write is 0, and -1 in outputs of indices.
TwinResult run_twin(const Device& device, const StageBinding& binding, const StageData& data,
                    const RunTwin& options = {});

// The same, kept on the device, for benchmarks: buffers and pipelines are made once.
class PreparedTwin {
  public:
    PreparedTwin(const Device& device, const StageBinding& binding, const StageData& data, const RunTwin& options = {});
    ~PreparedTwin();
    PreparedTwin(PreparedTwin&&) noexcept;
    double submit();  // ms of wall clock, submission to completion
    TwinResult read();

    // Runs other SPIR-V from now on, on the same data, and what it does not write is as at first. An empty vertex_spirv is
    // the embedded one. Throws Error for what the device refuses.
    void use(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> vertex_spirv = {});
    // The same with the pipeline of another twin of this stage on the same device, which is not compiled again.
    void use(const PreparedTwin& other);
    // From now on, of a twin with RunTwin::selects: invocations have that z, and run in the groups of these pixels alone;
    // none: everywhere. Of a raster stage nothing changes.
    void select(std::uint32_t z, std::span<const glm::ivec2> pixels);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace plumb::vulkan
