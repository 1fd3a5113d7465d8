// Wavefront OBJ and MTL. See io/README.md for what is read, what is ignored and what is refused.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

// The contents of one OBJ: all its groups in one mesh, whose material indices count in `materials`, whose texture
// indices count in `textures`.
struct ObjModel {
    Mesh mesh;
    std::vector<Material> materials;  // those of its MTL files; and "default", last, where a face has none
    std::vector<Texture> textures;
    std::vector<std::string> notes;  // what was changed to fit
    bool has_texture_coordinates = false;  // of at least one corner
};

// Throws InputError that names file, line and cause, for anything that is not a whole and finite model.
ObjModel read_obj(const std::string& path);

// The same from text: `path` names it in messages; `read_library` gives the text of an MTL file by the path of that
// file, as found beside the OBJ.
using ReadLibrary = std::function<std::string(const std::string& path)>;
ObjModel parse_obj(const std::string& path, const std::string& text, const ReadLibrary& read_library);

// The materials of an MTL file and, into `textures`, their pictures, read from beside it; into `notes` what had to be
// changed.
std::vector<Material> parse_mtl(const std::string& path, const std::string& text, std::vector<Texture>& textures,
                                std::vector<std::string>& notes);

}  // namespace plumb::io
