// What a BoundStage can do besides, if its kernel computes one item: the outcomes of many items at once.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/binding.h"

namespace plumb {

class PacketOutcomes {
  public:
    static constexpr std::size_t most = 16;

    virtual ~PacketOutcomes() = default;
    // out[i] becomes what BoundStage::outcomes() says of pixels[i] without choices, to the bit, whatever the instruction
    // set. At most `most` pixels.
    virtual void outcomes(std::span<const glm::ivec2> pixels, const DeviceProfile& profile, Isa isa,
                          std::vector<Outcome>* out) const = 0;
};

}  // namespace plumb
