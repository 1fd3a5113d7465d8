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

}  // namespace

// One place more shows what does not fit.
ChoiceBuffer::ChoiceBuffer(const Device& device, glm::ivec2 size, int capacity)
    : pixels_(std::size_t(size.x) * std::size_t(size.y)), capacity_(std::size_t(capacity)) {
    const std::size_t places = pixels_ * (capacity_ + 1);
    buffer_ = host_buffer(device, sizeof(Header) + places * sizeof(std::int32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    auto* header = static_cast<Header*>(buffer_.mapped);
    *header = {size.x, capacity + 1};
    std::fill_n(reinterpret_cast<std::int32_t*>(header + 1), places, no_choice);
}

std::vector<std::int32_t> ChoiceBuffer::values(int& per_pixel) const {
    const auto* places = reinterpret_cast<const std::int32_t*>(static_cast<const Header*>(buffer_.mapped) + 1);
    per_pixel = 0;
    for (std::size_t i = 0; i < pixels_; ++i)
        while (per_pixel <= int(capacity_) && places[i * (capacity_ + 1) + std::size_t(per_pixel)] != no_choice)
            ++per_pixel;
    if (per_pixel > int(capacity_))
        throw Error(fmt::format("a pixel made more choices than the {} that fit", capacity_));
    std::vector<std::int32_t> out;
    out.reserve(pixels_ * std::size_t(per_pixel));
    for (std::size_t i = 0; i < pixels_; ++i) {
        const std::int32_t* pixel = places + i * (capacity_ + 1);
        out.insert(out.end(), pixel, pixel + per_pixel);
    }
    return out;
}

}  // namespace plumb::vulkan
