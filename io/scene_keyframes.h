// [[keyframe]] and [[motion]] of a scene file: what moves from frame to frame. Private to io/.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"
#include "io/toml_reader.h"

namespace plumb::io {

// A [[mesh]] that has a name: keyframes move all meshes of it as one.
struct NamedMesh {
    std::string name;
    glm::dvec3 origin{0};  // m, world: where it puts its own origin
};

// Reads all of them into scene.animation, marks what moves as dynamic and leaves the scene in its pose at frame 0.
void read_keyframes(TomlReader& top, const std::string& path, const std::vector<NamedMesh>& named, Scene& scene);

}  // namespace plumb::io
