// Scenes from files: TOML as io/README.md lists its keys, or a bare .obj.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

// `method_tables` are the tables whose keys are passed on as Scene::settings ("rsm", "shadow", ...). What the file
// leaves open is chosen and said in Scene::notes. Scene::name is `path`. Throws InputError with file, line and cause.
//
// What a mesh's file lacks (a picture, a library, a material) is replaced by a default and said in the notes; `strict`
// refuses it.
struct LoadOptions {
    bool strict = false;
};
Scene load_scene(const std::string& path, const std::vector<std::string>& method_tables, const LoadOptions& options = {});

// Of each mesh of a scene a coordinate for each vertex: TEXCOORD_1 of glTF, where lightmaps lie; empty where the mesh has
// none. No stage reads them, so they lie beside the scene.
using SecondCoordinates = std::vector<std::vector<glm::vec2>>;
Scene load_scene(const std::string& path, const std::vector<std::string>& method_tables, SecondCoordinates& second,
                 const LoadOptions& options = {});

}  // namespace plumb::io
