// A room with lights of all kinds, and frames of it to compare: for stages that read what the camera and the lights see.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>

#include "tests/gi/moving_scene.h"

namespace plumb::test {

struct OpenRoom {
    int floor = 0;               // its material; -1: none
    float block_front = 0.3f;    // z, m; its back is at -0.3
    float key_z = 0.1f;          // of the spot, m
    double look_at_y = 0.9;      // m
    glm::ivec2 size{48, 40};
};

// Of 2 m, without its front, a block on its floor; a spot, a point light and a sun. Material 0 alone is made.
inline Scene open_room(const OpenRoom& room = {}) {
    Scene s;
    s.name = "room";
    s.materials.resize(1);
    s.materials[0].reflectance = glm::vec3(0.7f);
    Mesh& m = s.meshes.emplace_back();
    m.name = "room";
    const float front = room.block_front, deep = front + 0.3f;
    if (room.floor >= 0) moving::add_quad(m, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, room.floor);
    moving::add_quad(m, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 0);   // ceiling
    moving::add_quad(m, {-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, 0);   // back
    moving::add_quad(m, {-1, 0, 1}, {0, 0, -2}, {0, 2, 0}, 0);   // left
    moving::add_quad(m, {1, 0, -1}, {0, 0, 2}, {0, 2, 0}, 0);    // right
    moving::add_quad(m, {-0.3f, 0, front}, {0.6f, 0, 0}, {0, 0.6f, 0}, 0);         // block: front
    moving::add_quad(m, {-0.3f, 0.6f, front}, {0.6f, 0, 0}, {0, 0, -deep}, 0);     // top
    moving::add_quad(m, {0.3f, 0, -0.3f}, {-0.6f, 0, 0}, {0, 0.6f, 0}, 0);         // back
    s.lights.push_back(moving::spot("key", {0.1f, 1.9f, room.key_z}, {0, -1, 0}, 6));
    s.lights.push_back(moving::spot("bulb", {-0.6f, 1.2f, 0.2f}, {0, -1, 0}, 2));
    s.lights.back().type = LightType::point;
    s.lights.push_back(moving::spot("sun", {0, 0, 0}, {0.1f, -0.4f, -1}, 1));
    s.lights.back().type = LightType::directional;
    for (Light& light : s.lights) light.rsm_size = 64;
    s.camera.position = {0.3, 1.2, 3.4}, s.camera.look_at = {0, room.look_at_y, 0}, s.camera.up = {0, 1, 0};
    s.camera.fov_y_deg = 45, s.camera.near = 0.1, s.camera.far = 20;
    s.frame_size = room.size;
    return s;
}

inline frame::Frame render(const Scene& scene, const frame::Settings& settings, const RunOptions& options = {}) {
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}

// Of one size, not empty, and equal to the bit.
inline bool same(const Image4& a, const Image4& b) {
    return a.width == b.width && a.height == b.height && !a.empty() &&
           std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

inline bool has(const frame::Plan& plan, const std::string& label) {
    return std::any_of(plan.stages.begin(), plan.stages.end(), [&](const frame::PlannedStage& s) { return s.label == label; });
}

}  // namespace plumb::test
