// A small frame whose stages are judged.
#pragma once

#include "core/scene.h"

namespace plumb::test {

// A floor and a wall under a spot and a point light, off the axes.
inline Scene small_scene() {
    Scene s;
    s.frame_size = {40, 30};
    s.camera.position = {0.13, 1.1, 3.1};
    s.camera.look_at = {0.02, 0.7, 0};
    s.materials.resize(1);
    s.materials[0].reflectance = {0.7f, 0.5f, 0.3f};
    s.materials[0].emission = {0.1f, 0, 0.05f};
    Mesh mesh;
    auto quad = [&](glm::vec3 a, glm::vec3 u, glm::vec3 v, glm::vec3 n) {
        const unsigned first = unsigned(mesh.vertices.size());
        for (const glm::vec3& p : {a, a + u, a + u + v, a + v}) mesh.vertices.push_back({p, 0, n, 0});
        mesh.triangles.push_back(glm::uvec3(first, first + 1, first + 2));
        mesh.triangles.push_back(glm::uvec3(first, first + 2, first + 3));
        mesh.material.insert(mesh.material.end(), 2, 0);
    };
    quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, {0, 1, 0});
    quad({-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1});
    quad({-0.2f, 0.4f, 0.2f}, {0.5f, 0, 0}, {0, 0, -0.4f}, {0, 1, 0});
    s.meshes.push_back(mesh);
    Light spot;
    spot.name = "key light";
    spot.position = {0.2f, 1.9f, 0.4f};
    spot.intensity = {10, 9, 8};
    spot.rsm_size = 24;
    Light bulb = spot;
    bulb.name = "bulb";
    bulb.type = LightType::point;
    bulb.position = {-0.3f, 1.2f, 0.3f};
    s.lights = {spot, bulb};
    return s;
}

}  // namespace plumb::test
