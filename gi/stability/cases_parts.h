// Builds the scene of the cases, a room with three lights, and changes it.
#pragma once

#include <array>
#include <span>

#include "gi/stability/cases.h"

namespace plumb::stability {

// A room of 2 x 2 x 2 m without ceiling and front, on the floor y = 0 around the origin, with a box in it: a texture
// with levels of detail, a normal map, a coloured wall, something that emits. Three lights of little maps: the spot
// "key", the point light "lamp", the sun "sun". 48 x 32 pixels.
Scene room();
enum RoomMesh : int { floor_mesh, back_mesh, left_mesh, right_mesh, box_mesh };
enum RoomMaterial : int { tiles, bumps, red, green, glow };
enum RoomLight : int { key, lamp, sun };

// Counter-clockwise seen from its front; texture coordinates run over the image once.
Mesh quad(const std::string& name, const std::array<glm::vec3, 4>& corners, int material);
// Any triangles, three corners each, with the normals of their faces.
Mesh triangles(const std::string& name, const std::vector<glm::vec3>& corners, int material);
// Horizontal, of 2 half a side, around the origin at height y.
Mesh plain(double half, double y, int material);

// Meshes, lights and camera; the lights' intensities go with the square, so that irradiance stays.
void scale(Scene& scene, double by);
void move(Scene& scene, const glm::dvec3& by);

// A power of ten as names have it: "1e-4", "1e8".
std::string power_text(double power);

// An input as floats; empty where the stage has none of that name.
std::span<float> input_floats(StageData& data, const std::string& name);

// The groups, in their order.
std::vector<Case> extent_cases();    // scale, offset, near and far
std::vector<Case> geometry_cases();  // w, triangles, normals
std::vector<Case> light_cases();     // lights, grazing light, reflectance
std::vector<Case> frame_cases();     // sizes, storage, settings
std::vector<Case> edited_cases();    // distances, denormals

}  // namespace plumb::stability
