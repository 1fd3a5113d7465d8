// Sample patterns that were made before. One of 200 samples in 64 rotations takes 20 ms, by sines that are exact to the last bit:
// lights whose maps have one size share it, and so does the next frame.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "gi/rsm/gather.h"

namespace plumb::rsm {

class KeptPatterns {
  public:
    // pattern_of() of the same. Throws InputError as it does.
    std::shared_ptr<const Pattern> of(const GatherParams& params, int map_size, std::uint32_t seed);

  private:
    static constexpr std::size_t most = 4;  // that are held, those used last
    std::vector<std::pair<std::uint64_t, std::shared_ptr<const Pattern>>> made_;  // by a hash of all that it is made from
};

}  // namespace plumb::rsm
