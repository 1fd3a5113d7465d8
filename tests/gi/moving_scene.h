// A small scene in which everything can move, and comparison of whole frames. For tests of frames that reuse.
#pragma once

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "core/animation.h"
#include "gi/frame/frame.h"

namespace plumb::moving {

// A quad from a corner and two sides, in the mesh's own space; counter-clockwise seen from its front.
inline void add_quad(Mesh& mesh, glm::vec3 a, glm::vec3 u, glm::vec3 v, int material) {
    const glm::vec3 n(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    const glm::vec3 unit = normalize3<float>(n), along = normalize3<float>(u);
    const unsigned first = unsigned(mesh.vertices.size());
    const float corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (const auto& [s, t] : corners) mesh.vertices.push_back({a + u * s + v * t, s, unit, t});
    mesh.tangents.insert(mesh.tangents.end(), 4, glm::vec4(along, 1));
    mesh.triangles.push_back(glm::uvec3(first, first + 1, first + 2));
    mesh.triangles.push_back(glm::uvec3(first, first + 2, first + 3));
    mesh.material.insert(mesh.material.end(), 2, material);
}

inline Texture checker(const char* name, std::uint32_t a, std::uint32_t b, bool srgb) {
    Texture t;
    t.name = name, t.srgb = srgb;
    t.texels = Image<std::uint32_t>(4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) t.texels(x, y) = (x + y) % 2 ? a : b;
    return t;
}

inline Light spot(const char* name, glm::vec3 position, glm::vec3 direction, float intensity) {
    Light light;
    light.name = name, light.position = position, light.direction = normalize3<float>(direction);
    light.cone_inner_deg = 50, light.cone_outer_deg = 60;
    light.intensity = glm::vec3(intensity), light.rsm_size = 16;
    return light;
}

// A floor and a red wall with a picture, a cut-out, a bumpy and a glowing material; a block that may move; a spot "key",
// a sun, a point light "bulb".
inline Scene scene() {
    Scene s;
    s.name = "moving";
    s.textures = {checker("paint", 0xff808080, 0xffffffff, true), checker("bumps", 0xffff8060, 0xffff80a0, false),
                  checker("glow", 0xff000000, 0xffffffff, true), checker("holes", 0x00ffffff, 0xffffffff, true)};
    s.materials.resize(4);
    s.materials[0].name = "floor", s.materials[0].reflectance = {0.7f, 0.7f, 0.7f}, s.materials[0].texture = 0;
    s.materials[0].normal_texture = 1;
    s.materials[1].name = "wall", s.materials[1].reflectance = {0.6f, 0.1f, 0.1f};
    s.materials[1].emission = {0.2f, 0.1f, 0}, s.materials[1].emission_texture = 2;
    s.materials[2].name = "block", s.materials[2].reflectance = {0.2f, 0.5f, 0.3f};
    s.materials[2].specular = glm::vec3(0.2f), s.materials[2].mirror = glm::vec3(0.1f);
    s.materials[3].name = "grid", s.materials[3].texture = 3, s.materials[3].alpha_cutoff = 0.5f;
    s.meshes.resize(3);
    s.meshes[0].name = "room", s.meshes[1].name = "block", s.meshes[2].name = "grid";
    add_quad(s.meshes[0], {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 0);
    add_quad(s.meshes[0], {-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, 1);
    add_quad(s.meshes[1], {-0.3f, 0, 0.3f}, {0.6f, 0, 0}, {0, 0, -0.6f}, 2);
    s.meshes[1].transform[3] = {0, 0.5, 0, 1};
    add_quad(s.meshes[2], {-0.9f, 0.1f, -0.5f}, {0.5f, 0, 0}, {0, 0.8f, 0}, 3);
    s.lights = {spot("key", {0, 1.9f, 0.2f}, {0, -1, 0}, 10), spot("sun", {0, 0, 0}, {0.3f, -1, -0.4f}, 2),
                spot("bulb", {0.6f, 0.9f, 0.4f}, {0, -1, 0}, 1)};
    s.lights[1].type = LightType::directional, s.lights[2].type = LightType::point, s.lights[2].rsm_size = 8;
    s.environment.radiance = glm::vec3(0.1f, 0.2f, 0.3f);
    s.environment.map = Image4(4, 2, glm::vec4(1));
    s.camera.position = {0, 1, 3.4}, s.camera.look_at = {0, 0.8, 0};
    s.frame_size = {20, 14};
    return s;
}

// Motions over ten frames.
inline void move_camera(Scene& s) {
    s.animation.camera.position = {{0, {0, 1, 3.4}}, {9, {0.8, 1.3, 3}}};
    s.animation.camera.fov_y_deg = {{0, {45, 0, 0}}, {9, {50, 0, 0}}};
}
inline void move_light(Scene& s, int light) {
    LightTracks tracks;
    tracks.light = light;
    tracks.position = {{0, {0, 1.9, 0.2}}, {9, {0.3, 1.7, 0.4}}};
    tracks.direction = {{0, {0, -1, 0}}, {9, {0.28, -0.96, 0}}};
    s.animation.lights.push_back(tracks);
}
inline void switch_light(Scene& s, int light) {
    LightTracks tracks;
    tracks.light = light;
    tracks.on = {{0, {1, 0, 0}}, {3, {0, 0, 0}}, {6, {1, 0, 0}}};
    s.animation.lights.push_back(tracks);
}
inline void move_block(Scene& s) {
    MeshTracks tracks;
    tracks.name = "block", tracks.meshes = {{1, s.meshes[1].transform}}, tracks.pivot = {0, 0.5, 0};
    tracks.translate = {{0, {0, 0, 0}}, {9, {0.4, 0.3, 0.2}}};
    tracks.rotate_deg = {{0, {0, 0, 0}}, {9, {60, 20, 0}}};
    s.animation.meshes.push_back(tracks);
}

template <class T>
std::string bytes(const T* data, std::size_t n) {
    return std::string(reinterpret_cast<const char*>(data), n * sizeof(T));
}
template <class T>
std::string bytes(const Image<T>& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height) + " " + bytes(image.data(), image.size());
}

// Every buffer of a frame by name, all bits of it.
inline std::map<std::string, std::string> buffers(const frame::Frame& f, glm::ivec2 size) {
    std::map<std::string, std::string> b;
    const raster::GBuffer& g = f.gbuffer;
    b["gbuffer"] = bytes(g.position) + bytes(g.normal) + bytes(g.albedo) + bytes(g.emission) + bytes(g.depth) +
                   bytes(g.id);
    for (std::size_t l = 0; l < f.rsms.size(); ++l) {
        std::string& maps = b["rsm " + std::to_string(l)];
        maps = std::to_string(f.rsms[l].size());
        for (const raster::Rsm& r : f.rsms[l])
            maps += bytes(r.position) + bytes(r.normal) + bytes(r.flux) + bytes(r.records.data(), r.records.size()) +
                    bytes(r.half_records.data(), r.half_records.size()) + std::to_string(r.size);
        const std::size_t pixels = std::size_t(size.x) * std::size_t(size.y);
        b["shadow " + std::to_string(l)] = bytes(f.visibility.data() + l * pixels, pixels);
    }
    b["visibility"] = std::to_string(f.visibility.size());
    b["shadows filtered"] = bytes(f.visibility_filtered.data(), f.visibility_filtered.size()) +
                            bytes(f.visibility_across.data(), f.visibility_across.size());
    b["direct"] = bytes(f.direct), b["indirect"] = bytes(f.indirect), b["error"] = bytes(f.indirect_error);
    b["radiance"] = bytes(f.radiance), b["display"] = bytes(f.display), b["truth_display"] = bytes(f.truth_display);
    b["sent"] = bytes(f.zbuffer.sent) + bytes(f.zbuffer.vertex_light.diffuse) + bytes(f.zbuffer.vertex_light.specular);
    std::string layers;
    for (const frame::Traced& t : f.traced) {
        layers += t.layer + " ";
        b["traced " + t.layer] = bytes(t.estimate.mean) + bytes(t.estimate.error) + std::to_string(t.estimate.samples);
        for (const std::string& without : t.without) b["traced " + t.layer] += without;
    }
    b["layers"] = layers;
    return b;
}

// The names of the buffers that differ.
inline std::vector<std::string> differences(const frame::Frame& a, const frame::Frame& b, glm::ivec2 size) {
    const auto x = buffers(a, size), y = buffers(b, size);
    std::vector<std::string> names;
    for (const auto& [name, value] : x)
        if (!y.contains(name) || y.at(name) != value) names.push_back(name);
    for (const auto& [name, value] : y)
        if (!x.contains(name)) names.push_back(name);
    return names;
}

}  // namespace plumb::moving
