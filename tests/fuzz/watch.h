// One input through one target: what it takes at once is compared with what an honest reader needs.
#pragma once

#include <string>

#include "targets.h"

namespace plumb::fuzz {

inline constexpr std::size_t memory_factor = 10;             // of the honest need

struct Watched {
    std::size_t need = 0;
    std::size_t peak = 0;  // bytes at once, or a bound; 0: nothing counts them in this build
    bool within = false;   // peak is at most ten times the need, and the format's slack
};

// Runs the format's target, twice where the sum of all that it takes is not within the limit already.
Watched watch(const Format& format, const std::uint8_t* data, std::size_t size);

}  // namespace plumb::fuzz
