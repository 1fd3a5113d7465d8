// The buffer that a choosing twin writes its discrete choices to (twins.h).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "tools/vulkan/memory.h"

namespace plumb::vulkan {

// What a pixel holds beyond the choices that it made; all choices are texels of maps.
inline constexpr std::int32_t no_choice = INT32_MIN;

class ChoiceBuffer {
  public:
    ChoiceBuffer() = default;
    // A pixel makes at most `capacity` choices.
    ChoiceBuffer(const Device& device, glm::ivec2 size, int capacity);

    const Buffer& buffer() const { return buffer_; }

    // [height][width][per_pixel]; per_pixel: the most that any pixel made. Throws Error where not all fitted.
    std::vector<std::int32_t> values(int& per_pixel) const;

  private:
    Buffer buffer_;
    std::size_t pixels_ = 0, capacity_ = 0;
};

}  // namespace plumb::vulkan
