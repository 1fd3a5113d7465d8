// What data for twins are made of: numbers from a seed, a floor and a wall, a map of a light.
#pragma once

#include <cstring>

#include "core/hash.h"
#include "gi/lend.h"
#include "gi/parity/stages.h"
#include "raster/light_view.h"
#include "raster/rsm.h"

namespace plumb::test {

// Numbers of [0, 1) that follow from a seed and a place.
inline float noise(int x, int y, int channel, std::uint32_t seed) {
    const auto h = pixel_hash<std::int32_t>(x, y, channel, std::int32_t(seed));
    return float(std::uint32_t(h.x) >> 8) * 0x1p-24f;
}

inline Image4 noise_image(glm::ivec2 size, std::uint32_t seed, float low, float high) {
    Image4 image(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 4; ++c) image(x, y)[c] = low + (high - low) * noise(x, y, c, seed);
    return image;
}

struct Points {
    Image4 position, normal;
};

// The left half a floor at y = 0, the right half a wall at z = -2, both 4 m wide, with rough normals; every 11th pixel
// is empty, every 13th a kilometre away.
inline Points room(glm::ivec2 size, std::uint32_t seed) {
    Points p{Image4(size.x, size.y), Image4(size.x, size.y)};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const int i = y * size.x + x;
            if (i % 11 == 0) continue;
            const float u = 4 * noise(x, y, 0, seed) - 2, v = 4 * noise(x, y, 1, seed) - 2;
            const bool floor = 2 * x < size.x;
            const float far = i % 13 == 0 ? 1000.0f : 1.0f;
            const glm::vec3 up = floor ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
            const glm::vec3 bump(noise(x, y, 2, seed) - 0.5f, noise(x, y, 3, seed) - 0.5f, noise(x, y, 4, seed) - 0.5f);
            p.position(x, y) = glm::vec4(far * (floor ? glm::vec3(u, 0, v) : glm::vec3(u, v + 2, -2)), 1 + u * u);
            p.normal(x, y) = glm::vec4(glm::normalize(up + 0.5f * bump), 1);
        }
    return p;
}

inline Light make_light(LightType type, int rsm_size) {
    Light light;
    light.type = type;
    light.position = {0.3f, 3, 0.7f};
    light.direction = glm::normalize(glm::vec3(0.2f, -1, -0.6f));
    light.intensity = {17.25f, 11.5f, 3.75f};
    light.cone_inner_deg = 30;
    light.rsm_size = rsm_size;
    return light;
}

// A map filled with points of the room, whatever the light sees of it.
inline raster::Rsm make_map(const Light& light, int face, std::uint32_t seed) {
    const std::vector<View> views = raster::light_views(light, {-2, 0, -2}, {2, 4, 2});
    raster::Rsm map = raster::unseen_rsm(light, views[std::size_t(face)]);
    const Points p = room({light.rsm_size, light.rsm_size}, seed);
    map.position = p.position;
    map.normal = p.normal;
    map.flux = noise_image({light.rsm_size, light.rsm_size}, seed + 1, 0, 0.02f);
    for (std::size_t i = 0; i < map.position.size(); ++i) {
        const bool covered = map.normal.texels[i].w > 0;
        map.position.texels[i].w = covered ? 1 + 3 * map.flux.texels[i].w / 0.02f : 0;
        map.flux.texels[i].w = 0;
        if (!covered) map.flux.texels[i] = glm::vec4(0);
    }
    map.records.assign(map.position.size() * 16, 0);
    for (std::size_t i = 0; i < map.position.size(); ++i) {
        std::memcpy(&map.records[16 * i], &map.position.texels[i], 16);
        std::memcpy(&map.records[16 * i + 4], &map.normal.texels[i], 16);
        std::memcpy(&map.records[16 * i + 8], &map.flux.texels[i], 16);
    }
    return map;
}

// A copy of all that is lent.
inline StageData owned_data(const StageData& data) {
    return owned(parity::find_binding(data.stage, data.stage), data);
}

inline StageData named(StageData data, const std::string& id) {
    data.id = data.label = id;
    return data;
}

// A rough wall with steps in depth, so that neighbours weigh anything from 0 to 1; every 11th pixel is empty.
inline Points steps(glm::ivec2 size, std::uint32_t seed) {
    Points p{Image4(size.x, size.y), Image4(size.x, size.y)};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if ((y * size.x + x) % 11 == 0) continue;
            const float z = ((x / 5 + y / 4) % 3 == 2 ? 2.5f : 2.0f) + 0.02f * noise(x, y, 0, seed);
            const glm::vec3 bump(noise(x, y, 2, seed) - 0.5f, noise(x, y, 3, seed) - 0.5f, noise(x, y, 4, seed) - 0.5f);
            p.position(x, y) = {0.01f * float(x), -0.01f * float(y), -z, z};
            p.normal(x, y) = glm::vec4(glm::normalize(glm::vec3(0, 0, 1) + 0.8f * bump), 1);
        }
    return p;
}
inline Image4 with_depth(Image4 image, const Image4& position) {
    for (std::size_t i = 0; i < image.size(); ++i)
        image.texels[i] = position.texels[i].w > 0 ? glm::vec4(glm::vec3(image.texels[i]), position.texels[i].w)
                                                   : glm::vec4(0);
    return image;
}

}  // namespace plumb::test
