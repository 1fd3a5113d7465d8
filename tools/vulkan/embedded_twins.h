// The table that the build generates (cmake/twins.cmake); empty where it had no compiler for twins.
#pragma once

#include <cstdint>
#include <span>

namespace plumb::vulkan {

struct EmbeddedTwin {
    const char* name;
    std::span<const std::uint32_t> spirv, tapped, choosing;
    const char* const* taps;  // ends with a null
};

std::span<const EmbeddedTwin> embedded_twins();

}  // namespace plumb::vulkan
