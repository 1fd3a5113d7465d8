// What the stages' keys are made of. Private to gi/frame.
#pragma once

#include <cstdint>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::frame {

// A hash of each part of a scene that stages read. Names are no part of any.
struct SceneKeys {
    std::uint64_t geometry = 0;  // what flatten() reads of the meshes
    std::uint64_t surfaces = 0;  // what a light sees reflected: reflectance, normals, alpha, and all textures
    std::uint64_t emission = 0;
    std::uint64_t paths = 0;     // all that rays can meet, and the lamps
};
SceneKeys scene_keys(const Scene& scene);

// As stage_keys() of kept.h, where the scene's are there already.
std::vector<std::uint64_t> stage_keys(const SceneKeys& scene_keys, const Scene& scene, const Settings& settings,
                                      const Plan& plan, Isa isa);

// Of the tone curve alone.
std::uint64_t tonemap_key(const Settings& settings);

// A light that does not shine has no intensity: running its stages adds zeros.
Light shining(Light light);

}  // namespace plumb::frame
