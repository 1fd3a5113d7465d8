// What a [[mesh]] of a scene file, or a bare mesh file, brings along. Private to io/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/scene.h"
#include "io/gltf.h"
#include "io/scenes/generate.h"

namespace plumb::io {

struct SceneModel {
    Scene scene;                                // meshes, materials, textures; lights and camera where it has them
    std::vector<bool> has_texture_coordinates;  // of each mesh
    std::vector<std::vector<glm::vec2>> second_coordinates;  // of each mesh; empty: not asked for, or none of a format
    bool has_camera = false;
    bool is_whole = false;  // a generated scene: its settings, frame, method and the like are meant too
};

// .obj, .gltf or .glb, by the name's extension. options.strict is of all of them.
SceneModel load_model(const std::string& path, const GltfOptions& options);

// "cornell", or a scene of io/scenes. Throws InputError at `place` for options that the scene does not take.
SceneModel generate_model(const std::string& name, const GenerateOptions& options, const std::string& place);
std::vector<std::string> model_names();  // that can be generated

// Puts meshes, lights and camera where `transform` moves them.
void move_model(SceneModel& model, const glm::dmat4& transform);

// Appends meshes, materials and textures; lights and camera stay in the model.
void append_model(Scene& scene, SceneModel& model);

inline constexpr double max_exponent = 1e6;

// "" where a material reflects at most what it receives, within rounding; otherwise its name, the channel and the sum.
std::string excess_of(const Material& material);

// Gives tangents to meshes that show a normal map and have none.
void complete_tangents(Scene& scene);

}  // namespace plumb::io
