// Material libraries of OBJ. Private to io/.
#pragma once

#include <string>
#include <vector>

#include "io/findings.h"
#include "io/obj.h"

namespace plumb::io {

// Where a material's pictures lie on its faces: u, v of the file times `scale`, plus `offset`; v counts from the bottom.
struct Mapping {
    glm::dvec2 scale{1}, offset{0};
    friend bool operator==(const Mapping& a, const Mapping& b) { return a.scale == b.scale && a.offset == b.offset; }
};

struct MtlMaterial {
    Material material;
    Mapping mapping;
};

// The materials of an MTL file. Their pictures, from beside it or from `second_folder`, go to the model's textures; what is
// changed or left out, to its notes; what is lacking, to `findings`. Throws InputError for what is malformed.
std::vector<MtlMaterial> parse_mtl(const std::string& path, const std::string& text, const std::string& second_folder,
                                   ObjModel& model, Findings& findings);

}  // namespace plumb::io
