// Procedural scenes as files: the same bytes on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/scenes/generate.h"

namespace plumb::io {

struct SceneSummary {
    std::string name, summary;
    std::int64_t triangles = 0;  // by default
    bool adjustable = true;      // takes GenerateOptions
};
std::vector<SceneSummary> scene_summaries();

struct MadeScene {
    std::string file;  // its TOML
    std::int64_t meshes = 0, triangles = 0, vertices = 0, materials = 0, textures = 0, lights = 0;
};

// Writes the scene's files into the folder, which is made if it is not there: NAME.toml and the mesh that it names, a
// GLB that any other program opens (an OBJ for "cornell"). The TOML shows the same picture, bit for bit, as one that
// says generate = "NAME". Throws InputError for an unknown name (naming the nearest), for options that the scene does
// not take, and for a folder that cannot be written.
MadeScene make_scene(const std::string& name, const std::string& folder, const GenerateOptions& options = {});

// The scene as TOML that takes its meshes from `mesh_file`; `heading` becomes its first line, a comment.
std::string scene_toml(const Scene& scene, const std::string& mesh_file, const std::string& heading);

}  // namespace plumb::io
