// A scene as one GLB file that any other program can open.
//
// What comes back from read_gltf() is the same, bit for bit: positions, normals, texture coordinates, tangents, the
// triangles in their order, materials, textures that a material shows, lights. The camera agrees within rounding.
#pragma once

#include <string>

#include "core/scene.h"

namespace plumb::io {

// Meshes without triangles are left out. Throws InputError for a scene that glTF cannot hold (a number that is not
// finite, 4 GiB) and for a path that cannot be written; what was at the path stays until the file is complete.
void write_glb(const std::string& path, const Scene& scene);

}  // namespace plumb::io
