// What the keys of stages (gi/graph/graph.h) say of the scene. Private to gi/frame.
#pragma once

#include <cstdint>

#include "core/scene.h"
#include "gi/frame/settings.h"

namespace plumb::frame {

// A hash of each part of a scene that stages read other than as parameters. Names are no part of any.
struct SceneKeys {
    std::uint64_t geometry = 0;  // what flatten() reads of the meshes
    std::uint64_t surfaces = 0;  // what a light sees reflected: reflectance, normals, alpha, and all textures
    std::uint64_t emission = 0;
    std::uint64_t paths = 0;     // all that rays can meet, and the lamps
    std::uint64_t fixed = 0;     // `geometry` of what stands still; 0 where nobody asks
};
SceneKeys scene_keys(const Scene& scene);
// With what the settings drop of the scene, or read a part of.
SceneKeys scene_keys(const Scene& scene, const Settings& settings);

// A light that does not shine has no intensity: running its stages adds zeros.
Light shining(Light light);

}  // namespace plumb::frame
