// glTF 2.0 and GLB. See io/README.md for what is read, what is ignored and what is refused.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

struct GltfOptions {
    bool photometric_as_is = false;  // keep candela and lux as W/sr and W/m2; otherwise divide them by 683 lm/W
    bool second_coordinates = false;  // also read TEXCOORD_1
    bool strict = false;  // refuse a file that requires an extension which is not read, also one that changes looks alone
};

// The default scene of one file, in metres. A node that has a mesh is a Mesh of its own, with the node's transform.
struct GltfModel {
    std::vector<Mesh> meshes;
    std::vector<bool> has_texture_coordinates;  // of each mesh
    std::vector<std::vector<glm::vec2>> second_coordinates;  // of each mesh, if asked for: TEXCOORD_1 of each vertex;
                                                             // empty where a primitive of the mesh has none
    std::vector<Material> materials;            // those of the file; and "default", last, where a primitive has none
    std::vector<Texture> textures;              // those that the materials show
    std::vector<Light> lights;                  // named uniquely, as layers are
    bool has_camera = false;
    Camera camera;                              // the first of the scene
    std::vector<std::string> notes;             // what was left out or chosen
};

// Throws InputError that names the file, the place as a JSON pointer ("/meshes/0/primitives/1/indices") and the cause,
// for anything that is not a whole and finite model.
GltfModel read_gltf(const std::string& path, const GltfOptions& options = {});
// The same of a file in memory: `path` names it in messages, and other files are beside it.
GltfModel parse_gltf(const std::string& path, std::vector<unsigned char> file, const GltfOptions& options = {});

}  // namespace plumb::io
