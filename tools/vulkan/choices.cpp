#include "tools/vulkan/choices.h"

#include <fmt/format.h>

#include <algorithm>

namespace plumb::vulkan {
namespace {

// What core/tap.glsl declares, std430; the choices follow.
struct Header {
    std::int32_t width, per_pixel;
};
static_assert(sizeof(Header) == 8);

constexpr int capacity = 8;  // a pixel; one place more shows what does not fit

}  // namespace

ChoiceBuffer::ChoiceBuffer(const Device& device, glm::ivec2 size)
    : pixels_(std::size_t(size.x) * std::size_t(size.y)) {
    const std::size_t places = pixels_ * (capacity + 1);
    buffer_ = host_buffer(device, sizeof(Header) + places * sizeof(std::int32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    auto* header = static_cast<Header*>(buffer_.mapped);
    *header = {size.x, capacity + 1};
    std::fill_n(reinterpret_cast<std::int32_t*>(header + 1), places, no_choice);
}

std::vector<std::int32_t> ChoiceBuffer::values(int& per_pixel) const {
    const auto* places = reinterpret_cast<const std::int32_t*>(static_cast<const Header*>(buffer_.mapped) + 1);
    per_pixel = 0;
    for (std::size_t i = 0; i < pixels_; ++i)
        while (per_pixel <= capacity && places[i * (capacity + 1) + std::size_t(per_pixel)] != no_choice) ++per_pixel;
    if (per_pixel > capacity) throw Error(fmt::format("a pixel made more choices than the {} that fit", capacity));
    std::vector<std::int32_t> out;
    out.reserve(pixels_ * std::size_t(per_pixel));
    for (std::size_t i = 0; i < pixels_; ++i) {
        const std::int32_t* pixel = places + i * (capacity + 1);
        out.insert(out.end(), pixel, pixel + per_pixel);
    }
    return out;
}

}  // namespace plumb::vulkan
