// The buffer that a tapped twin writes the values of one pixel to (twins.h).
#pragma once

#include <glm/glm.hpp>

#include "core/tap.h"
#include "tools/vulkan/memory.h"
#include "tools/vulkan/twins.h"

namespace plumb::vulkan {

class TapBuffer {
  public:
    TapBuffer() = default;
    TapBuffer(const Device& device, glm::ivec2 pixel);

    const Buffer& buffer() const { return buffer_; }
    void clear();  // before every submission

    // What was written, in the order in which it ran. Several triangles may be drawn at the pixel: of them the one
    // whose tap "z" is nearest is seen, and of equal ones the one that was drawn first. Throws Error where not all
    // fitted.
    std::vector<TapValue> values(const Twin& twin, bool reversed_z) const;

  private:
    Buffer buffer_;
};

}  // namespace plumb::vulkan
