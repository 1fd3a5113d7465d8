// The SPIR-V of every twin, embedded in the program: once as it is, and once with its taps.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace plumb::vulkan {

struct Twin {
    std::string name;                          // its path from the project's root: "gi/rsm/gather.comp"
    std::span<const std::uint32_t> spirv;
    std::span<const std::uint32_t> tapped;     // the same with TAP() writing to the buffer of tap.glsl
    std::vector<std::string> taps;             // names of its TAP() sites, by number
};

// Throws Error for a name that was not compiled in.
Twin find_twin(const std::string& name);

// Of set 0, bound in the tapped twin alone: std430 { int pixel_x, pixel_y, capacity, count; Tap taps[]; } with
// Tap = { int site, int sample, int components, int run; vec4 value }. core/tap.glsl writes it at that one pixel; count
// may exceed capacity. run: the fragment's triangle, as several may be drawn at the pixel; 0 in a compute stage.
inline constexpr std::uint32_t tap_binding = 31;

}  // namespace plumb::vulkan
