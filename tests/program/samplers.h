// A light's map read through samplers, for tests of a manifest's words.
#pragma once

#include "tests/program/vocabulary.h"

namespace plumb::program {

// As Vulkan 1.3 (16) has a sampler: nearest or linear, and what lies beyond the map.
struct Sampler {
    bool linear;
    std::string address;
    glm::vec4 border{0};
    int fraction_bits = 0;  // to which a device rounds the fractions; 0: not at all
    float step = 0;         // to multiples of which it cuts off what it blends; 0: not at all

    glm::vec3 texel(const std::vector<float>& image, int x, int y) const {
        auto place = [&](int i) {
            if (address == "edge") return std::clamp(i, 0, map_side - 1);
            if (address == "wrap") return ((i % map_side) + map_side) % map_side;
            return i < 0 || i >= map_side ? -1 : i;
        };
        const int column = place(x), row = place(y);
        if (column < 0 || row < 0) return glm::vec3(border);
        return xyz(image, std::size_t(row) * map_side + std::size_t(column));
    }
    glm::vec3 operator()(const std::vector<float>& image, float u, float v) const {
        if (!linear) return texel(image, int(std::floor(u)), int(std::floor(v)));
        u -= 0.5f, v -= 0.5f;
        const int x = int(std::floor(u)), y = int(std::floor(v));
        auto fraction = [&](float f) {
            const float steps = float(1 << fraction_bits);
            return fraction_bits > 0 ? std::floor(f * steps) / steps : f;
        };
        const float a = fraction(u - float(x)), b = fraction(v - float(y));
        auto blend = [&](const glm::vec3& from, const glm::vec3& to, float t) {
            return step > 0 ? from + glm::floor((to - from) * t / step) * step : from * (1.0f - t) + to * t;
        };
        return blend(blend(texel(image, x, y), texel(image, x + 1, y), a), blend(texel(image, x, y + 1), texel(image, x + 1, y + 1), a), b);
    }
    std::string words() const {
        return fmt::format("filter = \"{}\"\naddress = \"{}\"\n", linear ? "linear" : "nearest", address) +
               (border == glm::vec4(0) ? "" : fmt::format("border = [{}, {}, {}, 0]\n", border.x, border.y, border.z));
    }
};

// With that sampler at each of the three images, its samples moved so far that many lie beyond the map.
inline void shade(const Exported& e, const Sampler& s) {
    gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; },
           [&](int, int, std::size_t k, float u, float v) -> std::optional<Sample> {
               const float x = u + e.positions[2 * k], y = v + e.positions[2 * k + 1];
               return Sample{s(e.map_position, x, y), s(e.map_normal, x, y), s(e.flux, x, y), e.weights[k]};
           },
           e.weights.size());
}

inline const std::array<std::string, 3> map_images = {"rsm_position", "rsm_normal", "rsm_flux"};

inline void with_words(Exported& e, const std::string& manifest, const std::string& words) {
    e.manifest = manifest;
    for (const std::string& image : map_images)
        e.replace_input(image, "file = \"" + image + ".bin\"\nvk_format = \"R32G32B32A32_SFLOAT\"\nwidth = 48\nheight = 48\n" + words);
}

// Light up to the map's edge, and other light on each side.
inline void light_all_over(Exported& e) {
    for (int y = 0; y < map_side; ++y)
        for (int x = 0; x < map_side; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                e.flux[4 * (std::size_t(y) * map_side + std::size_t(x)) + c] = 0.001f * float(1 + (x * 5 + y * 3 + 7 * int(c)) % 11 + (x < 9 ? 20 : 0));
    write_words(e.folder + "/rsm_position.bin", e.map_position);
    write_words(e.folder + "/rsm_normal.bin", e.map_normal);
    write_words(e.folder + "/rsm_flux.bin", e.flux);
}

}  // namespace plumb::program
