// What the tests of ISR's blur, upsampling and composition share: surfaces, what is lit of them, and how to run a stage.
#pragma once

#include <cmath>
#include <cstring>

#include "core/hash.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

inline const glm::ivec2 sizes[] = {{1, 1}, {2, 1}, {1, 3}, {3, 2}, {5, 5}, {17, 6}, {33, 40}, {64, 35}};
inline const glm::vec4 nothing(0, 0, 0, 1);  // of a pixel without a surface

inline float noise(int x, int y, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 7).x); }

// At the origin, looking along -z: what the surfaces below are seen by.
inline CoarseCamera eye(glm::ivec2 size) {
    Camera camera;
    camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1}, camera.up = {0, 1, 0};
    camera.fov_y_deg = 60, camera.near = 0.1, camera.far = 1e3;
    return coarse_camera(camera, 2 * size);
}

// A wall that faces the camera.
inline Image4 wall(glm::ivec2 size, float depth = 2) { return Image4(size.x, size.y, glm::vec4(0, 0, 1, depth)); }

// Normals and depths of noise, a tenth without a surface; and what is lit of it.
inline Image4 rough(glm::ivec2 size) {
    Image4 surface(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if (noise(x, y, 4) < 0.1f) continue;
            const glm::vec3 bump(noise(x, y, 5) - 0.5f, noise(x, y, 6) - 0.5f, 0.7f);
            surface(x, y) = glm::vec4(glm::normalize(bump), 2 + 0.1f * noise(x, y, 0));
        }
    return surface;
}
inline Image4 lit_of(const Image4& surface) {
    Image4 lit(surface.width, surface.height, nothing);
    for (int y = 0; y < lit.height; ++y)
        for (int x = 0; x < lit.width; ++x)
            if (surface(x, y).w > 0) lit(x, y) = {noise(x, y, 1), 3 * noise(x, y, 2), noise(x, y, 3), noise(x, y, 8)};
    return lit;
}
inline bool covered(const Image4& surface, int x, int y) { return surface(x, y).w > 0; }

inline IsrParams with(Blur blur, Variant variant = Variant::corrected, int radius = 4, float sigma = 2) {
    IsrParams params;
    params.blur = blur, params.variant = variant, params.blur_radius = radius, params.blur_sigma = sigma;
    return params;
}
inline IsrParams with(Upsample upsample, Variant variant = Variant::corrected, float epsilon = 1e-3f) {
    IsrParams params;
    params.upsample = upsample, params.variant = variant, params.epsilon = epsilon;
    return params;
}

inline Image4 blurred(const IsrParams& params, const Image4& lit, const Image4& surface, Direction direction,
               const RunOptions& options = {}, const raster::Covered* tiles = nullptr) {
    Image4 out;
    run(params, BlurInputs{&lit, &surface, eye(size_of(surface)), direction, tiles}, options, out);
    return out;
}
inline Image4 upsampled(const IsrParams& params, const Image4& lit, const Image4& surface, const Image4& full,
                 const RunOptions& options = {}, const raster::Covered* tiles = nullptr) {
    Image4 out;
    run(params, UpsampleInputs{&lit, &surface, &full, &full, 0.1, 10, tiles}, options, out);  // full: normal and depth
    return out;
}

inline bool same_bits(const Image4& a, const Image4& b) {
    return a.width == b.width && a.height == b.height && !a.empty() &&
           std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

// |a - b| / |b|, and infinity where either is no number.
inline double off(double a, double b) {
    const double d = std::abs(a - b) / std::abs(b);
    return d == d ? d : INFINITY;
}

inline double gaussian(int d, int radius, double sigma) {
    double total = 0;
    for (int i = -radius; i <= radius; ++i) total += std::exp(-i * i / (2 * sigma * sigma));
    return std::abs(d) <= radius ? std::exp(-d * d / (2 * sigma * sigma)) / total : 0;
}

inline const Blur blurs[] = {Blur::none, Blur::gaussian, Blur::edge_aware};
inline const Direction directions[] = {Direction::horizontal, Direction::vertical};

}  // namespace plumb::isr
