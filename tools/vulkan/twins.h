// The SPIR-V of every twin, embedded in the program: as it is, with its taps, and with its choices.
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
    std::span<const std::uint32_t> choosing;   // the same with CHOICE() writing; of compute stages alone
    std::vector<std::string> taps;             // names of its TAP() sites, by number
};

// Throws Error for a name that was not compiled in.
Twin find_twin(const std::string& name);

// Of set 0, bound in the tapped twin alone: std430 { int pixel_x, pixel_y, capacity, count; Tap taps[]; } with
// Tap = { int site, int sample, int components, int run; vec4 value }. core/tap.glsl writes it at that one pixel; count
// may exceed capacity. run: the fragment's triangle, as several may be drawn at the pixel; 0 in a compute stage.
inline constexpr std::uint32_t tap_binding = 31;

// Bound in the choosing twin alone: std430 { int width, per_pixel; int choices[]; }, [height][width][per_pixel].
inline constexpr std::uint32_t choice_binding = 30;

}  // namespace plumb::vulkan
