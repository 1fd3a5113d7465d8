// Wavefront OBJ and MTL. See io/README.md for what is read, what is ignored and what is refused.
#pragma once

#include <functional>
#include <optional>
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

// Throws InputError that names file, line and cause, for anything that is not a whole and finite model. What is lacking (a
// library, a picture, a material) or not known is replaced by a default and said in the notes; `strict` refuses it.
ObjModel read_obj(const std::string& path, bool strict = false);

// A material library as an OBJ names it. `findings` null: as the name stands, and no similar file.
class Findings;
struct Library {
    std::string file, text;
};
using ReadLibrary =
    std::function<std::optional<Library>(const std::string& name, std::int64_t line, Findings* findings)>;
// The same from text: `path` names it in messages.
ObjModel parse_obj(const std::string& path, const std::string& text, const ReadLibrary& read_library, bool strict = false);

}  // namespace plumb::io
