// The SPIR-V of every twin, embedded in the program: once as it is, and once with its taps.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/tap.h"

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
// may exceed capacity. run: the fragment's triangle, 0 in a compute stage.
inline constexpr std::uint32_t tap_binding = 31;

// What such a buffer holds, in the order in which it ran. Several triangles may be drawn at the pixel, at the same time:
// of them the one whose tap "z" is nearest is seen.
std::vector<TapValue> read_taps(const Twin& twin, std::span<const std::int32_t> buffer, bool reversed_z);

}  // namespace plumb::vulkan
