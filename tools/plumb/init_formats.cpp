#include "tools/plumb/init_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plumb::cli {

namespace {

constexpr std::size_t texel_sizes[] = {16, 8, 4, 12, 6, 3, 2, 1};

// The likeliest format of so many bytes; "" where no format of theirs holds what the slot does.
std::string raw_format(const Slot& slot, std::size_t bytes_a_texel) {
    const bool integers = slot.dtype != DType::f32, alone = slot.channels == 1;
    // Positions have no range that eight bits could share out.
    const bool wide = slot.name.ends_with("position");
    switch (bytes_a_texel) {
        case 16: return integers ? "R32G32B32A32_SINT" : "R32G32B32A32_SFLOAT";
        case 12: return integers || alone ? "" : "R32G32B32_SFLOAT";
        case 8: return integers ? "R32G32_SINT" : slot.channels == 2 ? "R32G32_SFLOAT" : "R16G16B16A16_SFLOAT";
        case 6: return integers || slot.channels != 4 ? "" : "R16G16B16_SFLOAT";
        case 4: return integers ? "R32_SINT" : alone ? "R32_SFLOAT" : wide ? "" : "R8G8B8A8_UNORM";
        case 3: return integers || slot.channels != 4 || wide ? "" : "R8G8B8_UNORM";
        case 2: return alone && !integers ? "R16_SFLOAT" : "";
        case 1: return alone && !integers ? "R8_UNORM" : "";
        default: return "";
    }
}

std::string size_text(glm::ivec2 size) { return fmt::format("{} x {}", size.x, size.y); }

std::string guess_buffer(const Slot& slot, std::size_t bytes, io::DumpSpec& spec) {
    const std::size_t element = 4 * std::size_t(slot.channels);
    const char* names[] = {"", "R32", "R32G32", "R32G32B32", "R32G32B32A32"};
    spec.vk_format = std::string(names[slot.channels]) + (slot.dtype == DType::f32 ? "_SFLOAT" : "_SINT");
    spec.count = int(bytes / element);
    return bytes % element == 0 ? "" : fmt::format("has {} bytes: expected elements of {}", bytes, element);
}

std::string guess_layers(const Slot& slot, std::size_t bytes, glm::ivec2 frame, io::DumpSpec& spec) {
    spec.vk_format = slot.channels == 1 ? "R32_SFLOAT" : "R32G32B32A32_SFLOAT";
    const std::size_t row = std::size_t(frame.x) * 4 * std::size_t(slot.channels);
    if (row == 0) return fmt::format("has {} bytes: layers of which size? No output says it", bytes);
    spec.width = frame.x, spec.height = int(bytes / row);
    return bytes % row == 0 ? "" : fmt::format("has {} bytes: expected layers of {} {}", bytes, size_text(frame), spec.vk_format);
}

}  // namespace

glm::ivec2 square(std::size_t texels) {
    const int side = int(std::lround(std::sqrt(double(texels))));
    return std::size_t(side) * std::size_t(side) == texels ? glm::ivec2(side) : glm::ivec2(0);
}

int map_side(const std::vector<std::pair<const Slot*, std::size_t>>& files) {
    if (files.empty()) return 0;
    auto fits = [&](int side) {
        const std::size_t texels = std::size_t(side) * std::size_t(side);
        return std::all_of(files.begin(), files.end(), [&](const auto& file) {
            return file.second % texels == 0 && raw_format(*file.first, file.second / texels) != "";
        });
    };
    for (const std::size_t texel : texel_sizes) {
        if (files[0].second % texel != 0) continue;
        const int side = square(files[0].second / texel).x;
        if (side > 0 && fits(side)) return side;
    }
    return 0;
}

std::string guess_raw(const Slot& slot, std::size_t bytes, glm::ivec2 frame, int map, io::DumpSpec& spec) {
    if (bytes == 0) return "is empty";
    if (slot.kind == SlotKind::buffer) return guess_buffer(slot, bytes, spec);
    if (slot.kind == SlotKind::image_array) return guess_layers(slot, bytes, frame, spec);
    // Maps are square, of a format of so many bytes.
    for (const std::size_t texel : texel_sizes) {
        const std::string format = raw_format(slot, texel);
        if (format.empty() || bytes % texel != 0) continue;
        const std::size_t texels = bytes / texel;
        glm::ivec2 size(0);
        if (slot.frame && frame.x > 0 && texels == std::size_t(frame.x) * std::size_t(frame.y)) size = frame;
        if (!slot.frame) size = map > 0 && square(texels).x != map ? glm::ivec2(0) : square(texels);
        if (size.x == 0) continue;
        spec.vk_format = format, spec.width = size.x, spec.height = size.y;
        // What has no sign holds normals as 0 to 1.
        if (slot.name.ends_with("normal") && format.ends_with("_UNORM")) spec.encoding = "biased";
        return "";
    }
    if (!slot.frame) return fmt::format("has {} bytes: no square of texels of a format that fits", bytes);
    if (frame.x == 0) return fmt::format("has {} bytes: of which size? No output says it", bytes);
    return fmt::format("has {} bytes, {:.4g} for each of {} texels: no format of so many fits; row_pitch and offset say where "
                       "rows begin", bytes, double(bytes) / (double(frame.x) * frame.y), size_text(frame));
}

}  // namespace plumb::cli
