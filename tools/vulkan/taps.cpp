#include "tools/vulkan/taps.h"

#include <fmt/format.h>

namespace plumb::vulkan {
namespace {

// What core/tap.glsl declares, std430.
struct Header {
    std::int32_t x, y, capacity, count;
};
struct Tap {
    std::int32_t site, sample, components, run;
    float value[4];
};
static_assert(sizeof(Header) == 16 && sizeof(Tap) == 32);

constexpr std::int32_t capacity = 1 << 20;  // every texel of a map of 256 x 256, 16 values each

Header& header_of(const Buffer& buffer) { return *static_cast<Header*>(buffer.mapped); }

// Which triangle is seen; 0 of a compute stage, which has no "z".
int seen_run(const Twin& twin, std::span<const Tap> taps, bool reversed_z) {
    const Tap* seen = nullptr;
    for (const Tap& t : taps) {
        if (twin.taps[std::size_t(t.site)] != "z") continue;
        const float z = t.value[0], best = seen ? seen->value[0] : 0;
        const bool nearer = reversed_z ? z > best : z < best;
        if (!seen || nearer || (z == best && t.run < seen->run)) seen = &t;
    }
    return seen ? seen->run : 0;
}

}  // namespace

TapBuffer::TapBuffer(const Device& device, glm::ivec2 pixel)
    : buffer_(host_buffer(device, sizeof(Header) + std::size_t(capacity) * sizeof(Tap),
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)) {
    header_of(buffer_) = {pixel.x, pixel.y, capacity, 0};
}

void TapBuffer::clear() { header_of(buffer_).count = 0; }

std::vector<TapValue> TapBuffer::values(const Twin& twin, bool reversed_z) const {
    const Header& header = header_of(buffer_);
    if (header.count > capacity)
        throw Error(
            fmt::format("{}: {} values at pixel {},{}; {} fit", twin.name, header.count, header.x, header.y, capacity));
    const std::span<const Tap> taps(reinterpret_cast<const Tap*>(&header + 1), std::size_t(header.count));
    for (const Tap& t : taps)
        if (t.site < 0 || std::size_t(t.site) >= twin.taps.size() || t.components < 1 || t.components > 4)
            throw Error(fmt::format("{}: the device wrote a tap that the twin does not have", twin.name));
    const int run = seen_run(twin, taps, reversed_z);
    std::vector<TapValue> out;
    for (const Tap& t : taps)
        if (t.run == run)
            out.push_back({twin.taps[std::size_t(t.site)], t.sample, {t.value, t.value + t.components}, ""});
    return out;
}

}  // namespace plumb::vulkan
